//! The classes, each a value of the library. What they can do is in files of their own, which know each other through these alone.

use pyo3::prelude::*;

/// Runs of one machine, opened together by `open`.
#[pyclass(frozen, module = "trunnion")]
pub struct Experiment {
    pub inner: trunnion::Experiment,
}

/// The effects that explain a machine, in the order they were added: a model file.
#[pyclass(frozen, module = "trunnion")]
pub struct Model {
    pub inner: trunnion::Model,
}

/// A model fitted to runs. `print` shows it as text.
#[pyclass(frozen, module = "trunnion")]
pub struct Fit {
    pub inner: trunnion::Fit,
}

/// A fit, and what its model lacks. `print` shows it as text.
#[pyclass(frozen, module = "trunnion")]
pub struct Diagnosed {
    pub inner: trunnion::Diagnosed,
}

/// An effect added to a model: the fits without and with it. `print` shows it as text.
#[pyclass(frozen, module = "trunnion")]
pub struct Step {
    pub inner: trunnion::Step,
}

/// Frozen values of a model against other runs. `print` shows it as text.
#[pyclass(frozen, module = "trunnion")]
pub struct Prediction {
    pub answer: trunnion::results::Prediction,
}
