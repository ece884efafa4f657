//! Everything the steps gave.

use super::location::Location;
use super::shape::{AxisShapes, Shape};
use super::track::Tracks;

/// Everything the steps gave.
pub(super) struct Found<'a> {
    pub(super) tracks: &'a Tracks,
    pub(super) shapes: &'a [Shape],
    pub(super) axes: &'a [AxisShapes],
    pub(super) location: Vec<Location>,
    /// The same location errors from what the joint fit of all effects predicts for these readings.
    pub(super) by_joint_fit: Vec<Location>,
    /// u of the location errors is under the noise that all readings show together.
    pub(super) noise_is_known: bool,
}
