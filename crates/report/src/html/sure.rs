//! How sure the answer is: evidence in words, what it could be mistaken for, what to measure next, what is not observable.

use crate::markup::{element, escape};
use crate::number::{percent, um};
use crate::words::{
    beyond_figures, effect_name, evidence_words, formula_leads, planned_words, repeatability,
};
use trunnion_results::{Candidate, Comparison, Diagnosis};

pub fn section(input: &Comparison) -> String {
    let Some(diagnosis) = &input.diagnosis else { return String::new() };
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
    } else if let Some(best) = diagnosis.candidates.first() {
        items.push(format!("{}.", evidence_words(best.evidence)));
        items.extend(held_out(input, best));
        items.push(beyond_figures(best));
        items.extend(rivals(best));
    }
    items.retain(|item| !item.is_empty());
    let mut body = format!("<ul>{}</ul>\n", items.iter().map(|item| element("li", item)).collect::<String>());
    let said = diagnosis.candidates.first().map_or("", |best| best.separate_by.as_str());
    let next = diagnosis.next_cycle.as_ref().map_or(said, |next| next.suggestion.as_str());
    if !next.is_empty() {
        body += &format!("<p class=\"warn\"><b>Measure next:</b> {}</p>\n", escape(next));
    }
    if let Some(cycle) = diagnosis.next_cycle.as_ref().and_then(|next| next.cycle.as_ref()) {
        body += &element("p", &planned_words(cycle));
    }
    body += &unseen("This cycle cannot show", &diagnosis.not_visible);
    body += &unseen("Out of reach of these runs", &diagnosis.out_of_reach);
    format!("<section><h2>How sure this is</h2>\n{body}</section>\n")
}

fn noise(diagnosis: &Diagnosis) -> String {
    let known = repeatability(diagnosis.residual.noise_um);
    match diagnosis.residual.unexplained_fraction.map(percent) {
        Some(share) => {
            format!("What was found explains {share} of the mean square of the residual; {known}.")
        }
        None => format!("Nothing was weighed; {known}."),
    }
}

fn held_out(input: &Comparison, best: &Candidate) -> Option<String> {
    let residual = &input.diagnosis.as_ref()?.residual;
    let (before, after) = (residual.holdout_rms_um?, best.holdout_rms_um_after?);
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
    let names: Vec<_> = best.confused_with.iter().map(|id| effect_name(id)).collect();
    (!names.is_empty())
        .then(|| format!("In these data {} is confounded with {}.", best.effect, names.join("; ")))
}

fn unseen(words: &str, ids: &[String]) -> String {
    if ids.is_empty() {
        return String::new();
    }
    format!(
        "<details class=\"soft\"><summary>{} ({})</summary><p>{}</p></details>\n",
        escape(words),
        ids.len(),
        escape(&ids.join(", "))
    )
}
