//! Errors as exceptions, in the sentence that the command line prints.

use pyo3::exceptions::PyException;
use pyo3::{PyErr, create_exception};

create_exception!(
    trunnion,
    Error,
    PyException,
    "Why there is no answer: what was done to what, and the causes behind it."
);

/// The error with its chain of causes.
pub fn raised(error: trunnion::Error) -> PyErr {
    Error::new_err(trunnion::chain(&error))
}
