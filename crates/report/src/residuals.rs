//! Residuals as CSV.

use crate::parameters::quoted;
use trunnion_results::Residuals;

/// Measured, predicted and residual reading of every point, µm, as a model fits it: one line for a point.
pub fn residuals_csv(residuals: &Residuals) -> String {
    let number = |value: &f64| format!("{value:.4}");
    let empty = |values: &[f64], k: usize| values.get(k).map_or_else(String::new, number);
    let axes = residuals
        .axes
        .iter()
        .map(|axis| format!("{}_{}", axis.name.to_lowercase(), if axis.rotary { "deg" } else { "mm" }));
    let read = ["measured", "predicted", "residual"].map(|what| [1, 2, 3].map(|k| format!("{what}_{k}_um")));
    let head = ["setup".to_owned(), "time_s".into()].into_iter().chain(axes).chain(read.concat());
    let mut table = head.chain(["excluded".into()]).collect::<Vec<_>>().join(",") + "\n";
    for point in &residuals.points {
        let setup = residuals.setups.get(point.setup).map_or("", |setup| &setup.name);
        let mut cells = vec![quoted(setup), point.time_s.as_ref().map_or_else(String::new, number)];
        cells.extend(point.position.iter().map(|position| format!("{position:.7}")));
        for values in [&point.measured_um, &point.predicted_um, &point.residual_um] {
            cells.extend((0..3).map(|k| empty(values, k)));
        }
        cells.push(u8::from(point.excluded).to_string());
        table += &(cells.join(",") + "\n");
    }
    table
}
