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
    /// The cycles that are measured here, in the order of the configuration; none where nothing is measured.
    pub cycles: Vec<PageCycle>,
    /// True where this page chooses, begins and ends cycles.
    pub operates: bool,
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

/// A cycle that can be measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PageCycle {
    /// Its name.
    pub name: String,
    /// Programs that begin it, `*` for anything; empty: every program that no other cycle names.
    pub program: String,
    /// How each of its setups is mounted, in their order.
    pub mounting: Vec<String>,
    /// Its poses; null for one on the fly, or one that does not turn two axes.
    pub grid: Option<CycleGrid>,
}

/// The poses of a cycle over its two rotary axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CycleGrid {
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
