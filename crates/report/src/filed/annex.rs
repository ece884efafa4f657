//! The tables of the end: the fit, what was excluded, every reading.

use crate::markup::{element, table};
use crate::number::{MISSING, fixed, plain, um, um_or_dash};
use crate::words::{left_out, noise_origin};
use trunnion_results::{Identification, ResidualPoint, Residuals};

/// Readings listed: some thirty pages. `trunnion export` writes them all.
const MOST_READINGS: usize = 1500;

pub fn fit(fit: &Identification) -> String {
    let count = |number: usize| number.to_string();
    let rows = [
        ("Residual, rms", um(fit.rms_um), String::new()),
        ("Repeatability", um_or_dash(fit.noise_um), noise_origin(fit)),
        ("Held-out error", um_or_dash(fit.holdout_rms_um), left_out(fit.holdout_unit)),
        ("Points", count(fit.points), String::new()),
        ("Excluded points", count(fit.outliers), String::new()),
        ("Rank", count(fit.rank), String::new()),
        ("Condition number", fit.condition.map_or(MISSING.into(), plain), String::new()),
        ("Degrees of freedom", count(fit.degrees_of_freedom), String::new()),
    ]
    .map(|(name, value, remark)| vec![name.to_string(), value, remark]);
    let mut body = table("The fit", &["figure", "value", "remark"], &[1], &rows);
    let parts: Vec<_> = fit.noise_parts.iter().map(|part| vec![part.part.clone(), um(part.um)]).collect();
    if !parts.is_empty() {
        body += &table("Parts of the noise behind the uncertainties", &["part", "size"], &[1], &parts);
    }
    let runs: Vec<_> = fit
        .noise_by_run
        .iter()
        .map(|noise| {
            let readings = noise.readings.to_string();
            vec![noise.run.clone(), noise.instrument.clone(), readings, um(noise.rms_um), um(noise.floor_um)]
        })
        .collect();
    if !runs.is_empty() {
        let head = ["run", "instrument", "readings", "residual, rms", "does not average down"];
        body += &table("Noise of each run", &head, &[2, 3, 4], &runs);
    }
    let outliers: Vec<_> = fit
        .outlier_points
        .iter()
        .map(|point| vec![point.run.clone(), point.setup.clone(), point.pose.clone(), um(point.residual_um)])
        .collect();
    if !outliers.is_empty() {
        body += &table("Excluded points", &["run", "setup", "pose", "residual"], &[3], &outliers);
    }
    format!("<section><h2>Fit and noise</h2>\n{body}</section>\n")
}

/// Every reading: where, measured, residual; what the model predicts is their difference.
pub fn readings(residuals: &Residuals) -> String {
    let axes: Vec<String> = residuals
        .axes
        .iter()
        .map(|axis| format!("{} ({})", axis.name, if axis.rotary { "°" } else { "mm" }))
        .collect();
    let ends = ["measured (µm)", "residual (µm)", "remark"];
    let head: Vec<&str> = ["setup"].into_iter().chain(axes.iter().map(String::as_str)).chain(ends).collect();
    let row = |point: &ResidualPoint| {
        let setup = residuals.setups.get(point.setup).map_or(MISSING.into(), |setup| setup.name.clone());
        let places = point.position.iter().map(|at| two_decimals(*at));
        let readings = [&point.measured_um, &point.residual_um]
            .map(|values| values.iter().map(|value| two_decimals(*value)).collect::<Vec<_>>().join(" / "));
        let remark = if point.excluded { "excluded" } else { "" };
        [setup].into_iter().chain(places).chain(readings).chain([remark.to_string()]).collect::<Vec<_>>()
    };
    let rows: Vec<_> = residuals.points.iter().take(MOST_READINGS).map(row).collect();
    let numeric: Vec<usize> = (1..head.len() - 1).collect();
    let rest = residuals.points.len().saturating_sub(MOST_READINGS);
    let rest = match rest {
        0 => String::new(),
        rest => element("p", &format!("{rest} further readings: trunnion export csv RUN --what residuals")),
    };
    let caption = "Readings in the order in which they were taken; components of the nest, divided by /";
    format!(
        "<section class=\"readings\"><h2>Readings</h2>\n{}{rest}</section>\n",
        table(caption, &head, &numeric, &rows)
    )
}

/// Two decimals: 10 µm and 0.01° of a position, 0.01 µm of a reading.
fn two_decimals(value: f64) -> String {
    fixed(value, 2)
}
