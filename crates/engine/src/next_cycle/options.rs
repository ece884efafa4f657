//! What a plan may assume, and why none is possible.

use crate::{ExperimentError, IdentifyError};
use trunnion_cycles::{Pace, VisitError};
use trunnion_effects::UnknownEffect;

/// What a plan may assume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How fast the machine goes about a cycle.
    pub pace: Pace,
    /// ln of the Bayes factor that counts as separated.
    pub separated_ln: f64,
    /// Points of each run that take part; more are thinned evenly.
    pub most_points: usize,
}

impl Default for Options {
    /// A factor of a thousand separates.
    fn default() -> Self {
        Self { pace: Pace::default(), separated_ln: 1000f64.ln(), most_points: 600 }
    }
}

/// Beyond this ln of the Bayes factor more is of no use.
pub(super) const ENOUGH_LN: f64 = 20.0;
/// Below this ln no cycle is worth its time.
pub(super) const HOPELESS_LN: f64 = 3.0;
/// Why a plan was not possible.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The model does not fit the data.
    #[error("the model cannot be fitted to the present runs")]
    Fit(#[from] IdentifyError),
    /// An effect this machine cannot have.
    #[error("a rival cannot be placed on this machine")]
    Rival(#[from] UnknownEffect),
    /// Runs and next cycle do not go together.
    #[error("the next cycle cannot be put together with the present runs")]
    Experiment(#[from] ExperimentError),
    /// A cycle the machine cannot run.
    #[error("the cycle cannot be run")]
    Visit(#[from] VisitError),
    /// The model holds one of the rivals already.
    #[error(
        "the model holds {effect} already, so nothing remains to separate from it; name effects it lacks"
    )]
    InModel {
        /// Effect id.
        effect: String,
    },
    /// Fewer than two.
    #[error("nothing to compare; name two or more effects with --rivals")]
    NoRivals,
}
