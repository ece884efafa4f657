//! Frozen values of a model against other runs.

use crate::answer::{dictionary, table};
use crate::classes::Prediction;
use pyo3::prelude::*;
use trunnion::report;

#[pymethods]
impl Prediction {
    /// The answer: the JSON of `trunnion predict`.
    fn results<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dictionary(py, &self.answer)
    }

    /// The answer as text.
    fn summary(&self) -> String {
        report::prediction_text(&self.answer)
    }

    /// Each run that was predicted as a table: its error, and the share of readings inside the 95 % band.
    fn runs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        table(py, &self.answer.runs)
    }

    fn __str__(&self) -> String {
        self.summary()
    }

    fn __repr__(&self) -> String {
        let names = self.answer.runs.iter().map(|run| run.run.as_str()).collect::<Vec<_>>().join(", ");
        format!("<trunnion.Prediction {}: {names}>", self.answer.machine)
    }
}
