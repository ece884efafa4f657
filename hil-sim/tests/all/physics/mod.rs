//! The virtual machine against equations and data we did not write, and its hidden physics against their registry.

mod chain;
mod hidden;
mod mounting;
mod noise;
mod outside_points;
mod truth_file;

use nalgebra::Point3;
use trunnion_hil_sim::{Instrument, NestOn, SimSetup};
use trunnion_machine::{Machine, shipped};

/// Run time of the S1 grid on a real machine, s.
const RUN_S: f64 = 1682.0;

fn table_bc() -> Machine {
    shipped::machine("table-bc").unwrap()
}

fn setup(name: &str, nest: NestOn, ball: [f64; 3]) -> SimSetup {
    SimSetup::new(name, nest, Point3::from(ball), Instrument::R_TEST)
}

fn low_and_high() -> Vec<SimSetup> {
    vec![setup("low", NestOn::Table, [150.0, 0.0, 60.0]), setup("high", NestOn::Table, [150.0, 0.0, 160.0])]
}
