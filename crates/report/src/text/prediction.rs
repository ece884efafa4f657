//! A prediction of other runs, for the terminal.

use super::table::{clean, columns, paragraph};
use crate::number::{percent, um};
use std::iter::once;
use trunnion_results::{Prediction, RunPrediction};

/// Error and share inside the band of each run.
pub fn prediction_text(prediction: &Prediction) -> String {
    let mut out = format!(
        "Machine {}, fitted to: {}\nModel: {}\nThe fit leaves {} rms.\n\n",
        clean(&prediction.machine),
        clean(&prediction.fitted_runs.join(", ")),
        clean(&prediction.effects.join(" + ")),
        um(prediction.fit_rms_um)
    );
    let head =
        ["predicted run", "points", "error", "largest", "95 % band", "inside"].map(String::from).to_vec();
    let row = |run: &RunPrediction| {
        vec![
            run.run.clone(),
            run.points.to_string(),
            format!("{} rms", um(run.rms_um)),
            um(run.largest_um),
            format!("± {}", um(run.band_95_um)),
            percent(run.inside_95_fraction),
        ]
    };
    let rows: Vec<_> = once(head).chain(prediction.runs.iter().map(row)).collect();
    out += &columns(&rows, &[1, 2, 3, 4, 5]);
    if !prediction.not_determined.is_empty() {
        let names = prediction.not_determined.join(", ");
        out += "\n";
        out += &paragraph(&format!(
            "Not determined by the fitted runs, taken at zero or by convention: {names}."
        ));
    }
    out
}
