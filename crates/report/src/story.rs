//! One run in the order in which a person asks: sentences, figures, and the charts of the report.

use crate::certainty::{facts, sure};
use crate::html;
use crate::number::{um, value_and_u};
use crate::to_do::to_do;
use crate::words::{
    effect_name, evidence_words, explanation, formula_leads, formula_shape, formula_site, headline, is_found,
    sizes, sizes_from, verdict, without_size,
};
use trunnion_results::sentences::complete;
use trunnion_results::{
    Candidate, Comparison, Diagnosis, FormulaProposal, Parameter, Story, StoryCandidate, StorySection,
};

/// A comparison as the story of a page.
pub fn story(input: &Comparison) -> Story {
    let fit = &input.identification;
    let diagnosis = input.diagnosis.as_ref();
    let implausible = !fit.plausibility.is_empty();
    Story {
        runs: fit.runs.clone(),
        machine: fit.machine.clone(),
        model: fit.effects.clone(),
        verdict: diagnosis.map(|diagnosis| diagnosis.verdict),
        headline: headline(input),
        wrong: verdict(input),
        facts: facts(input),
        sure: sure(input),
        to_do: to_do(input),
        candidates: diagnosis.map_or_else(Vec::new, candidates),
        ladder: input.ladder.clone(),
        removable: input.ladder.added().map(|(id, _)| id.to_string()).collect(),
        not_observable: fit
            .unobservable
            .iter()
            .map(|row| format!("{}: {}", row.direction, row.why))
            .collect(),
        not_visible: diagnosis
            .map_or_else(Vec::new, |d| d.not_visible.iter().map(|id| effect_name(id)).collect()),
        out_of_reach: diagnosis
            .map_or_else(Vec::new, |d| d.out_of_reach.iter().map(|id| effect_name(id)).collect()),
        complete: complete(&fit.complete),
        withheld: if implausible {
            "Nothing can be added, because the runs are not plausible or not whole.".into()
        } else {
            String::new()
        },
        sections: html::compare_sections(input)
            .into_iter()
            .filter(|(_, markup)| !markup.is_empty())
            .map(|(id, html)| StorySection { id: id.into(), html })
            .collect(),
        ..Story::default()
    }
}

fn candidates(diagnosis: &Diagnosis) -> Vec<StoryCandidate> {
    let formula = diagnosis.formula.as_ref();
    let leads = formula.filter(|_| formula_leads(diagnosis)).map(|f| expression(diagnosis, f));
    let follows = formula.filter(|_| !formula_leads(diagnosis)).map(|f| expression(diagnosis, f));
    leads.into_iter().chain(diagnosis.candidates.iter().map(|c| named(diagnosis, c))).chain(follows).collect()
}

fn named(diagnosis: &Diagnosis, candidate: &Candidate) -> StoryCandidate {
    let size = |p: &&Parameter| {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        [p.name.clone(), value, u]
    };
    let speaks = candidate.remarks.join(" ");
    let mut about = Vec::new();
    if !speaks.is_empty() {
        about.push(["Remarks".into(), speaks]);
    }
    if let Some(from) = sizes_from(diagnosis, candidate) {
        about.push(["Its size".into(), format!("{from}; the residual above is with this effect alone.")]);
    }
    about.extend(without_size(diagnosis, candidate).map(|said| ["Its size".into(), said]));
    about.extend(explanation(&candidate.effect).into_iter().map(|(label, text)| [label.into(), text]));
    StoryCandidate {
        effect: candidate.effect.clone(),
        title: effect_name(&candidate.effect),
        falls: [um(diagnosis.residual.rms_um), um(candidate.rms_um_after)],
        evidence: format!("{}.", evidence_words(candidate.evidence)),
        about,
        rivals: candidate.confused_with.iter().map(|id| effect_name(id)).collect(),
        separate_by: candidate.separate_by.clone(),
        sizes: sizes(diagnosis, candidate).iter().map(size).collect(),
        found: is_found(diagnosis, candidate),
    }
}

fn expression(diagnosis: &Diagnosis, formula: &FormulaProposal) -> StoryCandidate {
    let shape = formula_shape(formula);
    let with = if shape.is_empty() { String::new() } else { format!(", {shape}") };
    let effect = trunnion_results::sentences::formula_id(formula);
    let mut about = vec![
        ["Expression".to_string(), format!("{}: {}{with}", formula_site(formula), formula.expression)],
        ["What it does, and where".into(), formula.location.clone()],
    ];
    if let Some(id) = &formula.resembles {
        about.push(["Closest named effect, which does not fit fully".into(), effect_name(id)]);
    }
    StoryCandidate {
        title: format!("An expression that the catalogue has no name for ({effect})"),
        effect,
        falls: [um(diagnosis.residual.rms_um), um(formula.rms_um_after)],
        evidence: format!("{}.", evidence_words(formula.evidence)),
        about,
        found: formula_leads(diagnosis),
        ..StoryCandidate::default()
    }
}
