//! The answer before anything is in it: also that of a recording that cannot be judged.

use crate::Findings;
use crate::recipes::Convention;

/// Findings of the recording `run` of a machine, without anything found yet.
pub fn findings(run: &str, machine: &str) -> Findings {
    Findings {
        excluded: 0,
        method: "attribute",
        source: "S3 §3.1",
        convention: Convention::RightHanded,
        machine: machine.into(),
        runs: vec![run.into()],
        values: Vec::new(),
        tables: Vec::new(),
        charts: Vec::new(),
        notes: Vec::new(),
    }
}
