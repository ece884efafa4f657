//! What to do after a run: no more than its data allow.

use crate::certainty::measure_next;
use crate::number::um;
use crate::words::{about, effect_name, is_failed, is_only_incomplete, names, planned_words};
use trunnion_results::{Candidate, Comparison, Correctable, Diagnosis, Prediction, RunPrediction, Verdict};

/// In the order in which it is done; never empty.
pub(crate) fn to_do(input: &Comparison) -> Vec<String> {
    let Some(diagnosis) = &input.diagnosis else { return vec![ask(input.frozen.as_ref()).into()] };
    let mut to_do: Vec<String> = match diagnosis.verdict {
        Verdict::NoiseFloor => correct(input),
        Verdict::MissingEffect => {
            diagnosis.candidates.first().map_or_else(Vec::new, |best| look_and_add(diagnosis, best))
        }
        Verdict::UnnamedStructure => unnamed(input, diagnosis),
        Verdict::Undecided => vec!["Change nothing at the machine or in the control on these data.".into()],
        Verdict::NotJudged => vec![
            NOT_ON_THESE_RUNS[0].into(),
            if is_failed(input) {
                "Mend what made the diagnosis fail, and diagnose again.".into()
            } else if is_only_incomplete(input) {
                "Measure the whole cycle again, or the part that is missing.".into()
            } else {
                NOT_ON_THESE_RUNS[1].into()
            },
        ],
    };
    to_do.extend(Some(measure_next(diagnosis).to_string()).filter(|next| !next.is_empty()));
    if let Some(cycle) = diagnosis.next_cycle.as_ref().and_then(|next| next.cycle.as_ref()) {
        to_do.push(planned_words(cycle));
    }
    match diagnosis.verdict {
        Verdict::MissingEffect | Verdict::UnnamedStructure => {
            to_do.push(before_the_model_explains(input, diagnosis));
        }
        Verdict::Undecided if to_do.len() == 1 => {
            to_do.push("Measure again, every pose twice.".into());
        }
        _ => {}
    }
    to_do
}

/// What is missing below the repeatability stays in the machine at the measured poses as its scatter does: no reason to leave large
/// errors in it.
fn before_the_model_explains(input: &Comparison, diagnosis: &Diagnosis) -> String {
    let is_something_clear = input.correctable.as_ref().is_some_and(|known| !known.clear.is_empty());
    match (diagnosis.missing_below_repeatability_um(), diagnosis.residual.noise_um) {
        (Some(missing), Some(repeats)) if is_something_clear => format!(
            "Entering the errors of the axes into the control need not wait for it (trunnion correct --although-inadequate): what is \
             missing is {} rms, less than the repeatability ({}).",
            um(missing),
            um(repeats)
        ),
        _ => "Enter nothing into the control before the model explains the readings.".into(),
    }
}

/// What to ask, or to do after values were held against runs.
pub(crate) fn ask(frozen: Option<&Prediction>) -> &'static str {
    match frozen.map(|frozen| frozen.runs.iter().all(RunPrediction::holds)) {
        None => "Ask which effect is missing: trunnion diagnose with the same runs and model.",
        Some(true) => "Change nothing: the fitted values still describe the machine.",
        Some(false) => {
            "Ask what changed since the values were fitted: trunnion history with the runs of this machine."
        }
    }
}

fn look_and_add(diagnosis: &Diagnosis, best: &Candidate) -> Vec<String> {
    let mut to_do = Vec::new();
    if about(&best.effect).is_some() {
        to_do.push(match best.confused_with.as_slice() {
            [] => "Look for the likely cause at the machine.".into(),
            rivals => format!(
                "Look at the machine for the likely cause and for what these data do not separate from it: {}.",
                rivals.iter().map(|id| effect_name(id)).collect::<Vec<_>>().join("; ")
            ),
        });
    }
    to_do.push(format!("Add {} to the model, and see whether the error falls.", effect_name(&best.effect)));
    if let Some((found, together)) = diagnosis.found_together() {
        let others: Vec<&Candidate> = found.into_iter().filter(|one| one.effect != best.effect).collect();
        to_do.push(format!("Then add what was found together with it: {}.", names(&others)));
        if !together.adequate {
            to_do.push("Then diagnose again: a part remains that they do not explain.".into());
        }
    } else if best.explains_all && !best.adequate {
        to_do.push(
            "Then measure there and back, or return to the first pose: an error along an axis that goes one way would read the same."
                .into(),
        );
    } else if !best.adequate {
        to_do.push("Then diagnose again: a part remains that it does not explain.".into());
    }
    to_do
}

fn unnamed(input: &Comparison, diagnosis: &Diagnosis) -> Vec<String> {
    let mut to_do = Vec::new();
    if !input.places.is_empty() {
        to_do.push("Look at the machine where the model fails most: the places are listed below.".into());
    }
    to_do.push(match diagnosis.best() {
        Some(id) => format!("Add the expression to the model, and see whether the error falls ({id})."),
        None => "Measure again with the ball in another place: what stays belongs to the machine.".into(),
    });
    to_do
}

/// What to enter where nothing is missing from the model.
fn correct(input: &Comparison) -> Vec<String> {
    let nothing = Correctable::default();
    let correctable = input.correctable.as_ref().unwrap_or(&nothing);
    let mut to_do = Vec::new();
    if !correctable.clear.is_empty() {
        to_do.push(
            "Enter the errors of the axes into the control (trunnion correct), then measure again.".into(),
        );
        if !correctable.confounded.is_empty() {
            to_do.push(
                "Of other errors only a combination is known: as entered it is right at the measured poses, and may be wrong \
                 at others."
                    .into(),
            );
        }
    } else if !correctable.why.is_empty() {
        to_do.push(format!("Enter nothing into the control: {}.", correctable.why));
    } else if !correctable.confounded.is_empty() {
        to_do.push(
            "Enter nothing into the control yet: of the errors of the axes only combinations are known, which are right at the \
             measured poses and may be wrong at others."
                .into(),
        );
        to_do.push(SCHEMES.into());
    } else if !correctable.small.is_empty() {
        to_do.push(
            "Enter nothing into the control: no error of an axis is larger than three standard uncertainties."
                .into(),
        );
    } else if correctable.at_rest.is_empty() {
        to_do.push("Enter nothing into the control: these runs give a number to no error of an axis.".into());
        to_do.push(SCHEMES.into());
    } else {
        to_do.push(format!(
            "Enter nothing into the control yet: {} hold what an axis at rest adds as well, and are right only where it stood.",
            correctable.at_rest.join(", ")
        ));
        to_do.push("Measure with that axis at several positions.".into());
    }
    for left in &correctable.left_out {
        to_do.push(format!(
            "Look for the cause of {} at the machine: no table of an axis takes it.",
            effect_name(&left.effect)
        ));
    }
    to_do
}

/// Said of runs that cannot be what they say they are.
pub(crate) const NOT_ON_THESE_RUNS: [&str; 2] = [
    "Change nothing at the machine or in the control on these runs.",
    "Undo the mistake named above, or measure again.",
];

/// Said where a person would like an error of an axis and these runs show none.
pub(crate) const SCHEMES: &str = "To find errors of the axes, measure a cycle that shows them: the guide \"Measurement schemes\" lists cycles for each \
                       instrument.";
