//! The top of the page: what is wrong with the machine, in one paragraph, and the figures.

use crate::certainty;
use crate::markup::escape;
use crate::words::{headline, verdict};
use trunnion_results::{Comparison, Fact};

pub fn section(input: &Comparison, label: &str) -> String {
    let fit = &input.identification;
    let runs = if fit.runs.is_empty() { "no run".into() } else { fit.runs.join(", ") };
    let about = format!(
        "Machine {}; run {runs}; model: {}. {}",
        fit.machine,
        if fit.effects.is_empty() { "none".into() } else { fit.effects.join(" + ") },
        label
    );
    format!(
        "<header><p class=\"soft\">Trunnion: measured against predicted</p>\n<h1>{}</h1>\n<p class=\"lead\">{}</p>\n\
         <p class=\"soft\">{}</p>\n{}</header>\n",
        escape(&headline(input)),
        escape(&verdict(input).join(" ")),
        escape(&about),
        facts(input),
    )
}

fn facts(input: &Comparison) -> String {
    let shown: String = certainty::facts(input).iter().map(fact).collect();
    format!("<dl class=\"facts\">{shown}</dl>\n")
}

fn fact(fact: &Fact) -> String {
    format!(
        "<div><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n",
        escape(&fact.name),
        escape(&fact.value),
        escape(&fact.remark)
    )
}
