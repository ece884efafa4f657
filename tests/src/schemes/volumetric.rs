//! The volumetric errors that multilateration gives at each target, against those of the virtual machine. The end-to-end test of the schemes takes
//! this file in by its path.

use super::judged::Found;
use nalgebra::{Matrix3x6, Matrix6, Vector3, Vector6};
use serde_json::Value;
use trunnion_cycles::{Cycle, Pace};
use trunnion_hil_sim::truth::{Noise, PlacedSetup};
use trunnion_hil_sim::{Instrument, NestOn, SimSetup, Truth, VirtualMachine};
use trunnion_machine::shipped;

/// Every ΔX, ΔY, ΔZ of the findings next to what it should be.
///
/// # Panics
/// When these are no findings of multilateration in JSON by this cycle, or the truth is of another machine.
pub fn found(findings: &Value, cycle: &Cycle, truth: &Truth) -> Vec<Found> {
    let tables = findings["tables"].as_array().unwrap();
    let mut all = Vec::new();
    let mut first_of_group: Vec<usize> = Vec::new();
    for (k, setup) in cycle.setups.iter().enumerate() {
        if !first_of_group.iter().any(|&first| cycle.setups[first].ball_in_tool_mm == setup.ball_in_tool_mm) {
            first_of_group.push(k);
        }
    }
    for (table, setup) in tables.iter().zip(first_of_group) {
        let expected_mm = displacements_mm(cycle, truth, setup);
        let rows = table["rows"].as_array().unwrap();
        assert_eq!(rows.len(), expected_mm.len());
        for (row, (place, expected)) in rows.iter().zip(expected_mm) {
            let number = |k: usize| row[k].as_f64().unwrap();
            assert!((0..3).all(|k| (number(k) - place[k]).abs() < 1e-3), "{row} {place}");
            all.extend((0..3).map(|k| Found {
                name: ["ΔX", "ΔY", "ΔZ"][k].into(),
                unit: "um".into(),
                value: number(3 + 2 * k),
                u: number(4 + 2 * k),
                expected: expected[k] * 1e3,
            }));
        }
    }
    all
}

/// Commanded place of the reflector of a setup and its displacement against the table, table axes, mm, at each target; place and turn of all together
/// taken off. An R-test at the place of the reflector, mounted without fault, reads the displacement.
fn displacements_mm(cycle: &Cycle, truth: &Truth, setup: usize) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let machine = shipped::machine(&cycle.machine).unwrap();
    let visits = cycle.visits(&machine, &Pace::default()).unwrap();
    let mut displaced = Vec::new();
    for mut state in visits.states.into_iter().filter(|state| state.setup == setup) {
        let none = Default::default();
        let in_tool_mm = cycle.setups[setup].ball_in_tool_mm;
        let in_machine = machine.machine_from_tool(&state.position, &none) * in_tool_mm;
        let place = machine.machine_from_table(&state.position, &none).inverse() * in_machine;
        let r_test = SimSetup {
            ball_in_tool_mm: in_tool_mm,
            ..SimSetup::new("here", NestOn::Table, place, Instrument::R_TEST)
        };
        let setups = vec![PlacedSetup::new(&r_test, Vector3::zeros())];
        let here = Truth { setups, noise: Noise::NONE, ..truth.clone() };
        let here = VirtualMachine::new(machine.clone(), here).unwrap();
        state.setup = 0;
        displaced.push((place.coords, Vector3::from(here.ideal_reading_mm(0, &state))));
    }
    let middle = displaced.iter().map(|(place, _)| place).sum::<Vector3<f64>>() / displaced.len() as f64;
    let motions = |place: &Vector3<f64>| {
        let mut motions = Matrix3x6::identity();
        motions.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(place - middle).cross_matrix());
        motions
    };
    let scatter: Matrix6<f64> = displaced.iter().map(|(p, _)| motions(p).transpose() * motions(p)).sum();
    let moment: Vector6<f64> = displaced.iter().map(|(p, d)| motions(p).transpose() * d).sum();
    let rigid = scatter.try_inverse().unwrap() * moment;
    displaced.into_iter().map(|(place, d)| (place, d - motions(&place) * rigid)).collect()
}
