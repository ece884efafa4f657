//! The top of the page: what is wrong with the machine, in one paragraph, and the figures.

use crate::markup::escape;
use crate::number::{percent, um, um_or_dash};
use crate::words::{headline, left_out, noise_origin, verdict};
use trunnion_results::Comparison;

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
    let fit = &input.identification;
    let mut facts = vec![
        fact("Residual", &um(fit.rms_um), "rms"),
        fact("Repeatability", &um_or_dash(fit.noise_um), &noise_origin(fit)),
        fact("Held-out error", &um_or_dash(fit.holdout_rms_um), &left_out(fit.holdout_unit)),
    ];
    if let Some(fraction) = input.diagnosis.as_ref().and_then(|d| d.residual.unexplained_fraction) {
        let remark = "of the mean square of the residual";
        facts.push(fact("Explained by what was found", &percent(fraction), remark));
    }
    let drawn = if input.residuals.every > 1 {
        format!(", every {}th drawn", input.residuals.every)
    } else {
        String::new()
    };
    facts.push(fact("Points", &fit.points.to_string(), &format!("{} excluded{drawn}", fit.outliers)));
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
