//! What is missing: every candidate with the error before and after, and the best one at work.

use super::trial;
use crate::markup::{element, escape, table};
use crate::number::{fixed, value_and_u};
use crate::svg::{Bar, bars};
use crate::words::{
    EXPLAINS, TOGETHER, about, bars_legend, candidate_figures, effect_name, formula_shape, formula_site,
    nothing_named, sizes, sizes_from, sources, together_figures, units, without_size,
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
        &bars_legend(&units(diagnosis.residual.holdout_unit), diagnosis.residual.noise_um),
        &steps(input, diagnosis),
        diagnosis.residual.noise_um,
    );
    if let Some(formula) = &diagnosis.formula {
        body += &formula_paragraph(formula);
    }
    if let Some(trial) = &input.trial {
        body += &trial::clearest_maps(trial);
    }
    match (&input.trial, diagnosis.candidates.first()) {
        (Some(trial), _) => body += &trial::size_table(trial),
        (None, Some(best)) => body += &size_tables(diagnosis, best),
        (None, None) => {}
    }
    if !diagnosis.candidates.is_empty() {
        body += &candidates_table(diagnosis);
    }
    body
}

/// As it is now, each candidate alone, and what was found together.
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
    let together = diagnosis.found_together().map(|(_, together)| {
        bar(format!("with {TOGETHER}"), together.rms_um_after, together.holdout_rms_um_after)
    });
    std::iter::once(now).chain(candidates).chain(formula).chain(together).collect()
}

/// Of the best, or of all that was found together.
fn size_tables(diagnosis: &Diagnosis, best: &Candidate) -> String {
    let found = diagnosis.found_together().map_or(vec![best], |(found, _)| found);
    found.into_iter().map(|one| size_table(diagnosis, one)).collect()
}

fn size_table(diagnosis: &Diagnosis, best: &Candidate) -> String {
    let row = |p: &Parameter| {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        vec![p.name.clone(), value, u]
    };
    let rows: Vec<_> = sizes(diagnosis, best).into_iter().map(row).collect();
    let unseen = without_size(diagnosis, best).map_or(String::new(), |said| element("p", &said));
    if rows.is_empty() {
        return unseen;
    }
    let from = sizes_from(diagnosis, best).map_or(String::new(), |from| format!(", {from}"));
    let caption = format!("How big {} is, with its standard uncertainty{from}", best.effect);
    table(&caption, &["parameter", "value", "uncertainty"], &[1, 2], &rows) + &unseen
}

fn candidates_table(diagnosis: &Diagnosis) -> String {
    let mut rows: Vec<Vec<String>> = diagnosis
        .candidates
        .iter()
        .map(|c| {
            let source = about(&c.effect).map_or(String::new(), |about| sources(about.source));
            let first = [effect_name(&c.effect), fixed(c.evidence, 1)];
            first
                .into_iter()
                .chain(candidate_figures(c))
                .chain([c.confused_with.join(", "), source])
                .collect()
        })
        .collect();
    if let Some((found, together)) = diagnosis.found_together() {
        let (first, last) = ([TOGETHER.into(), String::new()], [String::new(), String::new()]);
        rows.insert(found.len(), first.into_iter().chain(together_figures(together)).chain(last).collect());
    }
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
