//! The six components of the error of an axis.

use trunnion_core::{Joint, Twist};
use trunnion_effects::Unit;

/// Symbol, unit, and how to take it from an error.
pub(super) type Component = (String, Unit, fn(&Twist) -> f64);

/// The six components of the error of an axis.
pub(super) fn components(axis: Joint) -> [Component; 6] {
    let symbol = |direction: Joint| format!("E{direction}{axis}");
    [
        (symbol(Joint::X), Unit::UM, |t| t.translation_mm.x),
        (symbol(Joint::Y), Unit::UM, |t| t.translation_mm.y),
        (symbol(Joint::Z), Unit::UM, |t| t.translation_mm.z),
        (symbol(Joint::A), Unit::URAD, |t| t.rotation_rad.x),
        (symbol(Joint::B), Unit::URAD, |t| t.rotation_rad.y),
        (symbol(Joint::C), Unit::URAD, |t| t.rotation_rad.z),
    ]
}

/// `ECC`, which is taken as zero.
pub(super) fn is_about_itself(symbol: &str) -> bool {
    symbol.chars().nth(1) == symbol.chars().nth(2)
}
