//! How readings scatter: repeatability, parts of a machine's noise, weights, outliers.

pub(crate) mod learned;
pub(crate) mod likelihood;
pub mod machine_noise;
pub(crate) mod outliers;
pub(crate) mod random_columns;
pub(crate) mod repeatability;
pub(crate) mod variances;
pub(crate) mod weights;
