//! The way of an on-the-fly run into a fit: sample by sample into blocks.

use nalgebra::Vector3;
use trunnion_core::{Setup, State};
use trunnion_cycles::Run;
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Machine};
use trunnion_sync::blocks::{Limits, Reducer, Reduction};

/// A function of the state that gives the reading, mm.
pub type Nominal = Box<dyn Fn(&State) -> [f64; 3]>;

/// A reducer that knows what a machine without errors would read.
pub fn reducer(machine: &Machine, setups: &[Setup], limits: Limits) -> Reducer<Nominal> {
    let (machine, setups, none) = (machine.clone(), setups.to_vec(), Errors::default());
    Reducer::new(
        limits,
        Box::new(move |state: &State| {
            let nominal = |setup: &Setup| predict(&machine, setup, state, &none);
            setups.get(state.setup).map_or_else(Vector3::zeros, nominal).into()
        }),
    )
}

/// A run with its points reduced to blocks, and what the reduction counted.
pub fn blocks_of(run: &Run, limits: Limits) -> (Run, Reduction) {
    let mut reducer = reducer(&run.machine, &run.setups, limits);
    (0..).zip(&run.points).for_each(|(index, point)| reducer.push(index, point.clone()));
    let mut reduction = reducer.finish();
    let points = std::mem::take(&mut reduction.points);
    let (name, machine, kind) = (run.name.clone(), run.machine.clone(), run.kind);
    (
        Run { name, machine, kind, setups: run.setups.clone(), channels: run.channels.clone(), points },
        reduction,
    )
}
