//! An effect added to a model.

use crate::answer::{dictionary, ladder_table};
use crate::classes::{Diagnosed, Experiment, Fit, Model, Prediction, Step};
use crate::computed::{added, diagnosed, predicted};
use pyo3::prelude::*;

#[pymethods]
impl Step {
    /// The effect.
    #[getter]
    fn effect(&self) -> &str {
        self.inner.effect()
    }

    /// The fit without it.
    #[getter]
    fn before(&self) -> Fit {
        Fit { inner: self.inner.before().clone() }
    }

    /// The fit with it.
    #[getter]
    fn fit(&self) -> Fit {
        Fit { inner: self.inner.fit().clone() }
    }

    /// The model with it, and with the values of the fit: `save` it to predict later runs.
    #[getter]
    fn model(&self) -> Model {
        Model { inner: self.inner.model().clone() }
    }

    /// The answer: the JSON of `trunnion add`; `model` is the name of the model file in it.
    #[pyo3(signature = (model=""))]
    fn results<'py>(&self, py: Python<'py>, model: &str) -> PyResult<Bound<'py, PyAny>> {
        dictionary(py, &py.detach(|| self.inner.results(model)))
    }

    /// The answer as text: the ladder, then the fit.
    fn summary(&self, py: Python<'_>) -> String {
        py.detach(|| self.inner.summary())
    }

    /// The ladder as a table: what adding each effect did.
    fn ladder<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        ladder_table(py, &self.inner.ladder())
    }

    /// What the model still lacks.
    fn diagnose(&self, py: Python<'_>) -> PyResult<Diagnosed> {
        diagnosed(py, || self.inner.diagnose())
    }

    /// Adds one more effect; as `Fit.add`.
    #[pyo3(signature = (effect, *, date=None, by=None))]
    fn add(&self, py: Python<'_>, effect: &str, date: Option<&str>, by: Option<&str>) -> PyResult<Self> {
        added(py, || self.inner.add(effect), date, by)
    }

    /// Predicts other runs with the values of the fit.
    fn predict(&self, py: Python<'_>, other: &Experiment) -> PyResult<Prediction> {
        predicted(py, || self.inner.predict(&other.inner))
    }

    fn __str__(&self, py: Python<'_>) -> String {
        self.summary(py)
    }

    fn __repr__(&self) -> String {
        let row = self.inner.row();
        let (before, after) = (row.error_before_um, row.error_after_um);
        format!("<trunnion.Step + {}: {before:.2} -> {after:.2} µm>", self.inner.effect())
    }
}
