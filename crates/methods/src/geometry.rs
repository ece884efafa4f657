//! Circle, line, plane and sphere through points by least squares of the orthogonal distances; minimum-zone circles.
//!
//! Line and plane: eigenvectors of the scatter about the centroid. Circle and sphere: Gauss–Newton on
//! `d_i = |p_i − c| − r` from the algebraic fit (Gander, Golub, Strebel 1994; Forbes 1989, NPL DITC 140/89).
//! Units are those of the points (mm); frames those of the points.

mod circle;
mod error;
mod line;
mod minimum_zone;
mod plane;
mod round;
mod scatter;
mod sphere;

pub use error::GeometryError;

pub use circle::{Circle, circle};
pub use line::{Line, line};
pub use minimum_zone::minimum_zone;
pub use plane::{Plane, plane};
pub use sphere::{Sphere, sphere};
