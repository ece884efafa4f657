//! What a trial of an effect comes to, in sentences.

use crate::number::{um, um_or_dash};
use std::iter::once;
use trunnion_results::sentences::{doubts, effect_name, left_out};
use trunnion_results::{Then, Trial, Verdict};

/// How the readings judge a trial, on data that took no part in the fit, and what to doubt in the fit with it.
pub fn trial_verdict(trial: &Trial) -> String {
    let doubts = doubts(&trial.identification);
    once(trial_outcome(trial)).chain(doubts).collect::<Vec<_>>().join(" ")
}

fn trial_outcome(trial: &Trial) -> String {
    let rms = trial.rms_um;
    let fit = format!("The residual goes from {} to {} rms", um_or_dash(rms.before), um_or_dash(rms.after));
    let then = trial.then.as_ref().map_or(String::new(), |then| format!(" {}", then_sentence(then)));
    let Some((out_before, out_after)) = trial.holdout_rms_um.before.zip(trial.holdout_rms_um.after) else {
        return format!(
            "{fit}; no part of these data predicts another, so nothing proves that it predicts anything.{then}"
        );
    };
    let out = format!(
        "{} from {} to {}",
        left_out(trial.identification.holdout_unit),
        um(out_before),
        um(out_after)
    );
    let word = match out_after / out_before {
        ratio if ratio < 0.9 => "It helps: it also predicts readings it has not seen.",
        ratio if ratio < 0.99 => "It helps a little.",
        ratio if ratio <= 1.01 => "It does not help: what it has not seen it predicts no better.",
        _ => "It harms: what it has not seen it predicts worse.",
    };
    format!("{fit}, {out} (repeatability {}). {word}{then}", um_or_dash(trial.noise_um))
}

/// What is missing after a trial.
fn then_sentence(then: &Then) -> String {
    match (then.verdict, &then.candidate) {
        (Verdict::NoiseFloor, _) => "Nothing structured remains after it.".into(),
        (Verdict::MissingEffect, Some(next)) => {
            format!("After it the model still misses something, first of all {}.", effect_name(next))
        }
        (Verdict::NotJudged, _) => format!("What remains was not judged. {}", then.why),
        (Verdict::Undecided, _) => format!("What remains these data cannot judge. {}", then.why),
        _ => "After it something remains that the catalogue has no name for.".into(),
    }
}
