//! The compare page of an experiment, from the analysis of it.

use crate::analysis::Analysis;
use trunnion_diagnose::Diagnosis;
use trunnion_effects::Model;
use trunnion_identify::{Experiment, Identification};
use trunnion_measurement::Gap;
use trunnion_report::{CompareInput, LadderRow, compare_html};

/// The page after a whole analysis: the base model's diagnosis, the ladder, the final fit.
pub fn compare_page(experiment: &Experiment, analysis: &Analysis, losses: &[String]) -> String {
    compare_html(&compare_input(
        experiment,
        analysis.identification(),
        Some(analysis.diagnosis()),
        &analysis.model,
        losses,
    ))
}

/// What the page and the text tables show of one fit.
pub fn compare_input(
    experiment: &Experiment,
    identification: &Identification,
    diagnosis: Option<&Diagnosis>,
    model: &Model,
    losses: &[String],
) -> CompareInput {
    CompareInput {
        label: format!("Trunnion {}", env!("CARGO_PKG_VERSION")),
        ladder: ladder(model),
        losses: losses.to_vec(),
        ..CompareInput::new(experiment, identification, diagnosis.cloned())
    }
}

/// The ladder rows that a model carries.
pub fn ladder(model: &Model) -> Vec<LadderRow> {
    let row = |entry: &trunnion_effects::ModelEffect| {
        let ladder = entry.ladder.as_ref()?;
        Some(LadderRow {
            effect: entry.id.clone(),
            date: ladder.date.clone(),
            run: ladder.run.clone(),
            fit_before_um: ladder.error_before_um,
            fit_after_um: ladder.error_after_um,
            holdout_before_um: ladder.holdout_before_um,
            holdout_after_um: ladder.holdout_after_um,
            largest_location_change: None,
        })
    };
    model.effects.iter().filter_map(row).collect()
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
