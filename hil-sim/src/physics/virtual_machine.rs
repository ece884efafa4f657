//! A machine with a truth.

use super::natural::NaturalMotion;
use crate::compensation::Compensation;
use crate::truth::Truth;
use trunnion_core::State;
use trunnion_machine::{JointErrors, Machine};

/// A machine with a truth.
#[derive(Clone, Debug)]
pub struct VirtualMachine {
    pub(super) machine: Machine,
    pub(super) truth: Truth,
    /// Location errors of all joints.
    pub(super) location: JointErrors,
    pub(super) natural: Vec<NaturalMotion>,
    pub(super) compensation: Option<Compensation>,
}

/// The truth belongs to another machine.
#[derive(Debug, thiserror::Error)]
pub enum OtherMachine {
    /// By its name.
    #[error("the truth is of machine {truth}, not of {machine}; load the machine file it names")]
    Name {
        /// What the truth names.
        truth: String,
        /// What was loaded.
        machine: String,
    },
    /// It has errors of a joint that this machine does not have.
    #[error(
        "the truth has an error of joint {joint}, which machine {machine} does not have; its joints: {joints}"
    )]
    Joint {
        /// What the truth names.
        joint: String,
        /// What was loaded.
        machine: String,
        /// Its joints.
        joints: String,
    },
}

/// Noise-free readings of a list of states, each with the setup it names.
pub fn simulate_points(machine: &VirtualMachine, states: &[State]) -> Vec<[f64; 3]> {
    states.iter().map(|state| machine.ideal_reading_mm(state.setup, state)).collect()
}
