//! From points to parameters: design matrix, fit, null space, uncertainties.

mod design;
pub mod experiment;
mod fit;
mod identification;
mod joint;
pub mod linear;
mod noise;
mod null_space;
mod options;
mod passes;
mod robust;
mod settle;
mod shape;
mod show;
mod uncertainty;

pub use experiment::{Experiment, ExperimentError};
pub use fit::identify;
pub use identification::{
    FittedEffect, FittedParameter, Holdout, Identification, LeftOut, Noise, NoiseOrigin, Outlier, Status,
    Unobservable,
};
pub use options::{HoldoutWanted, IdentifyError, Options, Outliers};
