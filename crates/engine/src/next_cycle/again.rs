//! The present poses once more, in both directions: the cycle for data that decide nothing. Where nothing moved there is none: a cycle of
//! the one pose would be over after a reading, and what the run saw came with time ([`crate::diagnosis::verdict::NextCycle`]).

use super::candidates::SETTLE;
use super::options::Options;
use super::planned::PlannedCycle;
use crate::Experiment;
use crate::problem::last_run::{last_run, rests};
use std::collections::BTreeSet;
use trunnion_core::Joint;
use trunnion_core::convert::{deg_from_rad, rad_from_deg};
use trunnion_cycles::cycle::{Bar, GridAxis, Motion, Rounds};
use trunnion_cycles::{Cycle, Run, RunKind};

/// Programs are written to 0.0001 mm and 0.0001° at the finest [Fanuc, increment system IS-C].
const PER_UNIT: f64 = 1e4;

/// The poses of the last run as a cycle, with what it costs; `None` on the fly, where nothing moved, and where they are no grid that a cycle
/// file can write.
pub(super) fn again(experiment: &Experiment, options: &Options) -> Option<(Cycle, PlannedCycle)> {
    let run = last_run(experiment)?;
    if run.kind != RunKind::Static {
        return None;
    }
    let cycle = cycle(run)?;
    let visits = cycle.visits(experiment.machine(), &options.pace).ok()?;
    let planned = PlannedCycle {
        name: cycle.name.clone(),
        what: "the present poses once more, in both directions".into(),
        minutes: visits.duration_s / 60.0,
        separation_before: None,
        separation: None,
        separates: Vec::new(),
        file: cycle.to_text(),
    };
    Some((cycle, planned))
}

fn cycle(run: Run) -> Option<Cycle> {
    let (setups, name) = (run.setups.clone(), format!("{}-again", run.name));
    let alone = Experiment::new(&[run]).ok()?;
    if rests(&alone) {
        return None;
    }
    let machine = alone.machine();
    // Linear axes follow the ball unless one moved by itself: then the cycle has to name all of them.
    let scene = &alone.scene;
    let named = machine.linear_joints().into_iter().any(|joint| scene.measures_volume(joint));
    let mut letters = machine.rotary_joints();
    letters.retain(|joint| machine.spindle != Some(*joint));
    if named || !letters.iter().any(|joint| scene.moves(*joint)) {
        letters.extend(machine.linear_joints());
    }
    let grid: Vec<GridAxis> = letters.iter().map(|letter| stations(&alone, *letter)).collect();
    let visited: BTreeSet<Vec<usize>> = {
        let stands: Vec<Vec<usize>> = letters.iter().map(|letter| alone.stands(&[*letter])).collect();
        let setup = |i: usize| alone.points[i].state.setup;
        (0..alone.points.len())
            .map(|i| std::iter::once(setup(i)).chain(stands.iter().map(|of| of[i])).collect())
            .collect()
    };
    // A scatter of positions spans a grid of more poses than can be counted: it is none.
    let whole = grid.iter().try_fold(setups.len(), |poses, axis| poses.checked_mul(axis.stations.len()))?;
    (visited.len() == whole).then(|| Cycle {
        name,
        machine: machine.name.clone(),
        setups,
        motion: Motion::Static { grid, passes: vec![1.0, -1.0], settle: SETTLE },
        rounds: Rounds::default(),
        bar: Bar::default(),
    })
}

/// Where an axis stood, in the order of its positions, to what a control can be given.
fn stations(experiment: &Experiment, letter: Joint) -> GridAxis {
    let positions = experiment.positions(letter);
    let mut seen = BTreeSet::new();
    let first_there = |(i, stand): (usize, usize)| {
        let row = experiment.rows_of(i).start;
        seen.insert(stand).then(|| positions[row])
    };
    let stands = experiment.stands(&[letter]).into_iter().enumerate();
    let mut stations: Vec<f64> = stands.filter_map(first_there).collect();
    stations.sort_by(f64::total_cmp);
    let programmable = |x: f64| (x * PER_UNIT).round() / PER_UNIT;
    let rounded = |x: f64| {
        if letter.is_rotary() { rad_from_deg(programmable(deg_from_rad(x))) } else { programmable(x) }
    };
    GridAxis { letter, stations: stations.into_iter().map(rounded).collect() }
}
