//! What a direction in parameter space is called, and what became of each parameter.

use serde::{Deserialize, Serialize};

/// How the number of a parameter came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// Determined by the data.
    Identified,
    /// Held at the value that the model file gives.
    Held,
    /// Confounded with others; zero by convention, so that those stand for it. No number.
    ZeroByConvention,
    /// Not observable. No number.
    Unobservable,
}

/// A direction in parameter space that moves no reading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unobservable {
    /// Parameter names with coefficients in screen units, e.g. `EX0A - EX0C`.
    pub direction: String,
    /// Names and coefficients (screen units) of the direction.
    pub terms: Vec<(String, f64)>,
    /// The same by index in [`crate::Identification::parameters`], inside units.
    pub inside: Vec<(usize, f64)>,
    /// Why, and what the numbers given mean.
    pub why: String,
    /// Its first parameter is of an axis at rest: the others stand for it only where that axis stood.
    pub at_rest: bool,
}

/// What a parameter is called and how its numbers are shown.
pub(crate) struct Named {
    pub name: String,
    pub unit: &'static str,
    pub per_inside: f64,
}
