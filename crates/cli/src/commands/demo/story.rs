//! What the demo tells.

use std::path::Path;
use trunnion::analysis::Analysis;
use trunnion::page;
use trunnion_core::convert;
use trunnion_engine::compare::residual_views;
use trunnion_engine::{Experiment, Identification, Verdict};
use trunnion_hil_sim::VirtualMachine;
use trunnion_hil_sim::physics::hidden;
use trunnion_report::{ladder_text, repeatability};

/// The ladder as it grows: base model, what fails, which effect, added, error falls.
pub(super) fn story(experiment: &Experiment, analysis: &Analysis) -> String {
    let um = convert::um_from_mm;
    let noise = |fit: &Identification| fit.repeatability.map(|noise| um(noise.sigma_mm));
    let fits =
        std::iter::once(&analysis.before).chain(analysis.steps.iter().map(|step| &step.identification));
    let steps = analysis.steps.iter().map(Some).chain([None]);
    let mut text = format!(
        "Base model (location errors and ball setting): {:.2} µm rms remain ({}).\n",
        um(analysis.before.rms_mm),
        repeatability(noise(&analysis.before)),
    );
    for ((diagnosis, fit), step) in analysis.diagnoses.iter().zip(fits).zip(steps) {
        if diagnosis.verdict != Verdict::NoiseFloor {
            text += "\nWhere does the model fail most?\n";
            for place in residual_views(experiment, &fit.residual_mm, &fit.used).worst {
                text += &format!("  {place}\n");
            }
            text += "What is missing?\n";
            for candidate in diagnosis.candidates.iter().take(3) {
                text += &format!(
                    "  {:24} evidence 10^{:<6.0} error would fall to {:.2} µm\n",
                    candidate.effect, candidate.evidence, candidate.rms_um_after
                );
            }
            if let Some(best) = diagnosis.candidates.first() {
                text += &format!("  {}\n", best.why);
            }
        }
        if let Some(row) =
            step.and_then(|step| step.entry.ladder.as_ref().map(|row| (step.entry.id.as_str(), row)))
        {
            let (effect, row) = row;
            let held_out = row.holdout_before_um.zip(row.holdout_after_um);
            text += &format!(
                "Added {effect}: error {:.2} -> {:.2} µm{}.\n",
                row.error_before_um,
                row.error_after_um,
                held_out.map_or(String::new(), |(b, a)| format!(
                    ", on passes left out of the fit {b:.2} -> {a:.2} µm"
                )),
            );
        }
    }
    text += &match analysis.diagnosis().verdict {
        Verdict::NoiseFloor => "\nNothing is missing: what remains is noise.\n".to_string(),
        Verdict::UnnamedStructure => match &analysis.diagnosis().formula {
            Some(formula) => format!(
                "\nSomething remains that no effect of the catalogue describes: {} = {} at {}. {}.\n",
                formula.component, formula.expression, formula.site, formula.lives
            ),
            None => "\nSomething remains that no effect of the catalogue describes.\n".into(),
        },
        Verdict::MissingEffect => "\nMore may be missing; the demo stops adding here.\n".into(),
    };
    if !analysis.steps.is_empty() {
        text += "\n";
        text += &ladder_text(&page::ladder(&analysis.model), noise(analysis.identification()));
    }
    let outliers = analysis.identification().outliers.len();
    text += &format!("\n{} points, {outliers} set aside as outliers.\n", experiment.points.len());
    text
}

/// What was hidden, what was found, and the location errors of both.
pub(super) fn truth_text(machine: &VirtualMachine, analysis: &Analysis, path: &Path) -> String {
    let truth = machine.truth();
    let hidden: Vec<String> = truth.hidden.iter().map(hidden::Hidden::id).collect();
    let found: Vec<&str> = analysis.steps.iter().map(|step| step.entry.id.as_str()).collect();
    let mut text = format!(
        "Hidden: {}. Found: {}. ({})\n",
        if hidden.is_empty() { "nothing".into() } else { hidden.join(", ") },
        if found.is_empty() { "nothing".into() } else { found.join(", ") },
        path.display(),
    );
    text += "  location error        truth      found          u\n";
    for error in trunnion_hil_sim::truth::minimum_set(machine.machine()) {
        let name = error.name();
        let (scale, unit) = if error.direction.is_rotary() { (1e6, "µrad") } else { (1e3, "µm") };
        let fitted = analysis.identification().parameter(&name);
        let value = fitted.and_then(|p| p.screen_value()).map_or("   unseen".into(), |v| format!("{v:9.2}"));
        let u = fitted.and_then(|p| p.screen_u()).map_or(String::new(), |u| format!("{u:9.2}"));
        text += &format!("  {name:14} {:>12.2}  {value}  {u} {unit}\n", error.of(&truth.location) * scale);
    }
    text
}
