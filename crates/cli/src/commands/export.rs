//! `trunnion export`: the points of a recording as a table, its samples, residuals or parameters; of many as one; a recording for viewers.

mod csv;
mod foxglove;
mod parquet;
mod request;
mod table;

use crate::outcome::Outcome;
use crate::{load, output};
use anyhow::bail;
use clap::builder::PossibleValuesParser;
use request::{Format, Request};
use std::path::PathBuf;

/// Export recordings as a table, or for a 3D viewer
///
/// points: the good points, as `import` reads them. every-point: unsettled points and those without a reading too, with the
/// columns `quality` and `why`. samples: what each probe sent, with raw numbers and ticks. axes: positions of the axes. residuals: measured, predicted
/// and residual reading of every pose, as --model fits it. effects: what each effect of the model makes of each reading; effects
/// that are confounded in the run are one. parameters: what that fit found. runs: the fit in one row;
/// without --model that of NAME.model.toml next to the recording, where there is one, with the verdict and the missing effects that the
/// service found.
///
/// Parquet takes many recordings in one table, with machine, serial number, run and its beginning in front.
///
/// Foxglove is an MCAP file with what viewers draw by themselves: machine, ball, errors as magnified arrows, events; next to it a layout.
///
/// Example: trunnion export csv run.mcap -o points.csv
///
/// Example: trunnion export parquet runs/*.mcap --what parameters -o parameters.parquet
///
/// Example: trunnion export foxglove run.mcap -o view.mcap
#[derive(clap::Args)]
pub struct Args {
    /// What to write
    #[arg(value_parser = PossibleValuesParser::new(FORMATS.iter().map(|format| format.name)))]
    format: String,
    #[command(flatten)]
    request: Request,
}

/// Every format.
const FORMATS: &[Format] = &[csv::FORMAT, foxglove::FORMAT, parquet::FORMAT];

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let Request { runs, model, output, .. } = &args.request;
    let inputs = runs.iter().chain(&model.model).map(PathBuf::as_path);
    output::not_an_input(&[("-o", output.as_deref())], inputs)?;
    for run in runs {
        load::no_points_file(run)?;
    }
    if args.request.magnification.is_some() && args.format != foxglove::FORMAT.name {
        bail!("--magnification is for foxglove: a table has no arrows");
    }
    match FORMATS.iter().find(|format| format.name == args.format) {
        Some(format) => (format.run)(&args.request),
        None => bail!("there is no format {}", args.format),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_file_with_a_format_is_in_the_list_under_its_name() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/commands/export");
        let mut files = BTreeSet::new();
        for file in std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()) {
            if std::fs::read_to_string(&file).unwrap().contains("const FORMAT: Format") {
                files.insert(file.file_stem().unwrap().to_string_lossy().into_owned());
            }
        }
        let listed: Vec<String> = FORMATS.iter().map(|format| format.name.to_string()).collect();
        assert_eq!(
            listed.iter().cloned().collect::<BTreeSet<_>>(),
            files,
            "FORMATS in crates/cli/src/commands/export.rs"
        );
        assert_eq!(listed.len(), files.len(), "each name once");
    }
}
