//! From points to parameters: design matrix, fit, null space, uncertainties.

pub mod experiment;
mod fit;
mod identification;
mod options;

pub use experiment::{Experiment, ExperimentError};
pub use fit::identify;
pub use identification::{
    FittedEffect, FittedParameter, Holdout, Identification, LeftOut, Noise, NoiseOrigin, Outlier, Status,
    Unobservable,
};
pub use options::{HoldoutWanted, IdentifyError, Options, Outliers};
