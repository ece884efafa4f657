//! What the demo prints.

use std::path::Path;
use trunnion::report::ladder_text;
use trunnion::results::number::{fixed, odds, um};
use trunnion::results::sentences::{ALL_CLEAR, repeatability};
use trunnion::results::{Diagnosis, Identification, LadderRow, Verdict};
use trunnion::{Analysed, Diagnosed, Fit};
use trunnion_hil_sim::VirtualMachine;
use trunnion_hil_sim::physics::hidden;

/// The ladder as it grows: base model, what fails, which effect, added, error falls.
pub(super) fn story(analysed: &Analysed) -> String {
    let mut text = of_base(analysed);
    let steps = analysed.steps().iter().map(Some).chain([None]);
    for (diagnosed, step) in analysed.diagnoses().iter().zip(steps) {
        text += &failing(diagnosed);
        if let Some(step) = step {
            let row = step.row();
            let unit = diagnosed.results().residual.holdout_unit.map_or("data", |unit| unit.plural());
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
        Verdict::MissingEffect => "\nMore may be missing; the demo stops adding here.\n".into(),
        _ => verdict(&last),
    };
    let fit = analysed.fit().results();
    if !analysed.steps().is_empty() {
        text += "\n";
        text += &ladder_text(&analysed.fit().model().ladder(), fit.noise_um);
    }
    text + &counted(&fit)
}

/// The same up to what is missing: the person who looks at the page adds it.
pub(super) fn proposed(analysed: &Analysed, page: &str) -> String {
    let (first, fit) = (analysed.first().results(), analysed.before().results());
    let add = format!("\nAdd it on the page, with your name, and see the error fall: {page}/#result\n");
    let add = if first.best().is_some() { add } else { String::new() };
    of_base(analysed) + &failing(analysed.first()) + &verdict(&first) + &add + &counted(&fit)
}

fn of_base(analysed: &Analysed) -> String {
    let before = analysed.before().results();
    format!(
        "Base model (location errors and ball setting): {} rms remain ({}).\n",
        um(before.rms_um),
        repeatability(before.noise_um, before.noise_readings),
    )
}

/// Where a model fails, and which effects may be missing.
fn failing(diagnosed: &Diagnosed) -> String {
    let diagnosis = diagnosed.results();
    if diagnosis.verdict == Verdict::NoiseFloor {
        return String::new();
    }
    let mut text = String::from("\nWhere does the model fail most?\n");
    for place in diagnosed.fit().places() {
        text += &format!("  {}\n", place.words);
    }
    text += "What is missing?\n";
    for candidate in diagnosis.candidates.iter().take(3) {
        text += &format!(
            "  {:24} evidence {:<11} error would fall to {}\n",
            candidate.effect,
            odds(candidate.evidence),
            um(candidate.rms_um_after)
        );
    }
    if let Some(best) = diagnosis.candidates.first() {
        text += &format!("  {}\n", best.why);
    }
    text
}

/// The answer where no effect of the catalogue is named.
fn verdict(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict {
        Verdict::NoiseFloor => format!("\n{ALL_CLEAR}\n"),
        Verdict::MissingEffect => String::new(),
        Verdict::UnnamedStructure => match &diagnosis.formula {
            Some(formula) => format!(
                "\nSomething remains that no effect of the catalogue describes: {} = {} at {}. {}.\n",
                formula.component, formula.expression, formula.site, formula.location
            ),
            None => "\nSomething remains that no effect of the catalogue describes.\n".into(),
        },
        Verdict::Undecided => format!("\nThese data cannot say. {}\n", diagnosis.why),
        Verdict::NotJudged => format!("\nThe runs were not judged. {}\n", diagnosis.why),
    }
}

fn counted(fit: &Identification) -> String {
    format!("\n{} points, {} excluded as outliers.\n", fit.points, fit.outliers)
}

/// What was hidden, what was found, and the location errors of both.
pub(super) fn truth_text(machine: &VirtualMachine, left: &Fit, path: &Path) -> String {
    let truth = machine.truth();
    let hidden: Vec<String> = truth.hidden.iter().map(hidden::Hidden::id).collect();
    let (ladder, fit) = (left.model().ladder(), left.results());
    let by = |row: &LadderRow| row.by.as_ref().map_or(String::new(), |name| format!(", added by {name}"));
    let found: Vec<String> = ladder.added().map(|(effect, row)| format!("{effect}{}", by(row))).collect();
    let mut text = format!(
        "Hidden: {}. Found: {}. ({})\n",
        if hidden.is_empty() { "nothing".into() } else { hidden.join(", ") },
        if found.is_empty() { "nothing".into() } else { found.join("; ") },
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
