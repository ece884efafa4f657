//! A recording as CSV.

use super::request::{Format, Request};
use super::table;
use crate::outcome::Outcome;
use crate::{output, terminal};
use anyhow::bail;

pub const FORMAT: Format = Format { name: "csv", run };

fn run(request: &Request) -> anyhow::Result<Outcome> {
    let [run] = &request.runs[..] else {
        bail!("csv is a table of one recording, and {} are named; parquet takes many", request.runs.len())
    };
    let (table, outcome) = table::of(run, request.what.as_deref(), &request.model)?;
    match &request.output {
        None => terminal::print_verbatim(&table)?,
        Some(path) => output::write(path, &table)?,
    }
    Ok(outcome)
}
