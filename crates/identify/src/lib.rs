//! From points to parameters: design matrix, fit, null space, uncertainties.

pub mod experiment;

pub use experiment::{Experiment, ExperimentError};
