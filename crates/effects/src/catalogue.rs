//! One file per physical effect, one line here. A test walks the directory and this list.

mod angular_motion;
mod artefact_form;
mod axial_error_motion;
mod backlash;
mod ball_form;
mod ball_setting;
mod ballscrew_pitch;
mod clamp_shift;
mod component_errors;
mod direction_shift;
mod drive_pitch;
mod encoder_eccentricity;
mod gravity_sag;
mod inertial_deflection;
mod linear_scale;
mod location_errors;
mod nest_rotation;
mod probe_crosstalk;
mod probe_gain;
mod probe_nonlinearity;
mod radial_error_motion;
mod reversal_spike;
mod servo_lag;
mod setup_slip;
mod spindle_growth;
mod squareness;
mod stacked_tilt;
mod straightness;
mod sync_delay;
mod thermal_drift;
mod thermal_expansion;
mod tilt_error_motion;
mod unbalance;
mod vibration;

pub use encoder_eccentricity::encoder_amplitude_rad;
pub use location_errors::conventional_zeros;

use crate::Effect;

/// Every effect; the two base effects first.
pub static REGISTRY: &[&Effect] = &[
    &location_errors::EFFECT,
    &ball_setting::EFFECT,
    &gravity_sag::EFFECT,
    &unbalance::EFFECT,
    &thermal_drift::EFFECT,
    &thermal_expansion::EFFECT,
    &spindle_growth::EFFECT,
    &backlash::EFFECT,
    &direction_shift::EFFECT,
    &reversal_spike::EFFECT,
    &encoder_eccentricity::EFFECT,
    &drive_pitch::EFFECT,
    &radial_error_motion::EFFECT,
    &axial_error_motion::EFFECT,
    &tilt_error_motion::EFFECT,
    &stacked_tilt::EFFECT,
    &linear_scale::EFFECT,
    &straightness::EFFECT,
    &angular_motion::EFFECT,
    &component_errors::EFFECT,
    &squareness::EFFECT,
    &ballscrew_pitch::EFFECT,
    &servo_lag::EFFECT,
    &sync_delay::EFFECT,
    &inertial_deflection::EFFECT,
    &clamp_shift::EFFECT,
    &setup_slip::EFFECT,
    &probe_gain::EFFECT,
    &probe_nonlinearity::EFFECT,
    &nest_rotation::EFFECT,
    &probe_crosstalk::EFFECT,
    &ball_form::EFFECT,
    &artefact_form::EFFECT,
    &vibration::EFFECT,
];

/// Id of the effect that holds the location errors of the rotary axes.
pub const LOCATION_ERRORS: &str = "location-errors";

/// Ids of the effects that are always in the model.
pub const BASE: [&str; 2] = [LOCATION_ERRORS, "ball-setting"];

/// The effect that an id names, `gravity-sag` of `gravity-sag:B`; `None` for an expression or a foreign id.
pub fn effect(id: &str) -> Option<&'static Effect> {
    let phenomenon = id.split(':').next()?;
    REGISTRY.iter().copied().find(|effect| effect.phenomenon == phenomenon)
}

/// `Title (id)`, as sentences say it; the id alone of what the catalogue does not know.
pub fn effect_name(id: &str) -> String {
    effect(id).map_or(id.into(), |effect| format!("{} ({id})", effect.about.title))
}
