//! What may be asked of a diagnosis, and why one was not possible.

use crate::fit::options::IdentifyError;

/// An effect is claimed above this ln of the odds, a factor of 20 [docs/decisions/0002-thresholds-of-model-comparison.md].
pub const CLAIM_LN: f64 = 3.0;

/// What may be asked of a diagnosis.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// An effect is claimed above this log Bayes factor (natural), after the prior for the number of candidates.
    pub claim_ln: f64,
    /// Most candidates listed.
    pub candidates: usize,
    /// Most effects the internal look-ahead adds to judge which belong together.
    pub look_ahead: usize,
    /// Ids of effects that take no part, as if the catalogue did not have them.
    pub without: Vec<String>,
    /// Ids of effects that are weighed, but not found together with others.
    pub not_added: Vec<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self { claim_ln: CLAIM_LN, candidates: 6, look_ahead: 4, without: Vec::new(), not_added: Vec::new() }
    }
}

/// Why a diagnosis was not possible.
#[derive(Clone, Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// The model cannot be fitted, so nothing can be said of what it lacks.
    #[error("the model cannot be fitted to these runs")]
    Fit(#[from] IdentifyError),
    /// No covariance of the noise can be formed.
    #[error(
        "the noise of these readings cannot be learned: they are not finite or all the same. Look at them with `trunnion check`"
    )]
    NoNoise,
    /// Hardly more readings than parameters.
    #[error(
        "{rows} readings cannot judge a model of {parameters} parameters; measure at least {} readings",
        2 * parameters
    )]
    TooFewReadings {
        /// Scalar readings.
        rows: usize,
        /// Parameters of the model that these readings can see.
        parameters: usize,
    },
}
