//! A prediction of other runs, for the terminal.

use super::table::{clean, paragraph, titled};
use crate::number::{percent, um};
use crate::words::{differences, not_in_band};
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

/// Whether the values hold on the runs that they were not fitted to, and what to do where they do not.
fn verdict(prediction: &Prediction) -> Option<String> {
    let others: Vec<&RunPrediction> = prediction.runs.iter().filter(|run| !run.was_fitted).collect();
    let not_held = others.iter().filter(|run| !run.holds());
    let names: Vec<String> = not_held.map(|run| clean(&run.run)).collect();
    match names.is_empty() {
        _ if others.is_empty() => None,
        true => Some("The values hold: they predict these runs.".into()),
        false => Some(format!(
            "The values do not hold for {}. Ask what changed: trunnion history with the runs of this machine, or identify the new run alone \
             and compare the values.",
            names.join(", ")
        )),
    }
}
