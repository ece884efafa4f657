//! What the demo prints.

use std::path::Path;
use trunnion::Analysed;
use trunnion::report::ladder_text;
use trunnion::results::Verdict;
use trunnion::results::number::{fixed, um};
use trunnion::results::sentences::{ALL_CLEAR, repeatability};
use trunnion_hil_sim::VirtualMachine;
use trunnion_hil_sim::physics::hidden;

/// The ladder as it grows: base model, what fails, which effect, added, error falls.
pub(super) fn story(analysed: &Analysed) -> String {
    let before = analysed.before().results();
    let mut text = format!(
        "Base model (location errors and ball setting): {} rms remain ({}).\n",
        um(before.rms_um),
        repeatability(before.noise_um, before.noise_readings),
    );
    let steps = analysed.steps().iter().map(Some).chain([None]);
    for (diagnosed, step) in analysed.diagnoses().iter().zip(steps) {
        let diagnosis = diagnosed.results();
        if diagnosis.verdict != Verdict::NoiseFloor {
            text += "\nWhere does the model fail most?\n";
            for place in diagnosed.fit().places() {
                text += &format!("  {}\n", place.words);
            }
            text += "What is missing?\n";
            for candidate in diagnosis.candidates.iter().take(3) {
                text += &format!(
                    "  {:24} evidence 10^{:<6.0} error would fall to {}\n",
                    candidate.effect,
                    candidate.evidence,
                    um(candidate.rms_um_after)
                );
            }
            if let Some(best) = diagnosis.candidates.first() {
                text += &format!("  {}\n", best.why);
            }
        }
        if let Some(step) = step {
            let row = step.row();
            let unit = diagnosis.residual.holdout_unit.map_or("data", |unit| unit.plural());
            let held_out = row.holdout_before_um.zip(row.holdout_after_um);
            text += &format!(
                "Added {}: error {} -> {}{}.\n",
                step.effect(),
                um(row.error_before_um),
                um(row.error_after_um),
                held_out.map_or(String::new(), |(before, after)| format!(
                    ", on {unit} left out of the fit {} -> {}",
                    um(before),
                    um(after)
                )),
            );
        }
    }
    let last = analysed.last().results();
    text += &match last.verdict {
        Verdict::NoiseFloor => format!("\n{ALL_CLEAR}\n"),
        Verdict::UnnamedStructure => match &last.formula {
            Some(formula) => format!(
                "\nSomething remains that no effect of the catalogue describes: {} = {} at {}. {}.\n",
                formula.component, formula.expression, formula.site, formula.location
            ),
            None => "\nSomething remains that no effect of the catalogue describes.\n".into(),
        },
        Verdict::Undecided => format!("\nThese data cannot say. {}\n", last.why),
        Verdict::MissingEffect => "\nMore may be missing; the demo stops adding here.\n".into(),
        Verdict::NotJudged => format!("\nThe runs were not judged. {}\n", last.why),
    };
    let fit = analysed.fit().results();
    if !analysed.steps().is_empty() {
        text += "\n";
        text += &ladder_text(&analysed.fit().model().ladder(), fit.noise_um);
    }
    text += &format!("\n{} points, {} excluded as outliers.\n", fit.points, fit.outliers);
    text
}

/// What was hidden, what was found, and the location errors of both.
pub(super) fn truth_text(machine: &VirtualMachine, analysed: &Analysed, path: &Path) -> String {
    let truth = machine.truth();
    let hidden: Vec<String> = truth.hidden.iter().map(hidden::Hidden::id).collect();
    let (found, fit) = (analysed.added(), analysed.fit().results());
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
        let fitted = fit.parameter(&name);
        let value = fitted.and_then(|p| p.value).map_or("unseen".into(), |value| fixed(value, 2));
        let u = fitted.and_then(|p| p.u).map_or(String::new(), |u| fixed(u, 2));
        let true_value = fixed(error.of(&truth.location) * scale, 2);
        text += &format!("  {name:14} {true_value:>12}  {value:>9}  {u:>9} {unit}\n");
    }
    text
}
