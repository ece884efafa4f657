//! One file per physical effect, one line here. A test walks the directory and this list.

mod ball_setting;
mod location_errors;

pub use location_errors::conventional_zeros;

use crate::Effect;

/// Every effect; the two base effects first.
pub static REGISTRY: [&Effect; 2] = [&location_errors::EFFECT, &ball_setting::EFFECT];

/// Ids of the effects that are always in the model.
pub const BASE: [&str; 2] = ["location-errors", "ball-setting"];
