//! The library [`trunnion`] as a Python package.
//!
//! Each class holds a value of the library and calls it; nothing is computed here. Dictionaries are the JSON of the answers, tables are
//! those that `trunnion export` writes: a figure in a notebook is the figure of the command line. What takes time runs without
//! the lock of the interpreter, so that other threads of a notebook go on.
//! What Python sees of it is written in `python/trunnion/__init__.pyi`; a test compares the two.

mod answer;
mod classes;
mod computed;
mod diagnosed;
mod error;
mod experiment;
mod fit;
mod model;
mod prediction;
mod step;

use pyo3::prelude::*;

#[pymodule]
mod _trunnion {
    #[pymodule_export]
    use crate::classes::Diagnosed;
    #[pymodule_export]
    use crate::classes::Experiment;
    #[pymodule_export]
    use crate::classes::Fit;
    #[pymodule_export]
    use crate::classes::Model;
    #[pymodule_export]
    use crate::classes::Prediction;
    #[pymodule_export]
    use crate::classes::Step;
    #[pymodule_export]
    use crate::error::Error;
    #[pymodule_export]
    use crate::experiment::open;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
