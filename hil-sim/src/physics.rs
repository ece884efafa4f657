//! The virtual machine: poses with errors, and what an instrument between tool and table reads.
//!
//! All exact, the poses from `chain`, the readings from `crate::instruments`.

pub(crate) mod chain;
pub mod disturbance;
pub mod grid;
pub mod hidden;
mod legs;
pub(crate) mod rotation;
mod virtual_machine;

pub use virtual_machine::{OtherMachine, VirtualMachine, simulate_points};
pub(crate) mod natural;
mod sampler;

pub use disturbance::Disturbance;
pub use sampler::Sampler;

use crate::compensation::{CannotCorrect, Compensation};
use crate::instruments::{Poses, read_mm};
use crate::truth::Truth;
use hidden::Scene;
use trunnion_core::{AxisValues, State};
use trunnion_machine::{Machine, Side};

impl VirtualMachine {
    /// Builds the machine the truth describes. Whether the hidden physics fit the machine was checked when the truth was made.
    ///
    /// # Errors
    /// When the truth names another machine.
    pub fn new(machine: Machine, truth: Truth) -> Result<Self, OtherMachine> {
        if machine.name != Machine::name_of(&truth.machine) {
            return Err(OtherMachine::Name { truth: truth.machine, machine: machine.name });
        }
        let mut location = truth.location;
        for error in &truth.named {
            let Some((joint, twist)) = error.on(&machine) else {
                let (joint, joints) = (error.joint.clone(), machine.joints_near(&error.joint));
                return Err(OtherMachine::Joint { joint, machine: machine.name, joints });
            };
            location[joint] += twist;
        }
        let natural = natural::draw(&machine, truth.noise.natural_motion_mm, truth.seed);
        Ok(Self { machine, truth, location, natural, compensation: None })
    }

    /// The same machine with its controller compensating.
    ///
    /// # Errors
    /// When its axes cannot correct the tool point.
    pub fn compensated(self, compensation: Compensation) -> Result<Self, CannotCorrect> {
        compensation.fits(&self.machine)?;
        Ok(Self { compensation: Some(compensation), ..self })
    }

    /// The nominal machine.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// What is wrong with it.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// What the axes' own encoders read at a state: commanded positions with the following errors that are hidden in the machine.
    pub fn encoder_positions(&self, state: &State) -> AxisValues<f64> {
        let mut actual = state.position;
        for hidden in self.truth.hidden.iter().filter(|hidden| hidden.kind.at_encoder) {
            let scene = Scene { machine: &self.machine, place: hidden.place, setup: state.setup, state };
            let wrong = hidden.at(&scene);
            for axis in self.machine.axes() {
                let twist = wrong.joints[axis.letter];
                let along = axis.direction.into_inner() * axis.sense;
                let moved = if axis.is_rotary() { twist.rotation_rad } else { twist.translation_mm };
                actual[axis.letter] += moved.dot(&along);
            }
        }
        actual
    }

    /// What the instrument of a setup would read without noise, mm: x y z, or the bar's change of length and two zeros.
    ///
    /// # Panics
    /// When `setup` is not the index of a setup of the truth.
    pub fn ideal_reading_mm(&self, setup: usize, state: &State) -> [f64; 3] {
        self.disturbed_reading_mm(setup, state, Disturbance::default())
    }

    /// The reading with something on top of all the truth says.
    fn disturbed_reading_mm(&self, setup: usize, state: &State, extra: Disturbance) -> [f64; 3] {
        let wrong = self.disturbance(setup, state) + extra;
        let compensation = self.compensation.as_ref();
        let tool_mm = &self.truth.setups[setup].setup.ball_in_tool_mm;
        let corrected =
            compensation.and_then(|table| table.corrected(&self.machine, &state.position, tool_mm));
        let position = corrected.unwrap_or(state.position);
        let pose = |side| chain::machine_from_tip(&self.machine, side, &position, &wrong.joints);
        let poses = Poses {
            machine_from_table: pose(Side::Table),
            machine_from_tool: pose(Side::Tool),
            table_in_machine_mm: wrong.table_in_machine_mm,
            tool_in_machine_mm: wrong.tool_in_machine_mm,
            setting_in_table_mm: wrong.setting_in_table_mm,
        };
        read_mm(&self.truth.setups[setup], state.target, &poses)
    }

    fn disturbance(&self, setup: usize, state: &State) -> Disturbance {
        let mut wrong = Disturbance::from_joints(self.location);
        for motion in &self.natural {
            wrong = wrong + motion.at(state);
        }
        for hidden in &self.truth.hidden {
            wrong = wrong + hidden.at(&Scene { machine: &self.machine, place: hidden.place, setup, state });
        }
        wrong
    }
}
