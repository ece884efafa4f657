//! What several named methods share: readings as displacements, readings of an axis that turns alone, and their means over
//! angle.

pub(crate) mod harmonics;
pub(crate) mod over_height;
pub(crate) mod relative;
pub(crate) mod stations;
pub(crate) mod turning;

use trunnion_core::{Point, Setup};
use trunnion_cycles::Run;

/// The good readings of one setup of one run.
pub(crate) struct Mounted<'a> {
    /// Name of the setup, with the number of its run where there are several.
    pub name: String,
    pub run: &'a Run,
    pub setup: &'a Setup,
    pub points: Vec<&'a Point>,
}

/// Every setup that was read.
pub(crate) fn mounted(runs: &[Run]) -> Vec<Mounted<'_>> {
    let mut all = Vec::new();
    for (i, run) in runs.iter().enumerate() {
        for (s, setup) in run.setups.iter().enumerate() {
            let points: Vec<&Point> = run.good_points().filter(|p| p.state.setup == s).collect();
            let name = if runs.len() > 1 { format!("{}.{}", i + 1, setup.name) } else { setup.name.clone() };
            all.push(Mounted { name, run, setup, points });
        }
    }
    all.retain(|mounted| !mounted.points.is_empty());
    all
}
