//! Motions of effects: bounded, zero at the start, and the derivative of the exact kinematics.

use crate::scenes::{each_motion, machines, rich_states, scene};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeSet;
use trunnion_core::{State, Twist};
use trunnion_effects::{Instance, Unit, r_test_reading};
use trunnion_machine::{Errors, JointErrors, Machine, Site, shipped};

/// Shape numbers that count something.
const COUNTS: [&str; 4] = ["lobes", "triad", "load", "cycles_per_turn"];

#[test]
fn every_number_of_an_effect_has_a_unit_or_counts() {
    for machine in machines() {
        let scene = scene(&machine, &rich_states(&machine));
        for instance in Instance::all(&machine) {
            for parameter in instance.parameters(&scene) {
                assert_ne!(parameter.unit, Unit::ONE, "{} of {}", parameter.name, instance.id());
            }
            for name in instance.shapes(&scene).names {
                let counts = COUNTS.contains(&name.as_str());
                assert_eq!(Unit::in_name(&name) == Unit::ONE, counts, "{name} of {}", instance.id());
            }
        }
    }
}

#[test]
fn motions_are_finite_within_bounds_and_every_parameter_moves_something() {
    for machine in machines() {
        let states = rich_states(&machine);
        let scene = scene(&machine, &states);
        for instance in Instance::all(&machine) {
            let id = instance.id();
            let parameters = instance.parameters(&scene);
            assert!(!parameters.is_empty(), "{} {id}: nothing to fit in a rich scene", machine.name);
            let shapes = instance.shapes(&scene);
            assert!(!shapes.grid.is_empty(), "{id}");
            assert!(shapes.grid.iter().all(|point| point.len() == shapes.names.len()), "{id}");
            let mut moved = BTreeSet::new();
            each_motion(&instance, &scene, &states, |shape, i, site, twist| {
                let all = [twist.translation_mm, twist.rotation_rad];
                assert!(all.iter().all(|v| v.iter().all(|x| x.is_finite())), "{id} {shape:?}");
                assert!(i < parameters.len(), "{id}: parameter {i} of {}", parameters.len());
                match site {
                    Site::Joint(letter) => assert!(machine.axis(letter).is_some(), "{id}"),
                    _ => assert_eq!(twist.rotation_rad, Vector3::zeros(), "{id} turns a point"),
                }
                if all.iter().any(|v| v.norm() > 1e-12) {
                    moved.insert(i);
                }
            });
            assert_eq!(moved.len(), parameters.len(), "{} {id} moves only {moved:?}", machine.name);
        }
    }
}

#[test]
fn effects_that_start_at_zero_are_zero_at_the_start() {
    for machine in machines() {
        let mut states = rich_states(&machine);
        states[0] = State { time_s: Some(0.0), temperature_degc: vec![20.0], ..State::default() };
        let scene = scene(&machine, &states);
        for instance in Instance::all(&machine) {
            let id = instance.id();
            let starts_at_zero = [
                "gravity-sag",
                "thermal",
                "spindle-growth",
                "setup-slip",
                "linear-scale",
                "squareness",
                "stacked-tilt",
                "backlash",
                "servo-lag",
                "sync-delay",
                "inertial-deflection",
                "probe",
                "nest",
            ];
            if starts_at_zero.iter().any(|name| id.starts_with(name)) {
                each_motion(&instance, &scene, &states[..1], |shape, i, _, twist| {
                    let size = twist.translation_mm.norm() + twist.rotation_rad.norm();
                    assert!(size < 1e-12, "{id} {shape:?} parameter {i}: {size}");
                });
            }
        }
    }
}

/// What the exact kinematics read: spindle-side against table-side ball in table axes, mm.
fn exact_reading(
    machine: &Machine,
    state: &State,
    [table_ball, spindle_ball]: [Point3<f64>; 2],
    errors: &Errors,
) -> Vector3<f64> {
    let machine_from_table = machine.machine_from_table(&state.position, &errors.joints);
    let machine_from_tool = machine.machine_from_tool(&state.position, &errors.joints);
    let spindle_ball_in_machine = machine_from_tool * (spindle_ball + errors.spindle_ball_mm);
    let apart = machine_from_table.inverse() * spindle_ball_in_machine - table_ball;
    apart - errors.table_ball.translation_mm + errors.reading_mm
}

#[test]
fn columns_match_differences_of_the_exact_kinematics() {
    /// Size of the twists that are put in, mm and rad. Central differences are exact to its square, rounding to 1e-8.
    const STEP: f64 = 1e-5;
    for machine in machines() {
        let states = rich_states(&machine);
        let scene = scene(&machine, &states);
        let table_ball = scene.setups[0].ball_in_table_mm;
        for (instance, state) in Instance::all(&machine)
            .iter()
            .flat_map(|instance| states.iter().step_by(7).map(move |s| (instance, s)))
        {
            // The balls are together, as the nest holds them.
            let none = JointErrors::default();
            let machine_from_table = machine.machine_from_table(&state.position, &none);
            let machine_from_tool = machine.machine_from_tool(&state.position, &none);
            let spindle_ball = machine_from_tool.inverse() * (machine_from_table * table_ball);
            for shape in instance.shapes(&scene).grid.iter().step_by(3) {
                let parameters = instance.parameters(&scene).len();
                let (mut columns, mut twists) =
                    (vec![Vector3::zeros(); parameters], vec![Vec::new(); parameters]);
                r_test_reading(instance, &scene, shape, state, spindle_ball, &mut |i, read| {
                    columns[i] += read
                });
                instance.motions(&scene, shape, state, &mut |i, site, twist| twists[i].push((site, twist)));
                for (column, twists) in columns.iter().zip(&twists) {
                    let size = |twist: &Twist| twist.translation_mm.norm() + twist.rotation_rad.norm();
                    let largest = twists.iter().map(|(_, twist)| size(twist)).fold(0.0, f64::max);
                    if largest == 0.0 {
                        continue;
                    }
                    let read = |way: f64| {
                        let mut errors = Errors::default();
                        twists
                            .iter()
                            .for_each(|(site, twist)| errors.add(*site, *twist * (way * STEP / largest)));
                        exact_reading(&machine, state, [table_ball, spindle_ball], &errors)
                    };
                    let difference = (read(1.0) - read(-1.0)) * (largest / (2.0 * STEP));
                    let off = (column - difference).norm();
                    let size = largest * (1.0 + table_ball.coords.norm() + spindle_ball.coords.norm());
                    assert!(
                        off < 1e-7 * size,
                        "{} {} {shape:?}: {column} by columns, {difference} by differences",
                        machine.name,
                        instance.id()
                    );
                }
            }
        }
    }
}

/// Two passes of forty readings, a day apart: a slip within either is tried every few readings, and none while nobody reads.
#[test]
fn a_slip_is_looked_for_where_readings_are() {
    let machine = shipped::machine("table-bc").unwrap();
    let mut states = rich_states(&machine);
    states.iter_mut().enumerate().for_each(|(i, state)| {
        let pass = if i < 40 { 0.0 } else { 86_400.0 };
        state.time_s = Some(1000.0 + pass + 5.0 * i as f64);
    });
    let scene = scene(&machine, &states);
    let elapsed_s: Vec<f64> = states.iter().map(|state| scene.elapsed_s(state).unwrap()).collect();
    let grid = Instance::find("setup-slip", &machine).unwrap().shapes(&scene).grid;
    let before: Vec<usize> =
        grid.iter().map(|shape| elapsed_s.iter().filter(|time_s| **time_s < shape[0]).count()).collect();
    assert!(before.windows(2).all(|pair| pair[1] - pair[0] <= 3), "{before:?}");
    assert!(before[0] <= 3 && before[before.len() - 1] >= states.len() - 3, "{before:?}");
}
