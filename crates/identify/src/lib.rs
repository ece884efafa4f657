//! From points to parameters: design matrix, fit, null space, uncertainties.

pub mod attribution;
mod axis_errors;
mod combinations;
mod design;
pub mod experiment;
pub mod findings;
mod fit;
pub mod geometry;
mod golden;
mod identification;
mod joint;
mod likelihood;
pub mod linear;
pub mod machine_noise;
pub mod methods;
mod noise;
pub mod notation;
mod null_space;
mod options;
mod passes;
mod random_columns;
mod recipe;
mod robust;
mod settle;
mod shape;
mod show;
mod stream;
mod structured;
mod uncertainty;
mod variances;
pub mod volumetric;
mod weights;

pub use axis_errors::{AxisErrors, AxisTable, NotTabulated};
pub use combinations::Combination;
pub use experiment::{Experiment, ExperimentError};
pub use findings::Findings;
pub use fit::identify;
pub use golden::golden_section;
pub use identification::{
    FittedEffect, FittedParameter, GroupNoise, Holdout, Identification, LeftOut, Noise, NoiseOrigin,
    NoisePart, Outlier, Status, Unobservable,
};
pub use options::{HoldoutWanted, IdentifyError, Options, Outliers, Uncertainties};
pub use stream::{Nominal, blocks_of, reducer};
