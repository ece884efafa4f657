//! Trials as files, for methods in other languages: `tests/peers/sparse_methods.py`.
//!
//! One folder a trial: `columns.npy` (rows × columns, float32, µm per unit, base model projected out), `readings.npy` (µm, base
//! model projected out; points that the base model excludes as outliers read what it predicts), `trial.json` (effect of each
//! column, the truth, our answer).

use crate::library::{library, readings};
use crate::stage::Stage;
use crate::trial::{Staged, Trial, surviving_rms_mm};
use anyhow::Context;
use nalgebra::DMatrix;
use std::path::Path;
use trunnion_tests::baselines::Library;

const UM_PER_MM: f64 = 1e3;

/// Writes one trial below `folder`.
pub fn write(folder: &Path, stage: &Stage, staged: &Staged, trial: &Trial) -> anyhow::Result<()> {
    let name = format!("{} {}", trial.case.label(), trial.case.seed).replace([' ', ':', '+'], "-");
    let folder = folder.join(name);
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let Library { columns, effect_of, .. } = library(stage, staged);
    let columns = columns * UM_PER_MM;
    let readings = readings(stage, staged)? * UM_PER_MM;
    let json = serde_json::json!({
        "format": "trunnion-blind-trial/1",
        "group": trial.case.group.name(),
        "noise": trial.case.noise.name(),
        "size": trial.case.size,
        "hidden": trial.wanted,
        "surviving_rms_um": surviving_rms_mm(stage, staged) * UM_PER_MM,
        "effect_of_column": effect_of,
        "found": trial.found,
        "outcome": trial.outcome.name(),
    });
    let write = |file: &str, bytes: &[u8]| {
        std::fs::write(folder.join(file), bytes)
            .with_context(|| format!("cannot write {file} in {}", folder.display()))
    };
    write("columns.npy", &npy(&columns))?;
    write("readings.npy", &npy(&DMatrix::from_column_slice(readings.len(), 1, readings.as_slice())))?;
    write("trial.json", json.to_string().as_bytes())
}

/// A matrix in NumPy's file format 1.0, float32, column-major.
fn npy(matrix: &DMatrix<f64>) -> Vec<u8> {
    let (rows, columns) = matrix.shape();
    let mut header = format!("{{'descr': '<f4', 'fortran_order': True, 'shape': ({rows}, {columns}), }}");
    // Magic, version, length and header fill a multiple of 64 bytes, the last of them a line feed.
    let fixed = 10;
    let padding = 63 - (fixed + header.len()) % 64;
    header.push_str(&" ".repeat(padding));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(matrix.iter().flat_map(|value| (*value as f32).to_le_bytes()));
    bytes
}
