//! A fit together with its diagnosis.

use crate::answer::{dictionary, table};
use crate::classes::{Diagnosed, Experiment, Fit, Prediction, Step};
use crate::computed::{added, predicted};
use crate::error::Error;
use pyo3::prelude::*;

#[pymethods]
impl Diagnosed {
    /// The fit that was diagnosed.
    #[getter]
    fn fit(&self) -> Fit {
        Fit { inner: self.inner.fit().clone() }
    }

    /// The answer in one word, for example `missing-effect`.
    #[getter]
    fn verdict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dictionary(py, &self.inner.results().verdict)
    }

    /// The effect that leads, if the verdict names one.
    #[getter]
    fn best(&self) -> Option<String> {
        self.inner.best()
    }

    /// The answer: the JSON of `trunnion diagnose`.
    fn results<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dictionary(py, &self.inner.results())
    }

    /// The answer as text.
    fn summary(&self) -> String {
        self.inner.summary()
    }

    /// The candidates as a table, best first.
    fn candidates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        table(py, &self.inner.results().candidates)
    }

    /// Adds an effect to the model and fits again; without a name the one that leads. `by` goes into the ladder, `date` too:
    /// without one, today (UTC).
    #[pyo3(signature = (effect=None, *, date=None, by=None))]
    fn add(
        &self,
        py: Python<'_>,
        effect: Option<&str>,
        date: Option<&str>,
        by: Option<&str>,
    ) -> PyResult<Step> {
        let best = self.inner.best();
        let Some(effect) = effect.or(best.as_deref()) else {
            return Err(Error::new_err("the diagnosis names no effect to add; name one"));
        };
        added(py, || self.inner.add(effect), date, by)
    }

    /// Predicts other runs with the values of the fit.
    fn predict(&self, py: Python<'_>, other: &Experiment) -> PyResult<Prediction> {
        predicted(py, || self.inner.predict(&other.inner))
    }

    fn __str__(&self) -> String {
        self.summary()
    }

    fn __repr__(&self) -> String {
        let machine = &self.inner.fit().experiment().machine().name;
        match self.inner.best() {
            Some(best) => format!("<trunnion.Diagnosed {machine}: it lacks {best}>"),
            None => format!("<trunnion.Diagnosed {machine}>"),
        }
    }
}
