//! Which physical effect is missing from the model.
//!
//! The evidence of every catalogued effect is weighed against noise as real machines make it (drift, re-positioning
//! scatter), averaged over a bank of such noises, and every winner has to defend itself against an open grammar of shapes
//! that have no name.

mod answer;
pub(crate) mod columns;
mod contest;
mod families;
mod least_squares;
mod phrases;
mod problem;
mod refine;
mod search;
pub mod verdict;
mod vocabulary;
mod words;

use crate::Experiment;
use trunnion_effects::{Model, UnknownEffect};
use verdict::Diagnosis;

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
}

impl Default for Options {
    fn default() -> Self {
        Self { claim_ln: 3.0, candidates: 6, look_ahead: 4, without: Vec::new() }
    }
}

/// Why a diagnosis was not possible.
#[derive(Clone, Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// The model names an effect that this machine cannot have.
    #[error("the model cannot be fitted to these runs")]
    Model(#[from] UnknownEffect),
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

/// Ranks the effects that the model lacks.
///
/// # Errors
/// A model that does not fit the machine, or too few readings.
pub fn diagnose(
    experiment: &Experiment,
    model: &Model,
    options: &Options,
) -> Result<Diagnosis, DiagnoseError> {
    let thinned = thinned(experiment);
    let problem = problem::Problem::new(thinned.as_ref().unwrap_or(experiment), model, &options.without)?;
    Ok(answer::answer(&problem, model, options))
}

/// Points on the fly that a scan looks at.
const MOST_POINTS: usize = 700;

/// Every k-th point of what was read on the fly, where there are many: neighbours say the same, and the whole grammar has thousands of
/// columns. Points at rest all stay.
fn thinned(experiment: &Experiment) -> Option<Experiment> {
    let on_the_fly =
        |i: usize| experiment.kinds[experiment.run_of_point[i]] == trunnion_cycles::RunKind::OnTheFly;
    let points = experiment.points.len();
    let many = (0..points).filter(|&i| on_the_fly(i)).count();
    let step = many.div_ceil(MOST_POINTS);
    if step < 2 {
        return None;
    }
    let mut seen = 0;
    let keep: Vec<bool> = (0..points)
        .map(|i| {
            seen += usize::from(on_the_fly(i));
            !on_the_fly(i) || seen % step == 1
        })
        .collect();
    Some(experiment.kept(&keep))
}
