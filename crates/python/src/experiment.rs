//! Runs opened together.

use crate::answer::{dictionary, joined, table_of_csv};
use crate::classes::{Experiment, Fit, Model};
use crate::error::raised;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use std::ffi::CString;
use std::path::PathBuf;

/// Opens recordings (`.mcap`), or points files (`.csv`) with their `setup.toml`; several runs of one machine are fitted together.
///
/// Damage of a file, and the reduction of a long run to blocks, are warnings. A file that cannot be read raises `Error`.
#[pyfunction]
#[pyo3(signature = (*paths))]
pub fn open(py: Python<'_>, paths: Vec<PathBuf>) -> PyResult<Experiment> {
    let inner = py.detach(|| trunnion::open_all(paths)).map_err(raised)?;
    for text in inner.damage().iter().chain(&inner.reductions()) {
        let text = CString::new(text.replace('\0', " "))?;
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)?;
    }
    Ok(Experiment { inner })
}

#[pymethods]
impl Experiment {
    /// Name of the machine.
    #[getter]
    fn machine(&self) -> String {
        self.inner.machine().name.clone()
    }

    /// Names of the runs.
    #[getter]
    fn runs(&self) -> Vec<String> {
        self.inner.points().runs.clone()
    }

    /// What is wrong with the files, one sentence for each that is damaged.
    #[getter]
    fn damage(&self) -> Vec<String> {
        self.inner.damage()
    }

    /// Can these runs be what they say they are: the JSON of `trunnion check`.
    fn check<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dictionary(py, &py.detach(|| self.inner.check()))
    }

    /// The good points as a table: the columns of `trunnion export csv`, with the name of the run in front.
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let texts = py.detach(|| self.inner.points_csv());
        let tables = texts.into_iter().map(|(run, text)| Ok((run, table_of_csv(py, &text)?)));
        joined(py, tables.collect::<PyResult<_>>()?)
    }

    /// The model that every other begins with: location errors and ball setting.
    fn base_model(&self) -> Model {
        Model { inner: self.inner.base_model() }
    }

    /// Fits every effect of a model to the runs together; without one, the base model.
    #[pyo3(signature = (model=None))]
    fn fit(&self, py: Python<'_>, model: Option<&Model>) -> PyResult<Fit> {
        let inner = py.detach(|| match model {
            Some(model) => self.inner.fit(&model.inner),
            None => self.inner.fit(&self.inner.base_model()),
        });
        Ok(Fit { inner: inner.map_err(raised)? })
    }

    fn __repr__(&self) -> String {
        let points = self.inner.points();
        format!(
            "<trunnion.Experiment {}: {}, {} points>",
            self.machine(),
            points.runs.join(", "),
            points.points.len()
        )
    }
}
