//! Transforms: nothing wrong reads nothing, the published linear equations, and the machine crate's chain.

use super::{low_and_high, setup, table_bc};
use nalgebra::{Point3, Rotation3, Vector3};
use trunnion_core::{AxisValues, Joint, State, Twist};
use trunnion_hil_sim::physics::{grid, simulate_points};
use trunnion_hil_sim::{Instrument, NestOn, SimSetup, Truth, VirtualMachine};
use trunnion_machine::{JointErrors, Machine, shipped};

fn largest(points: &[[f64; 3]]) -> f64 {
    points.iter().flatten().fold(0.0, |largest: f64, value| largest.max(value.abs()))
}

#[test]
fn a_perfect_machine_reads_zero_everywhere() {
    for (name, _) in shipped::FILES {
        let machine = shipped::machine(name).unwrap();
        if machine.rotary().len() < 2 {
            continue;
        }
        let setups = [
            setup("table nest", NestOn::Table, [150.0, 0.0, 60.0]),
            setup("spindle nest", NestOn::Spindle, [-40.0, 90.0, 160.0]),
        ];
        let states = match machine.tripod {
            None => grid::standard_bc(&machine, &setups),
            // The legs follow the ball through part of the grid only.
            Some(_) => {
                let stations = |reach_deg: f64, step_deg: f64, count: u32| grid::Stations {
                    first_deg: -reach_deg,
                    step_deg,
                    count,
                    ends_deg: [-reach_deg, reach_deg],
                };
                grid::stations_bc(&machine, &setups, stations(30.0, 10.0, 7), stations(22.0, 4.0, 12))
            }
        };
        assert_eq!(states.len(), 336, "{name}");
        // The legs of both sides are solved by iteration, to 1e-10 mm.
        let allowed_mm = if machine.tripod.is_some() { 1e-9 } else { 1e-11 };
        let virtual_machine =
            VirtualMachine::new(machine, Truth::perfect(name, &setups, super::RUN_S)).unwrap();
        let worst_mm = largest(&simulate_points(&virtual_machine, &states));
        assert!(worst_mm < allowed_mm, "{name}: {worst_mm}");
    }
}

#[test]
fn a_perfect_bar_of_any_direction_reads_zero() {
    let machine = table_bc();
    let ball = Point3::new(20.0, -30.0, 80.0);
    let bar = SimSetup {
        instrument: Instrument::ball_bar(100.0),
        ..setup("bar", NestOn::Table, [20.0, -30.0, 80.0])
    };
    let virtual_machine =
        VirtualMachine::new(machine.clone(), Truth::perfect("table-bc", &[bar], 1.0)).unwrap();
    for angle in [0.0, 0.7, 2.0, 4.0_f64] {
        let mut position = AxisValues::default();
        position[Joint::C] = angle;
        let mut position = machine.follow(&position, &ball).unwrap();
        position[Joint::X] += 100.0 * angle.cos();
        position[Joint::Z] += 100.0 * angle.sin();
        let state = State { position, ..State::default() };
        assert!(virtual_machine.ideal_reading_mm(0, &state)[0].abs() < 1e-12);
    }
}

/// S1 eq. 8–9 with the signs mended (docs/design/physics.md §4, §8): the reading is minus the printed deviations, at the ball.
#[test]
fn small_errors_read_as_equations_8_and_9_of_s1() {
    let mut truth = Truth::perfect("table-bc", &low_and_high(), 1.0);
    let b = [3e-6, -5e-6, 4e-6, 1e-8, -2e-8, 3e-8];
    let c = [-2e-6, 6e-6, 1e-6, 4e-8, 1e-8, -3e-8];
    truth.location[Joint::B] = twist(b);
    truth.location[Joint::C] = twist(c);
    let machine = table_bc();
    let states = grid::standard_bc(&machine, &low_and_high());
    let virtual_machine = VirtualMachine::new(machine, truth).unwrap();
    for state in states {
        let (sb, cb) = state.position[Joint::B].sin_cos();
        let (sc, cc) = state.position[Joint::C].sin_cos();
        // (δx, δy, δz) or (α, β, γ) of B and C turned into table axes, as printed.
        let printed = |b: &[f64], c: &[f64]| {
            let radial = b[0] * cb - b[2] * sb + c[0];
            Vector3::new(
                (b[1] + c[1]) * sc + radial * cc,
                (b[1] + c[1]) * cc - radial * sc,
                b[0] * sb + b[2] * cb + c[2],
            )
        };
        let ball = low_and_high()[state.setup].ball_in_table_mm.coords;
        let expected = -(printed(&b[..3], &c[..3]) + printed(&b[3..], &c[3..]).cross(&ball));
        let read = Vector3::from(virtual_machine.ideal_reading_mm(state.setup, &state));
        assert!((read - expected).norm() < 1e-10, "{read} {expected}");
    }
}

#[test]
fn our_chain_and_the_machine_crate_agree_on_large_errors() {
    let mut machine = shipped::machine("table-ac").unwrap();
    machine.table[0].through_mm = Point3::new(3.0, -20.0, 7.0);
    machine.table[0].sense = -1.0;
    let mut errors = JointErrors::default();
    for (i, letter) in Joint::ALL.into_iter().enumerate() {
        let k = i as f64 + 1.0;
        errors[letter] = twist([0.1 * k, -0.2, 0.05 * k, 0.01 * k, -0.02, 0.015]);
    }
    for nest in [NestOn::Table, NestOn::Spindle] {
        check_against_machine(&machine, &errors, nest);
    }
}

fn check_against_machine(machine: &Machine, errors: &JointErrors, nest: NestOn) {
    let setups = [setup("one", nest, [100.0, 20.0, 60.0])];
    let mut truth = Truth::perfect(&machine.name, &setups, 1.0);
    truth.location = *errors;
    truth.setups[0].setting_mm = Vector3::new(0.01, 0.02, -0.03);
    let virtual_machine = VirtualMachine::new(machine.clone(), truth).unwrap();
    for state in grid::standard_bc(machine, &setups) {
        let machine_from_table = machine.machine_from_table(&state.position, errors);
        let tool = machine.machine_from_tool(&state.position, errors) * Point3::origin();
        let (ball, setting) = (setups[0].ball_in_table_mm, Vector3::new(0.01, 0.02, -0.03));
        let expected = match nest {
            NestOn::Table => machine_from_table.inverse() * tool - ball + setting,
            NestOn::Spindle => machine_from_table * (ball + setting) - tool,
        };
        let read = Vector3::from(virtual_machine.ideal_reading_mm(0, &state));
        assert!((read - expected).norm() < 1e-9);
    }
}

/// A tilt of B by −0.01…−0.03° moves the ball as a plain rotation does (S0's check, by hand).
#[test]
fn a_tilted_b_moves_a_table_ball_by_the_lever() {
    for tilt_deg in [-0.01, -0.02, -0.03_f64] {
        let setups = [setup("low", NestOn::Spindle, [0.0, 0.0, 66.7])];
        let mut truth = Truth::perfect("table-bc", &setups, 1.0);
        truth.location[Joint::B] = twist([0.0, 0.0, 0.0, 0.0, tilt_deg.to_radians(), 0.0]);
        let machine = table_bc();
        let position = machine.follow(&AxisValues::default(), &setups[0].ball_in_table_mm).unwrap();
        let virtual_machine = VirtualMachine::new(machine, truth).unwrap();
        let read = virtual_machine.ideal_reading_mm(0, &State { position, ..State::default() });
        let ball = Vector3::new(0.0, 0.0, 66.7);
        let turned = Rotation3::from_axis_angle(&Vector3::y_axis(), tilt_deg.to_radians()) * ball;
        assert!((Vector3::from(read) - (turned - ball)).norm() < 1e-12);
    }
}

fn twist(e: [f64; 6]) -> Twist {
    Twist { translation_mm: Vector3::new(e[0], e[1], e[2]), rotation_rad: Vector3::new(e[3], e[4], e[5]) }
}
