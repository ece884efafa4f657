//! What kept values say of other runs.

use crate::number::{percent, um, with_unit};
use trunnion_results::{Prediction, RunPrediction, Taken};

/// How far fitted values predict the runs, in one line.
pub(crate) fn frozen_headline(frozen: &Prediction) -> &'static str {
    match frozen.runs.iter().all(RunPrediction::holds) {
        true => "The fitted values predict these runs",
        false => "These runs differ from what the fitted values predict",
    }
}

/// What kept values say of each run, and what their band holds.
pub fn frozen_sentences(frozen: &Prediction) -> Vec<String> {
    let of_run = |run: &RunPrediction| {
        let fitted =
            if run.was_fitted { " The values were fitted to this run: this is no prediction." } else { "" };
        format!(
            "Run {}: the error is {} rms, {} without the model. {} of the readings lie in the 95 % band of ± {}.{fitted}",
            run.run,
            um(run.rms_um),
            um(run.without_model_rms_um),
            percent(run.inside_95_fraction),
            um(run.band_95_um)
        )
    };
    let mut sentences: Vec<String> = frozen.runs.iter().map(of_run).collect();
    sentences.push(differences(frozen).into());
    sentences.extend(not_in_band(frozen));
    sentences
}

/// What the band lacks because the fitted runs do not determine it.
pub fn not_in_band(frozen: &Prediction) -> Option<String> {
    let one = |one: &Taken| format!("{} = {}", one.name, with_unit(one.value, &one.unit));
    let all = frozen.taken.iter().map(one).collect::<Vec<_>>().join(", ");
    (!all.is_empty()).then(|| {
        format!(
            "Not determined alone by the fitted runs, and taken as: {all}. The 95 % band does not hold what other values of these change."
        )
    })
}

/// Whether the band knows what differs between runs.
pub fn differences(frozen: &Prediction) -> &'static str {
    match frozen.differences_known {
        true => "The band holds what differed between the fitted runs.",
        false => {
            "One run was fitted: what differs from day to day is not known, and the band does not hold it."
        }
    }
}
