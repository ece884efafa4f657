//! Circle, line, plane and sphere through points by least squares of the orthogonal distances.
//!
//! Line and plane: eigenvectors of the scatter about the centroid. Circle and sphere: Gauss–Newton on
//! `d_i = |p_i − c| − r` from the algebraic fit (Gander, Golub, Strebel 1994; Forbes 1989, NPL DITC 140/89).
//! Units are those of the points (mm); frames those of the points.

mod circle;
mod line;
mod plane;
mod round;
mod scatter;
mod sphere;

pub use circle::{Circle, circle};
pub use line::{Line, line};
pub use plane::{Plane, plane};
pub use sphere::{Sphere, sphere};

use thiserror::Error;

/// Why a shape cannot be put through points.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GeometryError {
    /// Fewer points than the shape has unknowns.
    #[error("a {shape} needs at least {least} points, there are {found}; measure more points")]
    TooFew {
        /// Which shape.
        shape: &'static str,
        /// Points needed.
        least: usize,
        /// Points given.
        found: usize,
    },
    /// The points lie so that many shapes fit alike.
    #[error("the points do not determine a {shape}: {why}; spread the points")]
    Undetermined {
        /// Which shape.
        shape: &'static str,
        /// How the points lie.
        why: &'static str,
    },
    /// A coordinate is no finite number.
    #[error("point {point} of the {shape} is no finite number; remove it")]
    NotFinite {
        /// Which shape.
        shape: &'static str,
        /// Index of the point, from zero.
        point: usize,
    },
}
