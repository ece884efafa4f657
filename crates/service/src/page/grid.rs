//! What the page shows of a cycle before it runs: how it is mounted, and its poses over the rotary axes, to be filled.

use trunnion::Machine;
use trunnion::cycles::Cycle;
use trunnion::results::{CycleGrid, GridPose, PageCycle};
use trunnion_core::convert::deg_from_rad;
use trunnion_core::{NestSide, Setup};

/// A cycle on its machine; `program` begins it.
pub fn page_cycle(machine: &Machine, cycle: &Cycle, program: &str) -> PageCycle {
    PageCycle {
        name: cycle.name.clone(),
        program: program.into(),
        mounting: cycle.setups.iter().map(mounting).collect(),
        grid: grid_of(machine, cycle),
    }
}

/// What a person mounts.
fn mounting(setup: &Setup) -> String {
    let [x, y, z]: [f64; 3] = setup.ball_in_table_mm.into();
    let what = match (setup.instrument.deflects_probes(), setup.nest) {
        (true, NestSide::Table) => "the nest on the table, the ball in the spindle",
        (true, NestSide::Spindle) => "the ball on the table, the nest in the spindle",
        (false, _) => "what is measured on the table",
    };
    format!("Setup {}: {what}; its centre at X {x}, Y {y}, Z {z} mm of the table.", setup.name)
}

/// The grid of a cycle on its machine; `None` for one on the fly, or one that does not turn two axes.
fn grid_of(machine: &Machine, cycle: &Cycle) -> Option<CycleGrid> {
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
