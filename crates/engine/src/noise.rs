//! How readings scatter: repeatability, parts of a machine's noise, weights, outliers.

pub(crate) mod learned;
pub mod machine_noise;
pub(crate) mod outliers;
pub(crate) mod repeatability;
pub(crate) mod weights;
