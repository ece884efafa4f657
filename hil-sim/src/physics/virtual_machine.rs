//! A machine with a truth.

use super::natural::NaturalMotion;
use crate::compensation::Compensation;
use crate::truth::Truth;
use trunnion_core::State;
use trunnion_machine::Machine;

/// A machine with a truth.
#[derive(Clone, Debug)]
pub struct VirtualMachine {
    pub(super) machine: Machine,
    pub(super) truth: Truth,
    pub(super) natural: Vec<NaturalMotion>,
    pub(super) compensation: Option<Compensation>,
}

/// The truth belongs to another machine.
#[derive(Debug, thiserror::Error)]
#[error("the truth is of machine {truth}, not of {machine}; load the machine file it names")]
pub struct OtherMachine {
    pub(super) truth: String,
    pub(super) machine: String,
}

/// Noise-free readings of a list of states, each with the setup it names.
pub fn simulate_points(machine: &VirtualMachine, states: &[State]) -> Vec<[f64; 3]> {
    states.iter().map(|state| machine.ideal_reading_mm(state.setup, state)).collect()
}
