//! Points made by an independent simulator (tests/data/PROVENANCE.md): with its location errors, our machine
//! reads the same to the noise.

use super::{low_and_high, table_bc};
use nalgebra::Vector3;
use trunnion_core::{Joint, State};
use trunnion_hil_sim::{Truth, VirtualMachine};

const POINTS: &str = include_str!("../../../../tests/data/points-nothing-hidden/points.csv");

/// From its truth.json, mm and rad.
const EX0B: f64 = 0.018267565599574234;
const EZ0B: f64 = -0.030783319101980337;
const EA0B: f64 = 4.790319876544235e-05;
const EB0B: f64 = 3.4818613830472414e-06;
const EC0B: f64 = 6.591250120905343e-05;
const EX0C: f64 = 0.00385629249998389;
const EY0C: f64 = 0.018272586275861754;
const EA0C: f64 = 1.5871879575883201e-06;

#[test]
fn an_independent_simulator_reads_the_same_to_its_noise() {
    let mut truth = Truth::perfect("table-bc", &low_and_high(), 1.0);
    let b = &mut truth.location[Joint::B];
    b.translation_mm = Vector3::new(EX0B, 0.0, EZ0B);
    b.rotation_rad = Vector3::new(EA0B, EB0B, EC0B);
    let c = &mut truth.location[Joint::C];
    c.translation_mm = Vector3::new(EX0C, EY0C, 0.0);
    c.rotation_rad = Vector3::new(EA0C, 0.0, 0.0);
    let machine = VirtualMachine::new(table_bc(), truth).unwrap();

    let points = points();
    assert_eq!(points.len(), 336);
    let apart: Vec<(usize, Vector3<f64>)> = points
        .iter()
        .map(|(state, read_mm)| {
            let ours = Vector3::from(machine.ideal_reading_mm(state.setup, state));
            (state.setup, read_mm - ours)
        })
        .collect();
    // The free setting of each setup, by least squares: the mean.
    let mut sum_of_squares = 0.0;
    for setup in 0..2 {
        let these: Vec<_> = apart.iter().filter(|(of, _)| *of == setup).map(|(_, apart)| apart).collect();
        let mean = these.iter().copied().sum::<Vector3<f64>>() / these.len() as f64;
        sum_of_squares += these.iter().map(|apart| (*apart - mean).norm_squared()).sum::<f64>();
    }
    let rms_um = 1e3 * (sum_of_squares / (3.0 * points.len() as f64)).sqrt();
    assert!(rms_um < 0.35, "{rms_um} µm");
}

fn points() -> Vec<(State, Vector3<f64>)> {
    let mut lines = POINTS.lines();
    let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let cell = |name: &str| cells[columns.iter().position(|column| *column == name).unwrap()];
            let number = |name: &str| cell(name).parse::<f64>().unwrap();
            let mut state = State { setup: usize::from(cell("setup") == "high"), ..State::default() };
            for (letter, name) in Joint::LINEAR.into_iter().zip(["x_mm", "y_mm", "z_mm"]) {
                state.position[letter] = number(name);
            }
            state.position[Joint::B] = number("b_deg").to_radians();
            state.position[Joint::C] = number("c_deg").to_radians();
            (state, Vector3::new(number("dx_um"), number("dy_um"), number("dz_um")) * 1e-3)
        })
        .collect()
}
