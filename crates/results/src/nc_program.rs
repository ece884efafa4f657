//! A cycle as a program of a controller.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `trunnion-nc-program/1`: the program of a cycle, with the poses it must visit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NcProgram {
    /// Format and version.
    pub format: NcProgramFormat,
    /// Name of the cycle.
    pub cycle: String,
    /// Controller that it is written for.
    pub dialect: String,
    /// Machine time without stops, min.
    pub minutes: f64,
    /// Largest distance of the straight blocks of a sweep from its path, µm.
    pub chord_um: f64,
    /// True where it runs with tool centre point control of the machine.
    #[serde(default)]
    pub tcp: bool,
    /// Poses in order: `x_mm`, `c_deg`, …, and where a pose is read in motion its speeds `vx_mm_per_s`, `vc_deg_per_s`, ….
    pub visits: Vec<BTreeMap<String, f64>>,
    /// The program.
    pub program: String,
}

/// Format and version of a program with its poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum NcProgramFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-nc-program/1")]
    V1,
}
