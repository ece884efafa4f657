//! The last run of an experiment, and whether the machine stood all through it: then what it saw came with time alone.

use crate::Experiment;
use trunnion_core::Setup;
use trunnion_cycles::Run;

/// The last run of an experiment.
pub(crate) fn last_run(experiment: &Experiment) -> Option<Run> {
    let run = experiment.runs.len().checked_sub(1)?;
    let own: Vec<usize> =
        (0..experiment.points.len()).filter(|&i| experiment.run_of_point[i] == run).collect();
    (!own.is_empty()).then(|| part_of(experiment, run, &own))
}

/// Some points of one run of an experiment as a run of its own.
pub(crate) fn part_of(experiment: &Experiment, run: usize, points: &[usize]) -> Run {
    let mut used: Vec<usize> = points.iter().map(|&i| experiment.points[i].state.setup).collect();
    used.sort_unstable();
    used.dedup();
    let prefix = format!("{}.", run + 1);
    let setup = |&s: &usize| {
        let setup = &experiment.setups[s];
        // Several runs fitted together have the number of the run before the name of the setup.
        let name = if experiment.runs.len() > 1 { setup.name.strip_prefix(&prefix) } else { None };
        Setup { name: name.unwrap_or(&setup.name).into(), ..setup.clone() }
    };
    let point = |&i: &usize| {
        let mut point = experiment.points[i].clone();
        point.state.setup = used.binary_search(&point.state.setup).expect("collected above");
        point
    };
    Run {
        name: experiment.runs[run].clone(),
        machine: experiment.machine().clone(),
        kind: experiment.kinds[run],
        setups: used.iter().map(setup).collect(),
        channels: experiment.scene.channels.clone(),
        points: points.iter().map(point).collect(),
    }
}

/// True where the machine of a run stands all the time. A spindle may turn.
pub(crate) fn rests(alone: &Experiment) -> bool {
    let machine = alone.machine();
    !machine.joints().iter().any(|joint| machine.spindle != Some(*joint) && alone.scene.moves(*joint))
}
