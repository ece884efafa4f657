//! The poses of a cycle over its rotary axes, to be filled while it is measured.

use trunnion::Machine;
use trunnion::cycles::Cycle;
use trunnion::results::{CycleGrid, GridPose};
use trunnion_core::convert::deg_from_rad;

/// The grid of a cycle on its machine; `None` for one on the fly, or one that does not turn two axes.
pub fn grid_of(machine: &Machine, cycle: &Cycle) -> Option<CycleGrid> {
    let poses = cycle.poses(machine).filter(|poses| !poses.is_empty())?;
    let [first, second] = machine.rotary_joints()[..] else { return None };
    let distinct = |joint| {
        let mut at: Vec<i64> = poses.iter().map(|pose| (pose.position[joint] * 1e6) as i64).collect();
        at.sort_unstable();
        at.dedup();
        at.len()
    };
    // The one with more positions has the columns, as on the maps of the report.
    let axes = if distinct(first) > distinct(second) { [second, first] } else { [first, second] };
    Some(CycleGrid {
        name: cycle.name.clone(),
        axes: axes.map(|joint| joint.to_string()),
        setups: cycle.setups.iter().map(|setup| setup.name.clone()).collect(),
        poses: poses
            .iter()
            .map(|pose| GridPose {
                setup: pose.setup,
                at_deg: axes.map(|joint| deg_from_rad(pose.position[joint])),
            })
            .collect(),
    })
}
