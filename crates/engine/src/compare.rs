//! Where a model fails: the worst places of the residual.

mod frames;
mod places;

pub use places::{AxisRange, Place, Region, places};
