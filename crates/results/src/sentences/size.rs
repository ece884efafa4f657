//! How large a number of a fit is for the machine, and whether it is one.

use crate::Parameter;
use trunnion_core::LEVER_MM;

/// A parameter is worth reporting when it exceeds this many standard uncertainties.
const CLEAR_U: f64 = 3.0;

/// How far a value moves the tool, µm: a turn, or a scale, over 100 mm; `None` for a unit that is no shift of the tool.
pub fn at_tool_um(value: f64, unit: &str) -> Option<f64> {
    match unit {
        "um" => Some(value.abs()),
        "urad" | "um/m" => Some(value.abs() * LEVER_MM * 1e-3),
        _ => None,
    }
}

/// True for a number that is worth reporting.
pub fn is_clear(parameter: &Parameter) -> bool {
    parameter.value.zip(parameter.u).is_some_and(|(value, u)| value.abs() > CLEAR_U * u)
}
