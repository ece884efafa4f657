//! Location errors in a notation of the literature.

use crate::number::finite;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_methods::notation;

/// Location errors in one notation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LocationErrors {
    /// `absolute` (lines in the machine coordinate system) or `relative` (lines against the carrying axis).
    pub notation: String,
    /// Every location error of the machine.
    pub values: Vec<LocationError>,
}

/// One location error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LocationError {
    /// Symbol in the notation, e.g. `EB0C`.
    pub symbol: String,
    /// The axis.
    pub axis: String,
    /// Against what: an axis, or `machine`.
    pub against: String,
    /// Value in `unit`; null when it depends on what the runs do not observe.
    pub value: Option<f64>,
    /// Standard uncertainty in `unit`.
    pub u: Option<f64>,
    /// Unit.
    pub unit: String,
    /// Parameters that these runs give no number to and on which it depends: it has no number either.
    pub without_number: Vec<String>,
}

impl LocationErrors {
    /// These errors in this notation.
    pub fn new(notation: notation::Notation, errors: &[notation::LocationError]) -> Self {
        let value = |error: &notation::LocationError| {
            let unit = error.unit();
            let screen = |x: Option<f64>| x.map(|x| x * unit.per_inside).and_then(finite);
            LocationError {
                symbol: error.symbol.clone(),
                axis: error.component.axis.to_string(),
                against: match notation {
                    notation::Notation::Relative => error.component.against.to_string(),
                    notation::Notation::Absolute => "machine".into(),
                },
                value: screen(error.value),
                u: screen(error.u),
                unit: unit.symbol.into(),
                without_number: error.without_number.clone(),
            }
        };
        Self { notation: notation.name().into(), values: errors.iter().map(value).collect() }
    }
}
