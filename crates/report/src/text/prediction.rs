//! A prediction of other runs, for the terminal.

use super::table::{clean, paragraph, titled};
use crate::number::{percent, um};
use crate::to_do::ask;
use crate::words::{differences, frozen_headline, not_in_band};
use std::iter::once;
use trunnion_results::{Prediction, RunPrediction};

/// Error and share inside the band of each run.
pub fn prediction_text(prediction: &Prediction) -> String {
    let mut out = verdict(prediction).map_or(String::new(), |verdict| paragraph(&verdict) + "\n");
    out += &format!(
        "Machine {}, fitted to: {}{}\nModel: {}\nA reading scatters by {} rms about the model.\n\n",
        clean(&prediction.machine),
        clean(&prediction.fitted_runs.join(", ")),
        if prediction.fitted_on.is_empty() {
            String::new()
        } else {
            format!(" ({})", clean(&prediction.fitted_on))
        },
        clean(&prediction.effects.join(" + ")),
        um(prediction.reading_um)
    );
    let head = ["predicted run", "points", "error", "without model", "largest", "95 % band", "inside"]
        .map(String::from)
        .to_vec();
    let row = |run: &RunPrediction| {
        vec![
            if run.was_fitted { format!("{} *", run.run) } else { run.run.clone() },
            run.points.to_string(),
            format!("{} rms", um(run.rms_um)),
            format!("{} rms", um(run.without_model_rms_um)),
            um(run.largest_um),
            format!("± {}", um(run.band_95_um)),
            percent(run.inside_95_fraction),
        ]
    };
    let rows: Vec<_> = once(head).chain(prediction.runs.iter().map(row)).collect();
    out += &titled(&rows, &[1, 2, 3, 4, 5, 6]);
    if prediction.runs.iter().any(|run| run.was_fitted) {
        out += &paragraph("* The model was fitted to this run: this is no prediction of it.");
    }
    out += "\n";
    for run in &prediction.runs {
        if let Some(distance_um) = run.mean_distance_um {
            let name = clean(&run.run);
            out +=
                &paragraph(&format!("{name}: mean distance of measured from predicted {}.", um(distance_um)));
        }
    }
    out += &paragraph(differences(prediction));
    out + &not_in_band(prediction).map_or(String::new(), |sentence| paragraph(&sentence))
}

/// As of kept values in a comparison; nothing of runs that were all fitted.
fn verdict(prediction: &Prediction) -> Option<String> {
    let is_one_predicted = prediction.runs.iter().any(|run| !run.was_fitted);
    is_one_predicted.then(|| format!("{}. {}", frozen_headline(prediction), ask(Some(prediction))))
}
