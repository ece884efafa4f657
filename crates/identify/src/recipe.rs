//! What several named methods share: readings as displacements, readings of an axis that turns alone, and their means over
//! angle.

pub(crate) mod over_height;
pub(crate) mod relative;
pub(crate) mod stations;
pub(crate) mod turning;
