//! What is asked of an export, and what a format is.

use super::table;
use crate::load::ModelArgs;
use crate::outcome::Outcome;
use std::path::PathBuf;

/// What of which recordings goes where.
#[derive(clap::Args)]
pub struct Request {
    /// Recordings; one for csv and foxglove
    #[arg(required = true, value_name = "RUN")]
    pub runs: Vec<PathBuf>,
    /// Part of the recording [default: points]
    #[arg(long, value_name = "PART", value_parser = table::parts())]
    pub what: Option<String>,
    #[command(flatten)]
    pub model: ModelArgs,
    /// Length of the arrows against the errors; without it the largest is a quarter of the picture
    #[arg(long, value_name = "N", value_parser = magnification)]
    pub magnification: Option<f64>,
    /// File to write; without it, standard output (csv)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// A format of export.
pub struct Format {
    /// Its name on the command line.
    pub name: &'static str,
    /// Writes it.
    pub run: fn(&Request) -> anyhow::Result<Outcome>,
}

fn magnification(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(times) if (1.0..=1e6).contains(&times) => Ok(times),
        _ => Err("allowed: 1..=1000000".into()),
    }
}
