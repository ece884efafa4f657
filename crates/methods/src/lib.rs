//! Named recipes of the literature, what stands behind a result, volumetric accuracy, notations, geometric fits.

pub mod attribution;
mod axis_errors;
mod common;
pub mod control_chart;
pub mod findings;
pub mod geometry;
pub mod notation;
pub mod recipes;
pub mod volumetric;

pub use axis_errors::{AxisErrors, AxisTable, Confounded, NotTabulated};
pub use findings::Findings;
