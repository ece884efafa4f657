//! The figures of an answer, how sure it is, and what to measure next: for the report and the story of a page.

use crate::added;
use crate::number::{percent, um, um_or_dash};
use crate::words::{
    effect_name, evidence_words, formula_leads, left_out, names, noise_origin, repeatability,
};
use trunnion_results::{Candidate, Comparison, Diagnosis, Fact, Verdict};

/// The figures at the top.
pub(crate) fn facts(input: &Comparison) -> Vec<Fact> {
    let fit = &input.identification;
    let mut facts = vec![
        fact("Residual", um(fit.rms_um), "rms".into()),
        fact("Repeatability", um_or_dash(fit.noise_um), noise_origin(fit)),
        fact("Held-out error", um_or_dash(fit.holdout_rms_um), left_out(fit.holdout_unit)),
    ];
    if let Some(fraction) = input.diagnosis.as_ref().and_then(Diagnosis::explained) {
        let remark = "of the mean square of the residual".into();
        facts.push(fact("Explained by what was found", percent(fraction), remark));
    }
    let drawn = match input.residuals.every {
        0 | 1 => String::new(),
        every => format!(", every {every}th drawn"),
    };
    facts.push(fact("Points", fit.points.to_string(), format!("{} excluded{drawn}", fit.outliers)));
    facts
}

fn fact(name: &str, value: String, remark: String) -> Fact {
    Fact { name: name.into(), value, remark }
}

/// How sure the answer is; empty where nothing was asked.
pub(crate) fn sure(input: &Comparison) -> Vec<String> {
    let Some(diagnosis) = &input.diagnosis else { return Vec::new() };
    let mut items = vec![noise(diagnosis)];
    if let Some(formula) = diagnosis.formula.as_ref().filter(|_| formula_leads(diagnosis)) {
        items.push(format!("{}.", evidence_words(formula.evidence)));
        items.push(match diagnosis.candidates.first() {
            Some(best) => format!(
                "No named effect explains it: the best, {}, leaves {} rms with structure in it.",
                effect_name(&best.effect),
                um(best.rms_um_after)
            ),
            None => "No named effect explains any of it.".into(),
        });
    } else if let Some((found, together)) = diagnosis.found_together() {
        items.push(format!("Found together: {}.", names(&found)));
        items.extend(held_out(diagnosis, together.holdout_rms_um_after));
        for one in found {
            items.push(format!("For {}: {}.", effect_name(&one.effect), evidence_words(one.evidence)));
            items.extend(one.remarks.iter().cloned());
            items.extend(rivals(one));
        }
    } else if let Some(best) = diagnosis.candidates.first() {
        items.push(format!("{}.", evidence_words(best.evidence)));
        items.extend(held_out(diagnosis, best.holdout_rms_um_after));
        items.extend(best.remarks.iter().cloned());
        items.extend(rivals(best));
    }
    if diagnosis.verdict != Verdict::NotJudged {
        items.extend(added::sure(input));
    }
    items.retain(|item| !item.is_empty());
    items
}

fn noise(diagnosis: &Diagnosis) -> String {
    let known = repeatability(diagnosis.residual.noise_um, diagnosis.residual.noise_readings);
    match (diagnosis.explained().map(percent), diagnosis.verdict) {
        (Some(share), _) => {
            format!("What was found explains {share} of the mean square of the residual; {known}.")
        }
        (None, Verdict::NotJudged) => format!("No effect was judged; {known}."),
        (None, Verdict::NoiseFloor) => format!("Nothing significant was found in the residual; {known}."),
        (None, _) => format!("Nothing was found that could be named; {known}."),
    }
}

fn held_out(diagnosis: &Diagnosis, after_um: Option<f64>) -> Option<String> {
    let residual = &diagnosis.residual;
    let (before, after) = (residual.holdout_rms_um?, after_um?);
    let units = residual.holdout_unit?.plural();
    let (was, is) = (um(before), um(after));
    Some(if after < 0.97 * before {
        format!(
            "It also predicts what it has not seen: on {units} left out of the fit the error falls from {was} to {is}."
        )
    } else {
        format!(
            "On {units} left out of the fit the error does not fall ({was} before, {is} after): take it with care."
        )
    })
}

fn rivals(best: &Candidate) -> Option<String> {
    added::confounded(&best.effect, &best.confused_with)
}

/// What to measure next; empty when nothing is asked for.
pub(crate) fn measure_next(diagnosis: &Diagnosis) -> &str {
    let separates = diagnosis.candidates.first().map_or("", |best| best.separate_by.as_str());
    diagnosis.next_cycle.as_ref().map_or(separates, |next| next.suggestion.as_str())
}
