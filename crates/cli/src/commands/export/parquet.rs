//! Many recordings as one Parquet file.

use super::request::{Format, Request};
use super::table;
use crate::outcome::Outcome;
use crate::{output, terminal};
use anyhow::bail;
use trunnion::tables::parquet::Rows;
use trunnion_core::number::counted;

pub const FORMAT: Format = Format { name: "parquet", run };

fn run(request: &Request) -> anyhow::Result<Outcome> {
    let Some(path) = &request.output else { bail!("parquet is no text; name the file with -o FILE") };
    let (mut rows, mut outcome, mut read) = (Rows::begin()?, Outcome::Done, 0_u64);
    for run in &request.runs {
        let added = table::of(run, request.what.as_deref(), &request.model)
            .and_then(|(table, of_run)| Ok(rows.add(run, &table).map(|()| of_run)?));
        read += u64::from(added.is_ok());
        // One bad recording of a thousand costs itself alone.
        let of_run = added.unwrap_or_else(|failure| {
            terminal::remark(&format!("left out: {}: {failure:#}", run.display()));
            Outcome::DataLoss
        });
        outcome = if of_run == Outcome::Done { outcome } else { of_run };
    }
    if read == 0 {
        bail!("none of the recordings can be read, so {} was not written", path.display());
    }
    output::write(path, &rows.file()?)?;
    let (rows, read) = (counted(rows.count() as u64, "row"), counted(read, "recording"));
    terminal::print(&format!("{rows} of {read}: {}\n", path.display()))?;
    Ok(outcome)
}
