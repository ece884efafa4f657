//! Why a shape cannot be put through points.

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
