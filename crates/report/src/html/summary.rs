//! The top of the page: what is wrong, how big, where.

use crate::CompareInput;
use crate::markup::{element, escape};
use crate::number::{percent, um, um_or_dash};
use crate::views::{rms, worst_places};
use crate::words::headline;

pub fn section(input: &CompareInput) -> String {
    let fit = &input.identification;
    let runs = if fit.runs.is_empty() { "no run".into() } else { fit.runs.join(", ") };
    let about = format!(
        "Machine {}; run {runs}; model: {}. {}",
        fit.machine,
        if fit.effects.is_empty() { "none".into() } else { fit.effects.join(" + ") },
        input.label
    );
    let places = worst_places(input);
    let places = if places.is_empty() {
        "<p>No point can be compared.</p>".to_owned()
    } else {
        format!("<ol>{}</ol>", places.iter().map(|place| element("li", place)).collect::<String>())
    };
    format!(
        "<header><p class=\"soft\">Trunnion: measured against predicted</p>\n<h1>{}</h1>\n<p class=\"soft\">{}</p>\n{}</header>\n\
         <section><h2>Where the model fails most</h2>\n{places}\
         <p class=\"soft\">Residual = measured − predicted, per component of a reading; rms = root mean square.</p></section>\n",
        escape(&headline(input)),
        escape(&about),
        facts(input),
    )
}

fn facts(input: &CompareInput) -> String {
    let fit = &input.identification;
    let mut facts = vec![
        fact("Error left", &um(fit.rms_um), "rms of the residual"),
        fact("Noise floor", &um_or_dash(fit.noise.rms_um), &fit.noise.origin),
        fact("Held-out error", &um_or_dash(fit.holdout_rms_um), "on data left out of the fit"),
        fact(
            "Explained by the model",
            &percent(explained_share(input)),
            "of the mean square of the readings",
        ),
    ];
    if let Some(diagnosis) = &input.diagnosis {
        facts.push(fact(
            "Still above the noise",
            &percent(diagnosis.residual.unexplained_fraction),
            "of the mean square of the residual",
        ));
    }
    facts.push(fact("Points", &fit.points.to_string(), &format!("{} set aside", fit.outliers)));
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

/// Share of the mean square of the readings that the prediction takes away; NaN without readings.
fn explained_share(input: &CompareInput) -> f64 {
    let used = || input.points.iter().filter(|p| !p.outlier);
    let components = |setup: usize| input.setups.get(setup).map_or(0, |s| s.components.len().min(3));
    let all = |value: fn(&crate::PointView, usize) -> f64| {
        rms(used().flat_map(|p| (0..components(p.setup)).map(move |k| value(p, k))).filter(|v| v.is_finite()))
    };
    let left = all(|p, k| p.residual_mm()[k]);
    let read = all(|p, k| p.measured_mm[k]);
    1.0 - (left / read).powi(2)
}
