//! A diagnosis for the terminal: what is missing, what to do, candidates and formula.

use super::table::{clean, paragraph, set_apart, titled};
use crate::certainty::measure_next;
use crate::number::{percent, um, um_or_dash, value_and_u};
use crate::to_do::to_do;
use crate::words::{
    EXPLAINS, TOGETHER, beyond_catalogue, candidate_figures, effect_name, evidence_words, explanation,
    formula_leads, formula_shape, formula_site, headline, left_out, names, noticeable, remaining_pattern,
    repeatability, sizes, sizes_from, together_figures, without_size,
};
use std::iter::once;
use trunnion_core::number::odds;
use trunnion_results::sentences::doubts;
use trunnion_results::{Candidate, Comparison, Diagnosis, FormulaProposal, LeftOut};

/// Verdict, what to do, candidates and formula of a comparison that holds a diagnosis; empty without one.
pub fn diagnosis_text(input: &Comparison) -> String {
    let Some(diagnosis) = &input.diagnosis else { return String::new() };
    let residual = &diagnosis.residual;
    let mut out = format!("{}\n", clean(&headline(input)));
    let explained = diagnosis.explained().map_or(String::new(), |fraction| {
        format!("; what was found explains {} of the mean square", percent(fraction))
    });
    out += &format!(
        "Residual {} rms ({}); held-out error {}{explained}.\n",
        um(residual.rms_um),
        repeatability(residual.noise_um, residual.noise_readings),
        held_out(residual.holdout_rms_um, residual.holdout_unit),
    );
    out += &paragraph(&diagnosis.why);
    out += &set_apart(&doubts(&input.identification));
    let all_clear = noticeable(diagnosis).into_iter().chain(remaining_pattern(diagnosis));
    all_clear.for_each(|sentence| out += &paragraph(&sentence));
    out += &what_to_do(input);
    if !diagnosis.candidates.is_empty() {
        out += "\n";
        let head = ["candidate", "evidence", "error after", "held-out", "explains", "adequate"];
        let rows = diagnosis.candidates.iter().map(|c| {
            let first = [c.effect.clone(), odds(c.evidence)];
            first.into_iter().chain(candidate_figures(c)).collect()
        });
        let mut rows: Vec<Vec<String>> = once(head.map(String::from).to_vec()).chain(rows).collect();
        if let Some((found, together)) = diagnosis.found_together() {
            let first = [TOGETHER.into(), String::new()];
            rows.insert(1 + found.len(), first.into_iter().chain(together_figures(together)).collect());
        }
        out += &titled(&rows, &[1, 2, 3, 4]);
        out += "\n";
        out += &paragraph(EXPLAINS);
        if let Some((found, _)) = diagnosis.found_together() {
            out += &paragraph(&format!("Found together: {}.", names(&found)));
        }
        // What those that were found are confounded with follows in their own paragraphs.
        for c in
            diagnosis.candidates.iter().skip(described(diagnosis)).filter(|c| !c.confused_with.is_empty())
        {
            out += &paragraph(&format!("{} is confounded with {}.", c.effect, c.confused_with.join(", ")));
        }
    }
    let formula = diagnosis.formula.as_ref().map_or(String::new(), formula);
    let best = diagnosis.candidates.iter().take(described(diagnosis));
    let best: String = best.map(|one| candidate(diagnosis, one)).collect();
    out += &match (formula_leads(diagnosis), best.is_empty()) {
        (true, false) => format!("{formula}\nThe named effect closest to it:{best}"),
        (true, true) => formula,
        (false, _) => best + &formula,
    };
    for (words, ids) in
        [("This cycle cannot show", &diagnosis.not_visible), ("Out of reach", &diagnosis.out_of_reach)]
    {
        if !ids.is_empty() {
            out += &format!("\n{}", paragraph(&format!("{words}: {}", ids.join(", "))));
        }
    }
    out
}

/// The steps in their order, as the page lists them.
pub(super) fn what_to_do(input: &Comparison) -> String {
    let steps = to_do(input)
        .iter()
        .zip(1..)
        .map(|(step, at)| paragraph(&format!("{at}. {step}")))
        .collect::<String>();
    format!("\nWhat to do\n{steps}")
}

fn formula(formula: &FormulaProposal) -> String {
    let numbers = formula_shape(formula);
    let numbers = if numbers.is_empty() { numbers } else { format!("  with {}\n", clean(&numbers)) };
    format!("\nformula:{} ({})\n", formula.name, formula_site(formula))
        + &format!("  {}\n{}", clean(&formula.expression), numbers)
        + &paragraph(&format!(
            "It is a {}; it leaves {} and explains {} of what was found. {}.",
            formula.location,
            um(formula.rms_um_after),
            percent(formula.explains_fraction),
            evidence_words(formula.evidence)
        ))
}

/// So many candidates, from the first, have paragraphs of their own.
fn described(diagnosis: &Diagnosis) -> usize {
    diagnosis.found_together().map_or(1, |(found, _)| found.len())
}

fn candidate(diagnosis: &Diagnosis, best: &Candidate) -> String {
    let mut out = format!("\n{}\n", effect_name(&best.effect));
    for (label, text) in explanation(&best.effect) {
        out += &paragraph(&format!("{label}: {text}"));
    }
    out += &paragraph(&format!(
        "{}. {}",
        evidence_words(best.evidence),
        beyond_catalogue(best, &diagnosis.residual)
    ));
    if let Some(from) = sizes_from(diagnosis, best) {
        out += &paragraph(&format!("Its size, {from}:"));
    }
    for p in sizes(diagnosis, best) {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        out += &format!("  {} = {value}, u = {u}\n", clean(&p.name));
    }
    out += &without_size(diagnosis, best).map_or(String::new(), |said| paragraph(&said));
    if !best.confused_with.is_empty() {
        let separate = Some(&best.separate_by).filter(|said| *said != measure_next(diagnosis));
        let separate = separate.map_or(String::new(), |said| format!(" To separate them: {said}"));
        out += &paragraph(&format!("Confounded with {}.{separate}", best.confused_with.join(", ")));
    }
    out
}

pub(super) fn held_out(rms_um: Option<f64>, unit: Option<LeftOut>) -> String {
    format!("{} ({})", um_or_dash(rms_um), left_out(unit))
}
