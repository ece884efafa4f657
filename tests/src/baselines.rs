//! What else one would do with the same columns: plain methods of choosing some of many, beside which the blind trial sets the diagnosis.

mod forward;
mod omp;
mod problem;
mod stlsq;
#[cfg(test)]
mod tests;

pub use problem::{Baseline, Library};

use nalgebra::DVector;
use problem::Problem;
use std::collections::BTreeSet;

/// All of them.
pub const BASELINES: [Baseline; 3] = [stlsq::BASELINE, omp::BASELINE, forward::BASELINE];

/// The effects that each method names, in the order of [`BASELINES`].
pub fn named(library: &Library, readings: &DVector<f64>) -> Vec<BTreeSet<String>> {
    let problem = Problem::new(library, readings);
    let effects = |chosen: Vec<usize>| chosen.into_iter().map(|j| library.effect_of[j].clone()).collect();
    BASELINES.iter().map(|baseline| effects((baseline.chosen)(&problem))).collect()
}
