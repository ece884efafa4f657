//! Which effect is missing: explanation, candidates, rivals, what to measure next.

use crate::CompareInput;
use crate::markup::{element, escape, table};
use crate::number::{percent, um, value_and_u};
use crate::words::{effect_name, explanation};
use trunnion_diagnose::{Candidate, Diagnosis, FormulaProposal};

pub fn section(input: &CompareInput) -> String {
    let body = match &input.diagnosis {
        None => {
            "<p>Not asked. <code>trunnion diagnose</code> with the same runs and model names the missing effect.</p>\n"
                .into()
        }
        Some(diagnosis) => found(diagnosis),
    };
    format!("<section><h2>Which effect is missing</h2>\n{body}</section>\n")
}

fn found(diagnosis: &Diagnosis) -> String {
    let mut body = String::new();
    match diagnosis.candidates.first() {
        Some(best) => body += &best_candidate(best),
        None => body += "<p>No named effect explains the residual better than noise does.</p>\n",
    }
    if !diagnosis.candidates.is_empty() {
        body += &candidates_table(&diagnosis.candidates);
    }
    if let Some(formula) = &diagnosis.formula {
        body += &formula_paragraph(formula);
    }
    if let Some(next) = &diagnosis.next_cycle {
        body += "<h3>What to measure next</h3>\n";
        body += &element("p", &next.suggestion);
    }
    if !diagnosis.not_visible.is_empty() {
        let text = format!("This cycle cannot show: {}.", diagnosis.not_visible.join(", "));
        body += &format!("<p class=\"soft\">{}</p>\n", escape(&text));
    }
    if !diagnosis.out_of_reach.is_empty() {
        let text = format!("Out of reach of these runs: {}.", diagnosis.out_of_reach.join(", "));
        body += &format!("<p class=\"soft\">{}</p>\n", escape(&text));
    }
    body
}

fn best_candidate(best: &Candidate) -> String {
    let mut body = format!("<h3>{}</h3>\n", escape(&effect_name(&best.effect)));
    body += &element("p", &best.why);
    let rows: String = explanation(&best.effect)
        .into_iter()
        .map(|(label, text)| format!("<li><b>{}:</b> {}</li>", escape(label), escape(text)))
        .collect();
    if !rows.is_empty() {
        body += &format!("<ul>{rows}</ul>\n");
    }
    if !best.adequate {
        body +=
            "<p class=\"warn\">Adding it does not explain everything: something structured remains.</p>\n";
    }
    if !best.confused_with.is_empty() {
        let text = format!(
            "These data cannot well tell it from {}. To separate them: {}",
            best.confused_with.iter().map(|id| effect_name(id)).collect::<Vec<_>>().join("; "),
            best.separate_by
        );
        body += &format!("<p class=\"warn\">{}</p>\n", escape(&text));
    }
    if !best.parameters.is_empty() {
        let rows: Vec<_> = best
            .parameters
            .iter()
            .map(|p| {
                let (value, u) = value_and_u(p.value, p.u, &p.unit);
                vec![p.name.clone(), value, u]
            })
            .collect();
        let caption = "Its size as fitted, with standard uncertainty";
        body += &table(caption, &["parameter", "value", "uncertainty"], &[1, 2], &rows);
    }
    body
}

fn candidates_table(candidates: &[Candidate]) -> String {
    let rows: Vec<_> = candidates
        .iter()
        .map(|c| {
            vec![
                c.effect.clone(),
                format!("{:.1}", c.evidence).replace('-', "−"),
                um(c.rms_um_after),
                um(c.holdout_rms_um_after),
                percent(c.explains_fraction),
                if c.adequate { "yes" } else { "no" }.into(),
                c.confused_with.join(", "),
            ]
        })
        .collect();
    let head = [
        "effect",
        "evidence (log10)",
        "error after",
        "held-out after",
        "explains",
        "enough alone",
        "alike here",
    ];
    table(
        "Candidates, best first. Evidence 2 means 100 to 1, 3 means 1000 to 1.",
        &head,
        &[1, 2, 3, 4],
        &rows,
    )
}

fn formula_paragraph(formula: &FormulaProposal) -> String {
    let resembles =
        formula.resembles.as_ref().map_or(String::new(), |id| format!(" It resembles {}.", effect_name(id)));
    let text = format!(
        "{} at {}: it lives {}. Adding it leaves {} and explains {} of what is above the noise.{resembles}",
        formula.component,
        formula.site,
        formula.lives,
        um(formula.rms_um_after),
        percent(formula.explains_fraction)
    );
    format!(
        "<h3>An expression that describes it (formula:{})</h3>\n<p><code>{}</code></p>\n{}\n",
        escape(&formula.name),
        escape(&formula.expression),
        element("p", &text)
    )
}
