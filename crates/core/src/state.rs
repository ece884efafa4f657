//! What a machine is doing at one instant: all an effect may depend on.

use crate::AxisValues;
use nalgebra::Vector3;

/// The state an effect is a function of. Commanded positions, not actual ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Commanded axis positions, mm and rad.
    pub position: AxisValues<f64>,
    /// Direction from which each axis came to rest or is moving: −1, 0 (unknown), +1.
    pub direction: AxisValues<f64>,
    /// Axis velocities, mm/s and rad/s; zero at rest.
    pub velocity: AxisValues<f64>,
    /// Axis accelerations, mm/s² and rad/s²; zero at rest.
    pub acceleration: AxisValues<f64>,
    /// Travel since the axis last reversed, mm and rad.
    pub since_reversal: AxisValues<f64>,
    /// Seconds since the run began; `None` when the measurement has no time.
    pub time_s: Option<f64>,
    /// Temperature channels in the order the run names them, °C.
    pub temperature_degc: Vec<f64>,
    /// Index of the setup in the experiment.
    pub setup: usize,
    /// Index of the target of the setup's artefact; 0 without one.
    pub target: usize,
    /// Deflection of ball against nest that the probes were asked to read, nest axes, mm; an experiment fills it with
    /// what the base model predicts.
    pub deflection_mm: Vector3<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run on the fly holds a state for each sample (docs/decisions/0011-joints-by-name.md).
    #[test]
    fn a_state_stays_small() {
        assert_eq!(size_of::<State>(), 600);
    }
}
