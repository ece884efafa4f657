//! A machine that runs one program after the other.

use trunnion_core::AxisValues;
use trunnion_hil_sim::devices::{CycleState, SimulatedCell, World};

/// One world after the other, each with the program it names.
pub struct InTurn {
    /// The worlds.
    pub worlds: Vec<SimulatedCell>,
    /// Standing between two programs, s.
    pub pause_s: f64,
}

impl InTurn {
    /// The world at a time, and its own time.
    fn at(&self, t_s: f64) -> (&SimulatedCell, f64) {
        let mut own_s = t_s;
        for world in &self.worlds[..self.worlds.len() - 1] {
            let lasts_s = world.trajectory.duration_s() + self.pause_s;
            if own_s < lasts_s {
                return (world, own_s);
            }
            own_s -= lasts_s;
        }
        (&self.worlds[self.worlds.len() - 1], own_s)
    }
}

impl World for InTurn {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        let (world, own_s) = self.at(t_s);
        world.axes(own_s)
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        let (world, own_s) = self.at(t_s);
        world.probe_readings_mm(own_s)
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        let (world, own_s) = self.at(t_s);
        world.bar_reading_mm(own_s)
    }

    fn temperature_degc(&self, t_s: f64) -> f64 {
        let (world, own_s) = self.at(t_s);
        world.temperature_degc(own_s)
    }

    fn cycle(&self, t_s: f64) -> CycleState {
        let (world, own_s) = self.at(t_s);
        world.cycle(own_s)
    }
}
