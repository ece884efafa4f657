//! Many recordings as one Parquet file.

use super::request::{Format, Request};
use super::table;
use crate::outcome::Outcome;
use crate::terminal;
use anyhow::bail;
use trunnion::tables::parquet::Rows;

pub const FORMAT: Format = Format { name: "parquet", run };

fn run(request: &Request) -> anyhow::Result<Outcome> {
    let Some(path) = &request.output else { bail!("parquet is no text; name the file with -o FILE") };
    let (mut rows, mut outcome) = (Rows::begin()?, Outcome::Done);
    for run in &request.runs {
        let added = table::of(run, request.what.as_deref(), &request.model)
            .and_then(|(table, of_run)| Ok(rows.add(run, &table).map(|()| of_run)?));
        // One bad recording of a thousand costs itself alone.
        let of_run = added.unwrap_or_else(|failure| {
            terminal::remark(&format!("left out: {}: {failure:#}", run.display()));
            Outcome::DataLoss
        });
        outcome = if of_run == Outcome::Done { outcome } else { of_run };
    }
    rows.write(path)?;
    terminal::print(&format!(
        "{} rows of {} recordings: {}\n",
        rows.count(),
        request.runs.len(),
        path.display()
    ))?;
    Ok(outcome)
}
