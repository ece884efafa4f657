//! What is missing: every candidate with the error before and after, and the best one at work.

use super::trial;
use crate::markup::{element, escape, table};
use crate::number::{fixed, percent, um, um_or_dash, value_and_u};
use crate::svg::{Bar, bars};
use crate::words::{
    EXPLAINS, about, bars_legend, effect_name, formula_shape, formula_site, nothing_named, sources, units,
};
use trunnion_results::{Candidate, Comparison, Diagnosis, FormulaProposal, Parameter};

pub fn section(input: &Comparison) -> String {
    let body = match &input.diagnosis {
        None => {
            "<p>Not asked. <code>trunnion diagnose</code> with the same runs and model names the missing effect.</p>\n"
                .into()
        }
        Some(diagnosis) => found(input, diagnosis),
    };
    format!("<section><h2>What is missing</h2>\n{body}</section>\n")
}

fn found(input: &Comparison, diagnosis: &Diagnosis) -> String {
    if diagnosis.candidates.is_empty() && diagnosis.formula.is_none() {
        return element("p", nothing_named(input, diagnosis));
    }
    let mut body = bars(
        "Error before and after each candidate",
        &bars_legend(&units(diagnosis.residual.holdout_unit)),
        &steps(input, diagnosis),
        diagnosis.residual.noise_um,
    );
    if let Some(formula) = &diagnosis.formula {
        body += &formula_paragraph(formula);
    }
    if let Some(trial) = &input.trial {
        body += &trial::most_telling_maps(trial);
    }
    match (&input.trial, diagnosis.candidates.first()) {
        (Some(trial), _) => body += &trial::size_table(trial),
        (None, Some(best)) => body += &size_table(best),
        (None, None) => {}
    }
    if !diagnosis.candidates.is_empty() {
        body += &candidates_table(&diagnosis.candidates);
    }
    body
}

/// As it is now, and each candidate alone.
fn steps(input: &Comparison, diagnosis: &Diagnosis) -> Vec<Bar> {
    let bar = |name: String, fit_um: f64, holdout_um: Option<f64>| Bar {
        name,
        fit_um,
        holdout_um,
        noise_um: None,
        remark: String::new(),
    };
    let now =
        bar("as the model is now".into(), diagnosis.residual.rms_um, input.identification.holdout_rms_um);
    let formula = diagnosis.formula.as_ref();
    let formula = formula.map(|f| bar(format!("with formula:{}", f.name), f.rms_um_after, None));
    let candidates = diagnosis
        .candidates
        .iter()
        .map(|c| bar(format!("with {}", c.effect), c.rms_um_after, c.holdout_rms_um_after));
    std::iter::once(now).chain(candidates).chain(formula).collect()
}

fn size_table(best: &Candidate) -> String {
    if best.parameters.is_empty() {
        return String::new();
    }
    let row = |p: &Parameter| {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        vec![p.name.clone(), value, u]
    };
    let rows: Vec<_> = best.parameters.iter().map(row).collect();
    let caption = format!("How big {} is, with its standard uncertainty", best.effect);
    table(&caption, &["parameter", "value", "uncertainty"], &[1, 2], &rows)
}

fn candidates_table(candidates: &[Candidate]) -> String {
    let rows: Vec<_> = candidates
        .iter()
        .map(|c| {
            vec![
                effect_name(&c.effect),
                fixed(c.evidence, 1),
                um(c.rms_um_after),
                um_or_dash(c.holdout_rms_um_after),
                percent(c.explains_fraction),
                if c.adequate { "yes" } else { "no" }.into(),
                c.confused_with.join(", "),
                about(&c.effect).map_or(String::new(), |about| sources(about.source)),
            ]
        })
        .collect();
    let head = [
        "effect",
        "evidence (log10)",
        "error after",
        "held-out after",
        "explains",
        "adequate",
        "confounded with",
        "source",
    ];
    table(
        &format!("Candidates, best first. Evidence 2 means 100 to 1, 3 means 1000 to 1. {EXPLAINS}"),
        &head,
        &[1, 2, 3, 4],
        &rows,
    )
}

fn formula_paragraph(formula: &FormulaProposal) -> String {
    let numbers = formula_shape(formula);
    format!(
        "<p>The expression that describes it best, ready to add as <code>formula:{}</code> ({}):</p>\n\
         <p class=\"formula\"><code>{}</code></p>\n{}",
        escape(&formula.name),
        escape(&formula_site(formula)),
        escape(&formula.expression),
        if numbers.is_empty() { String::new() } else { format!("<p>with {}</p>\n", escape(&numbers)) },
    )
}
