//! The compare page of an experiment, from the analysis of it.

use crate::analysis::Analysis;
use trunnion_core::Gap;
use trunnion_effects::Model;
use trunnion_engine::{Diagnosis, Experiment, Identification};
use trunnion_report::{CompareInput, LadderRow, compare_html};
use trunnion_results::TimeQuality;

/// The page after a whole analysis: the base model's diagnosis, the ladder, the final fit.
pub fn compare_page(
    experiment: &Experiment,
    analysis: &Analysis,
    losses: &[String],
    timing: &[TimeQuality],
) -> String {
    compare_html(&compare_input(
        experiment,
        analysis.identification(),
        Some(analysis.diagnosis()),
        &analysis.model,
        losses,
        timing,
    ))
}

/// What the page and the text tables show of one fit.
pub fn compare_input(
    experiment: &Experiment,
    identification: &Identification,
    diagnosis: Option<&Diagnosis>,
    model: &Model,
    losses: &[String],
    timing: &[TimeQuality],
) -> CompareInput {
    CompareInput {
        label: label(),
        ladder: ladder(model),
        losses: losses.to_vec(),
        timing: timing.to_vec(),
        ..CompareInput::new(experiment, identification, diagnosis.map(Into::into))
    }
}

/// What made a page.
pub fn label() -> String {
    format!("Trunnion {}", env!("CARGO_PKG_VERSION"))
}

/// The ladder rows that a model carries.
pub fn ladder(model: &Model) -> Vec<LadderRow> {
    trunnion_report::ladder_of(model)
}

/// Holes in the data, one sentence each.
pub fn losses(gaps: &[Gap], lost_samples: u64) -> Vec<String> {
    let mut losses: Vec<String> = gaps
        .iter()
        .map(|gap| {
            let lost = gap.lost_samples.map_or(String::new(), |n| format!(", {n} samples missing"));
            format!(
                "{}: nothing from {:.2} s to {:.2} s{lost} ({})",
                gap.source, gap.from_s, gap.to_s, gap.reason
            )
        })
        .collect();
    if lost_samples > 0 {
        losses.push(format!("{lost_samples} samples could not be written to disk"));
    }
    losses
}
