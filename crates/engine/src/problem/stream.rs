//! The way of a long run into a fit: sample by sample into blocks, point by point into stations.

use nalgebra::Vector3;
use trunnion_core::{Point, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Machine};
use trunnion_sync::blocks::{Limits, Reducer, Reduction};
use trunnion_sync::stations::Stations;

/// A function of the state that gives the reading, mm.
pub type Nominal = Box<dyn Fn(&State) -> [f64; 3]>;

/// A reducer that knows what a machine without errors would read.
pub fn reducer(machine: &Machine, setups: &[Setup], limits: Limits) -> Reducer<Nominal> {
    Reducer::new(limits, nominal(machine, setups))
}

/// The same for points at rest.
pub fn stations(machine: &Machine, setups: &[Setup], limits: Limits) -> Stations<Nominal> {
    Stations::new(limits.most_stations, nominal(machine, setups))
}

/// What a machine without errors would read at a state.
pub(crate) fn nominal(machine: &Machine, setups: &[Setup]) -> Nominal {
    let (machine, setups, none) = (machine.clone(), setups.to_vec(), Errors::default());
    Box::new(move |state: &State| {
        let nominal = |setup: &Setup| predict(&machine, setup, state, &none);
        setups.get(state.setup).map_or_else(Vector3::zeros, nominal).into()
    })
}

/// A run with its points reduced to blocks, and what the reduction counted.
pub fn blocks_of(run: &Run, limits: Limits) -> (Run, Reduction) {
    let mut reducer = reducer(&run.machine, &run.setups, limits);
    (0..).zip(&run.points).for_each(|(index, point)| reducer.push(index, point.clone()));
    let mut reduction = reducer.finish();
    let points = std::mem::take(&mut reduction.points);
    (with_points(run, points), reduction)
}

/// A run at rest with its points reduced to means of neighbours.
pub(crate) fn stations_of(run: &Run, limits: Limits) -> Run {
    let mut stations = stations(&run.machine, &run.setups, limits);
    (0..).zip(&run.points).for_each(|(index, point)| stations.push(index, point.clone()));
    with_points(run, stations.finish().points)
}

/// True when the run has more points than its kind is fitted with.
pub(crate) fn many(run: &Run, limits: Limits) -> bool {
    match run.kind {
        RunKind::OnTheFly => run.points.len() > limits.most_blocks,
        RunKind::Static => run.points.len() > limits.most_stations,
    }
}

fn with_points(run: &Run, points: Vec<Point>) -> Run {
    let (name, machine, kind) = (run.name.clone(), run.machine.clone(), run.kind);
    Run { name, machine, kind, setups: run.setups.clone(), channels: run.channels.clone(), points }
}
