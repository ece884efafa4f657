//! The effects that explain a machine.

use crate::answer::{dictionary, ladder_table};
use crate::classes::{Experiment, Model, Prediction};
use crate::error::raised;
use pyo3::prelude::*;
use std::path::PathBuf;

#[pymethods]
impl Model {
    /// Reads a model file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self { inner: trunnion::Model::load(path).map_err(raised)? })
    }

    /// Writes the model file whole or not at all; comments of the file it was read from stay.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.inner.save(path).map_err(raised)
    }

    /// Ids of the effects, in order.
    #[getter]
    fn effects(&self) -> Vec<&str> {
        self.inner.effects()
    }

    /// The text of the file.
    #[getter]
    fn text(&self) -> &str {
        self.inner.text()
    }

    /// The ladder: the JSON of `trunnion ladder`.
    fn results<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dictionary(py, &self.inner.ladder())
    }

    /// The ladder as a table: what adding each effect did.
    fn ladder<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        ladder_table(py, &self.inner.ladder())
    }

    /// Predicts runs with the values that the file keeps: everything of the machine frozen, only the ball setting fitted.
    fn predict(&self, py: Python<'_>, runs: &Experiment) -> PyResult<Prediction> {
        let answer = py.detach(|| self.inner.predict(&runs.inner)).map_err(raised)?;
        Ok(Prediction { answer })
    }

    fn __repr__(&self) -> String {
        format!("<trunnion.Model {}>", self.inner.effects().join(", "))
    }
}
