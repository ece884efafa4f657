//! Residuals as CSV.

use crate::parameters::quoted;
use trunnion_core::number::in_table;
use trunnion_results::{ResidualAxis, ResidualPoint, Residuals};

/// Measured, predicted and residual reading of every point, µm, as a model fits it: one line for a point.
pub fn residuals_csv(residuals: &Residuals) -> String {
    let read = ["measured", "predicted", "residual"].map(|what| [1, 2, 3].map(|k| format!("{what}_{k}_um")));
    let mut table = head(residuals, read.concat().into_iter().chain(["excluded".into()]));
    for point in &residuals.points {
        let mut cells = place(residuals, point);
        for values in [&point.measured_um, &point.predicted_um, &point.residual_um] {
            cells.extend((0..3).map(|k| empty(values, k)));
        }
        cells.push(u8::from(point.excluded).to_string());
        table += &(cells.join(",") + "\n");
    }
    table
}

/// What each part of a model makes of the reading of every point, µm: one line for a point and part. A part is the names of its
/// effects and its readings of the points listed.
pub fn by_effect_csv(residuals: &Residuals, parts: &[(String, Vec<Vec<f64>>)]) -> String {
    let read = [1, 2, 3].map(|k| format!("taken_{k}_um"));
    let mut table = head(residuals, ["effects".to_owned()].into_iter().chain(read));
    for (i, point) in residuals.points.iter().enumerate() {
        for (effects, taken_um) in parts {
            let mut cells = place(residuals, point);
            cells.push(quoted(effects));
            cells.extend((0..3).map(|k| empty(&taken_um[i], k)));
            table += &(cells.join(",") + "\n");
        }
    }
    table
}

fn head(residuals: &Residuals, read: impl Iterator<Item = String>) -> String {
    let axis = |axis: &ResidualAxis| {
        format!("{}_{}", axis.name.to_lowercase(), if axis.rotary { "deg" } else { "mm" })
    };
    let head = ["setup".to_owned(), "time_s".into()].into_iter().chain(residuals.axes.iter().map(axis));
    head.chain(read).collect::<Vec<_>>().join(",") + "\n"
}

/// The cells in front of every line of a point.
fn place(residuals: &Residuals, point: &ResidualPoint) -> Vec<String> {
    let setup = residuals.setups.get(point.setup).map_or("", |setup| &setup.name);
    let mut cells = vec![quoted(setup), point.time_s.as_ref().map_or_else(String::new, number)];
    cells.extend(point.position.iter().map(|position| in_table(*position, 7)));
    cells
}

fn number(value: &f64) -> String {
    in_table(*value, 4)
}

/// A component that the instrument does not have is empty.
fn empty(values: &[f64], k: usize) -> String {
    values.get(k).map_or_else(String::new, number)
}
