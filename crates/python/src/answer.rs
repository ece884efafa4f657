//! Answers as dictionaries and tables.

use crate::error::Error;
use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyAny};
use serde::Serialize;
use trunnion::results::{Ladder, LadderRow};

/// An answer as dictionaries and lists: the JSON that `--json` prints, read by Python's own reader.
pub fn dictionary<'py>(py: Python<'py>, answer: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = trunnion::results::to_json_line(answer).map_err(|error| Error::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// A list of an answer as a table: one row for each, the names of its fields as columns.
pub fn table<'py>(py: Python<'py>, rows: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    pandas(py)?.call_method1("DataFrame", (dictionary(py, rows)?,))
}

/// A table that `trunnion export csv` writes.
pub fn table_of_csv<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let file = py.import("io")?.call_method1("StringIO", (text,))?;
    pandas(py)?.call_method1("read_csv", (file,))
}

/// Tables one below the other, each with the name of its run in front.
pub fn joined<'py>(py: Python<'py>, tables: Vec<(String, Bound<'py, PyAny>)>) -> PyResult<Bound<'py, PyAny>> {
    let mut all = Vec::new();
    for (run, table) in tables {
        table.call_method1("insert", (0, "run", run))?;
        all.push(table);
    }
    let counted = [("ignore_index", true)].into_py_dict(py)?;
    pandas(py)?.call_method("concat", (all,), Some(&counted))
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

fn pandas(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import("pandas").map_err(|error| match error.is_instance_of::<PyImportError>(py) {
        true => PyImportError::new_err("tables need pandas: pip install pandas"),
        false => error,
    })
}
