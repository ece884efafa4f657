//! One engine gives every answer: from points and a model to a fit, its uncertainties, the
//! missing effects, and the next cycle.
//!
//! [`problem`] lays points and model out, [`noise`] says how readings scatter, [`solve`] does the arithmetic, [`fit`]
//! identifies parameters, `evidence` weighs effects against noise, [`diagnosis`] ranks what the model lacks,
//! [`compare`] says where the model fails, [`spectrum`] with which period, [`next_cycle`] plans what separates confounded effects.

pub mod compare;
pub mod diagnosis;
mod evidence;
pub mod fit;
pub mod next_cycle;
pub mod noise;
pub mod plausibility;
pub mod problem;
pub mod solve;
pub mod spectrum;
mod written;

pub use diagnosis::judged::{LearnedNoise, OpenEffect, Verdict};
pub use diagnosis::options::DiagnoseError;
pub use diagnosis::verdict::{
    Candidate, CandidateParameter, Diagnosis, FormulaProposal, NextCycle, ResidualSummary, ShapeNumber,
    Together,
};
pub use diagnosis::{diagnose, diagnose_problem};
pub use fit::between_runs::{BetweenRuns, between_runs};
pub use fit::doubts::{Doubt, doubts, doubts_of_readings};
pub use fit::identification::{
    Approach, FittedEffect, FittedParameter, GroupNoise, Holdout, Identification, NoisePart, Outlier,
    Repeatability,
};
pub use fit::identify;
pub use fit::options::{HeldOut, IdentifyError, Outliers, Uncertainties};
pub use fit::reading_noise::{BeyondModel, Patterns, ReadingNoise};
pub use problem::Problem;
pub use problem::experiment::Experiment;
pub use problem::folds::LeftOut;
pub use problem::known::KnownFits;
pub use problem::runs::ExperimentError;
pub use problem::side_by_side::readings_at;
pub use problem::stream::{Nominal, blocks_of, reducer, stations};
pub use solve::combinations::Combination;
pub use solve::direction::{Status, Unobservable};
pub use solve::golden_section::golden_section;
