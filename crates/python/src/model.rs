//! The effects that explain a machine.

use crate::answer::{dictionary, table};
use crate::error::raised;
use crate::experiment::Experiment;
use crate::prediction::Prediction;
use pyo3::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use trunnion::results::{Ladder, LadderRow};

/// The effects that explain a machine, in the order they were added: a model file.
#[pyclass(frozen, module = "trunnion")]
pub struct Model {
    pub inner: trunnion::Model,
}

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

/// One effect that was added: its columns are the fields of its ladder row.
#[derive(Serialize)]
struct Added<'l> {
    effect: &'l str,
    #[serde(flatten)]
    row: &'l LadderRow,
}

/// The effects that were added, one row each; the effects of every model have no ladder row.
pub fn ladder_table<'py>(py: Python<'py>, ladder: &Ladder) -> PyResult<Bound<'py, PyAny>> {
    let added = |(effect, row)| Added { effect, row };
    let rows = ladder.rows.iter().filter_map(|entry| Some((entry.effect.as_str(), entry.ladder.as_ref()?)));
    table(py, &rows.map(added).collect::<Vec<_>>())
}
