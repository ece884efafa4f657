use super::*;
use nalgebra::Point3;
use trunnion_core::{InstrumentKind, NestSide, Point, Quality, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::shipped;

/// The S1 grid: two heights, both directions of C, B every 30°, C every 30°; readings zero.
fn grid() -> Experiment {
    let setup = |name: &str, z: f64| {
        Setup::new(name, InstrumentKind::RTest, NestSide::Table, Point3::new(150.0, 0.0, z))
    };
    let mut points = Vec::new();
    for index in 0..2 * 2 * 7 * 12_usize {
        let (setup, way, b, c) = (index / 168, index / 84 % 2, index / 12 % 7, index % 12);
        let mut state = State { setup, time_s: Some(4.0 * index as f64), ..State::default() };
        let c = if way == 0 { c } else { 11 - c };
        state.position[Joint::B] = (-90.0 + 30.0 * b as f64).to_radians();
        state.position[Joint::C] = (30.0 * c as f64).to_radians();
        state.direction[Joint::B] = 1.0;
        state.direction[Joint::C] = if way == 0 { 1.0 } else { -1.0 };
        points.push(Point {
            state,
            reading_mm: [0.0; 3],
            spread_mm: [0.0; 3],
            samples: 0,
            quality: Quality::Good,
        });
    }
    let run = Run {
        name: "grid".into(),
        machine: shipped::machine("table-bc").unwrap(),
        kind: RunKind::Static,
        setups: vec![setup("low", 60.0), setup("high", 160.0)],
        channels: Vec::new(),
        points,
    };
    Experiment::new(&[run]).unwrap()
}

/// Residual whose part in machine axes is `in_machine_um(state)` plus uniform noise of ±1 µm, the same at every point of a
/// pass station to the share `clinging`.
fn residual(
    experiment: &Experiment,
    mut seed: u64,
    clinging: f64,
    in_machine_um: impl Fn(&State) -> [f64; 3],
) -> DVector<f64> {
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    };
    let mut residual = DVector::zeros(experiment.rows());
    let mut station = [0.0; 3];
    for (i, point) in experiment.points.iter().enumerate() {
        if i % 12 == 0 {
            station = [random(), random(), random()];
        }
        let wanted = in_machine_um(&point.state);
        let um = nalgebra::Vector3::from_fn(|k, _| {
            wanted[k] + random() * (1.0 - clinging) + station[k] * clinging
        });
        // Rows that read as this vector in machine axes: in_frames is linear and orthogonal.
        for k in 0..3 {
            let mut unit = DVector::zeros(experiment.rows());
            unit[experiment.rows_of(i).start + k] = 1.0;
            let (axis, _) = crate::compare::frames::in_frames(experiment, &unit, i).unwrap();
            residual[experiment.rows_of(i).start + k] = axis.dot(&um) * 1e-3;
        }
    }
    residual
}

fn found_in(seed: u64, clinging: f64, in_machine_um: impl Fn(&State) -> [f64; 3]) -> Vec<Place> {
    let experiment = grid();
    let used = vec![true; experiment.points.len()];
    places(&experiment, &residual(&experiment, seed, clinging, in_machine_um), &used)
}

#[test]
fn a_stop_below_minus_60_degrees_is_reported_as_one_tail_region() {
    let found = found_in(7, 0.3, |state| [0.0, 0.0, if state.position[Joint::B] < -1.0 { 4.0 } else { 0.0 }]);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].location(), "Z, B −60° and below, both directions, both setups");
    assert!((found[0].mean_um - 4.0).abs() < 0.3 && found[0].readings == 96, "{found:?}");
    assert!(found[0].to_string().ends_with(" µm (96 readings)") && found[0].share > 0.8, "{found:?}");
}

#[test]
fn what_clings_to_a_station_in_every_pass_is_no_accident() {
    let found = found_in(3, 0.9, |state| [0.0, if state.position[Joint::B] > 1.0 { 2.5 } else { 0.0 }, 0.0]);
    assert_eq!(found[0].location(), "Y, B 60° and above, both directions, both setups");
}

#[test]
fn two_places_of_one_component_do_not_overlap_and_a_lag_is_reported_by_its_directions() {
    let found = found_in(7, 0.3, |state| {
        let hinge = if state.position[Joint::B] > 1.0 { -3.0 } else { 0.0 };
        [2.0 * state.direction[Joint::C], hinge, 0.0]
    });
    let words: Vec<String> = found.iter().map(Place::location).collect();
    assert_eq!(words, ["X, both setups", "Y, B 60° and above, both directions, both setups"]);
    assert!(found[0].size().starts_with("+2.") || found[0].size().starts_with("+1.9"), "{}", found[0].size());
    assert!(found[0].size().contains("with C forward, −"), "{}", found[0].size());
}

#[test]
fn a_bump_over_the_zero_of_a_full_turn_is_one_range() {
    let found = found_in(7, 0.3, |state| {
        let c = state.position[Joint::C].to_degrees().round();
        [0.0, if (40.0..=320.0).contains(&c) { 0.0 } else { 4.0 }, 0.0]
    });
    assert_eq!(found[0].location(), "Y, C 330° to 30°, both directions, both setups");
}

#[test]
fn no_place_stands_out_of_noise_even_when_stations_cling_together() {
    for seed in 1..=8 {
        for clinging in [0.0, 0.5, 0.9] {
            assert_eq!(found_in(seed, clinging, |_| [0.0; 3]), [], "seed {seed}, clinging {clinging}");
        }
    }
}
