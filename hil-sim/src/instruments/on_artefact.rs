//! What is off about an artefact that a person places: its origin, its turn, and the radius of what touches it.

use crate::physics::natural::normal_vector;
use crate::truth::{Own, PlacedSetup, SimSetup};
use rand_chacha::ChaCha8Rng;

/// How far an artefact is off its place and how far it is turned.
const ARTEFACT_MM: f64 = 0.1;
pub(super) const ARTEFACT_RAD: f64 = 300e-6;
/// Radius of a stylus or a tool.
pub(super) const RADIUS_MM: f64 = 5e-3;

/// A placed artefact; `radius_mm` is how far the radius of what touches it is off.
pub(super) fn placed(setup: &SimSetup, radius_mm: f64, rng: &mut ChaCha8Rng) -> PlacedSetup {
    let (setting_mm, turn_rad) = (normal_vector(rng) * ARTEFACT_MM, normal_vector(rng) * ARTEFACT_RAD);
    let zero_mm = radius_mm * normal_vector(rng).x;
    let own = Own { turn_rad, zero_mm, ..Own::default() };
    PlacedSetup { own, ..PlacedSetup::new(setup, setting_mm) }
}
