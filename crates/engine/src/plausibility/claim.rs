//! Where the balls of a setup are by positions and nominal kinematics, as a run says or as it would say with a mistake undone.

use nalgebra::Vector3;
use trunnion_core::setup::SET_BY_HAND_MM;
use trunnion_core::{AxisValues, Setup, statistics};
use trunnion_machine::{JointErrors, Machine};

/// With a mistake undone, the balls may stay this far off: settings by hand and rounded positions, mm.
pub(super) const TOGETHER_MM: f64 = SET_BY_HAND_MM;

/// What a run says of itself, or would say with a mistake undone.
#[derive(Clone)]
pub(super) struct Claim<'a> {
    pub machine: &'a Machine,
    pub setups: Vec<Setup>,
    pub positions: Vec<(usize, AxisValues<f64>)>,
}

impl Claim<'_> {
    /// How far off the balls are at every position, mm.
    pub fn off_mm(&self) -> Vec<Vector3<f64>> {
        let off = |(setup, at): &(usize, AxisValues<f64>)| off_mm(self.machine, &self.setups[*setup], at);
        self.positions.iter().map(off).collect()
    }

    pub fn rms_mm(&self) -> f64 {
        rms(self.off_mm().into_iter())
    }

    /// The same with other positions.
    pub fn turned(&self, change: impl Fn(&AxisValues<f64>) -> AxisValues<f64>) -> Self {
        let positions = self.positions.iter().map(|(setup, position)| (*setup, change(position)));
        Self { positions: positions.collect(), ..self.clone() }
    }
}

/// How far off the balls are by nominal kinematics, mm: from the nest to the ball in machine axes; of a ball bar, how much farther apart
/// its balls are than it is long.
pub(super) fn off_mm(machine: &Machine, setup: &Setup, position: &AxisValues<f64>) -> Vector3<f64> {
    let none = JointErrors::default();
    let apart = machine.machine_from_tool(position, &none) * setup.ball_in_tool_mm
        - machine.machine_from_table(position, &none) * setup.ball_in_table_mm;
    match setup.bar_length_mm.filter(|_| setup.instrument.keeps_bar_length()) {
        Some(length_mm) => Vector3::x() * (apart.norm() - length_mm),
        None => apart,
    }
}

pub(super) fn rms(distances: impl Iterator<Item = Vector3<f64>>) -> f64 {
    statistics::rms(distances.map(|d| d.norm())).unwrap_or(0.0)
}
