//! What a control could be given from a fit, in short: nothing where no error of an axis was seen.

use crate::axis_errors::ConfoundedErrors;
use crate::identification::{Identification, Parameter};
use crate::left_out::LeftOutEffect;
use crate::sentences::{is_clear, is_setting};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_methods as methods;

/// What a correction of the fitted model would hold, and what it would not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Correctable {
    /// Errors of the axes that a table can hold and that are clear of their standard uncertainty.
    pub clear: Vec<String>,
    /// Those that a table can hold and that may as well be zero.
    pub small: Vec<String>,
    /// Parameters of which only a combination is known.
    pub confounded: Vec<ConfoundedErrors>,
    /// Effects of the machine that are clear of their uncertainty and that no table of an axis holds, and why.
    pub left_out: Vec<LeftOutEffect>,
    /// Those that hold an error of an axis at rest as well: right only where that axis stood.
    #[serde(default)]
    pub at_rest: Vec<String>,
    /// Why no control can be given anything of this machine; empty otherwise.
    pub why: String,
}

impl Correctable {
    /// Of a fit and the tables of its axes.
    pub fn new(errors: &methods::AxisErrors, fit: &Identification) -> Self {
        let named = |of: &dyn Fn(&Parameter) -> bool| -> Vec<String> {
            let held = fit.parameters.iter().filter(|p| errors.effects.contains(&p.effect));
            held.filter(|p| of(p)).map(|p| p.name.clone()).collect()
        };
        let is_seen = |effect: &str| fit.parameters.iter().any(|p| p.effect == effect && is_clear(p));
        let left_out = errors.left_out.iter().filter(|left| {
            left.holds_axis_at_rest.is_none()
                && !errors.effects.contains(&left.effect)
                && !is_setting(&left.effect)
                && is_seen(&left.effect)
        });
        Self {
            clear: named(&is_clear),
            small: named(&|p| p.observable && !is_clear(p)),
            confounded: errors.confounded.iter().map(ConfoundedErrors::from).collect(),
            left_out: left_out.map(LeftOutEffect::from).collect(),
            at_rest: errors.left_out.iter().filter_map(|left| left.holds_axis_at_rest.clone()).collect(),
            why: String::new(),
        }
    }

    /// Of a machine whose control takes no such tables.
    pub fn nothing(why: &str) -> Self {
        Self { why: why.into(), ..Self::default() }
    }
}
