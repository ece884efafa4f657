//! The top of the page: what is wrong with the machine, in one paragraph, and the figures.

use crate::CompareInput;
use crate::markup::escape;
use crate::number::{percent_or_dash, um, um_or_dash};
use crate::words::{headline, verdict};

pub fn section(input: &CompareInput) -> String {
    let fit = &input.identification;
    let runs = if fit.runs.is_empty() { "no run".into() } else { fit.runs.join(", ") };
    let about = format!(
        "Machine {}; run {runs}; model: {}. {}",
        fit.machine,
        if fit.effects.is_empty() { "none".into() } else { fit.effects.join(" + ") },
        input.label
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

fn facts(input: &CompareInput) -> String {
    let fit = &input.identification;
    let mut facts = vec![
        fact("Error left", &um(fit.rms_um), "rms of the residual"),
        fact("Repeatability", &um_or_dash(input.noise.rms_um), &input.noise.origin),
        fact("Held-out error", &um_or_dash(fit.holdout_rms_um), "on data left out of the fit"),
    ];
    if let Some(diagnosis) = &input.diagnosis {
        facts.push(fact(
            "Explained by what was found",
            &percent_or_dash(diagnosis.residual.unexplained_fraction),
            "of the mean square of the residual",
        ));
    }
    let drawn = if input.every > 1 { format!(", every {}th drawn", input.every) } else { String::new() };
    facts.push(fact("Points", &fit.points.to_string(), &format!("{} set aside{drawn}", fit.outliers)));
    format!("<dl class=\"facts\">{}</dl>\n", facts.concat())
}

fn fact(name: &str, value: &str, remark: &str) -> String {
    format!(
        "<div><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n",
        escape(name),
        escape(value),
        escape(remark)
    )
}
