//! What the page shows before anything is asked: who serves, and what is measured.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `trunnion-page/1`: what the page serves, and the present value of everything that the service publishes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PageStatus {
    /// Format and version.
    pub format: PageFormat,
    /// Program and version.
    pub program: String,
    /// What is behind the page.
    pub serves: Serves,
    /// Name of the machine tool or of the recording.
    pub name: String,
    /// The cycle that is measured here; null where nothing is measured, or no grid of poses.
    pub cycle: Option<CycleGrid>,
    /// The topics of the service (docs/design/protocols.md §5), with the texts that MQTT gets.
    pub topics: BTreeMap<String, serde_json::Value>,
}

/// Format and version of a page's status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PageFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-page/1")]
    V1,
}

/// What is behind the page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Serves {
    /// Recordings; nothing is measured.
    #[default]
    Recordings,
    /// The service at a machine.
    Service,
    /// The demo on the simulator.
    Demo,
}

/// The poses of a cycle over its two rotary axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CycleGrid {
    /// Name of the cycle.
    pub name: String,
    /// The rotary axis of the rows, and that of the columns.
    pub axes: [String; 2],
    /// Names of the setups.
    pub setups: Vec<String>,
    /// Poses in the order in which they are read.
    pub poses: Vec<GridPose>,
}

/// A pose of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GridPose {
    /// Index of its setup.
    pub setup: usize,
    /// Positions of the two axes, degrees.
    pub at_deg: [f64; 2],
}
