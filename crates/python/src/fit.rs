//! A model fitted to runs.

use crate::answer::{dictionary, table_of_csv};
use crate::classes::{Diagnosed, Experiment, Fit, Model, Prediction, Step};
use crate::computed::{added, diagnosed, predicted};
use pyo3::prelude::*;
use trunnion::report::{parameters_csv, residuals_csv};

#[pymethods]
impl Fit {
    /// The runs.
    #[getter]
    fn experiment(&self) -> Experiment {
        Experiment { inner: self.inner.experiment().clone() }
    }

    /// The model.
    #[getter]
    fn model(&self) -> Model {
        Model { inner: self.inner.model().clone() }
    }

    /// The answer: the JSON of `trunnion identify`.
    fn results<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dictionary(py, &py.detach(|| self.inner.identified()))
    }

    /// The answer as text.
    fn summary(&self, py: Python<'_>) -> String {
        py.detach(|| self.inner.summary())
    }

    /// The parameters as a table, with value, standard uncertainty and unit: the columns of `trunnion export csv --what parameters`.
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        table_of_csv(py, &py.detach(|| parameters_csv(&self.inner.results())))
    }

    /// Measured, predicted and residual reading of every point as a table: the columns of `trunnion export csv --what residuals`.
    fn residuals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        table_of_csv(py, &py.detach(|| residuals_csv(&self.inner.residuals())))
    }

    /// Which effect the model lacks; where candidates are confounded, the cycle that separates them is planned too.
    fn diagnose(&self, py: Python<'_>) -> PyResult<Diagnosed> {
        diagnosed(py, || self.inner.diagnose())
    }

    /// Adds an effect to the model and fits again; `by` goes into the ladder, `date` too: without one, today (UTC).
    #[pyo3(signature = (effect, *, date=None, by=None))]
    fn add(&self, py: Python<'_>, effect: &str, date: Option<&str>, by: Option<&str>) -> PyResult<Step> {
        added(py, || self.inner.add(effect), date, by)
    }

    /// Predicts other runs with the values of this fit: everything of the machine frozen, only the ball setting fitted.
    fn predict(&self, py: Python<'_>, other: &Experiment) -> PyResult<Prediction> {
        predicted(py, || self.inner.predict(&other.inner))
    }

    fn __str__(&self, py: Python<'_>) -> String {
        self.summary(py)
    }

    fn __repr__(&self) -> String {
        let effects = self.inner.model().effects().join(", ");
        format!("<trunnion.Fit {}: {effects}>", self.inner.experiment().machine().name)
    }
}
