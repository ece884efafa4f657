//! What takes time, computed without the lock of the interpreter: the same of a fit, a diagnosis and a step.

use crate::classes::{Diagnosed, Prediction, Step};
use crate::error::{Error, raised};
use pyo3::prelude::*;
use std::time::{SystemTime, UNIX_EPOCH};
use trunnion::results;

/// What a fit lacks.
pub fn diagnosed(
    py: Python<'_>,
    diagnose: impl FnOnce() -> Result<trunnion::Diagnosed, trunnion::Error> + Send,
) -> PyResult<Diagnosed> {
    Ok(Diagnosed { inner: py.detach(diagnose).map_err(raised)? })
}

/// What a fit, a diagnosis or a step predicts.
pub fn predicted(
    py: Python<'_>,
    predict: impl FnOnce() -> Result<results::Prediction, trunnion::Error> + Send,
) -> PyResult<Prediction> {
    Ok(Prediction { answer: py.detach(predict).map_err(raised)? })
}

/// What was added, with date and name in its ladder row, as the command line writes it.
pub fn added(
    py: Python<'_>,
    add: impl FnOnce() -> Result<trunnion::Step, trunnion::Error> + Send,
    date: Option<&str>,
    by: Option<&str>,
) -> PyResult<Step> {
    let date = date.map_or_else(today, |date| Ok(date.to_owned()))?;
    let step = py.detach(|| {
        let step = add()?.dated(&date)?;
        match by {
            Some(name) => step.by(name),
            None => Ok(step),
        }
    });
    Ok(Step { inner: step.map_err(raised)? })
}

/// Today, UTC, as `YYYY-MM-DD`.
fn today() -> PyResult<String> {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).ok();
    let day = since_1970.and_then(|since| trunnion::moment::day(since.as_nanos().try_into().ok()?));
    day.ok_or_else(|| Error::new_err("the clock is before 1970; give a date"))
}
