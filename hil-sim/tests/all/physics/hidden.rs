//! Walks the registry of hidden physics.

use super::{RUN_S, low_and_high, table_bc};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use trunnion_core::{Joint, State};
use trunnion_hil_sim::physics::hidden::{Hidden, HiddenChoice, KINDS, SeenIn, TYPICAL_RMS_MM};
use trunnion_hil_sim::physics::{grid, hidden, simulate_points};
use trunnion_hil_sim::{Truth, VirtualMachine};

fn choice(id: &str) -> HiddenChoice {
    HiddenChoice { id: id.into(), sigma: 1.0 }
}

/// Every id that fits table-bc and shows at a ball, drawn with one seed.
fn drawn(seed: u64) -> Vec<Hidden> {
    let machine = table_bc();
    hidden::ids()
        .iter()
        .filter(|id| {
            let (kind, place) = hidden::find(id).unwrap();
            hidden::fits(&machine, place) && kind.seen_in != SeenIn::Turns
        })
        .map(|id| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            Hidden::draw(&choice(id), &machine, &low_and_high(), RUN_S, &mut rng).unwrap()
        })
        .collect()
}

fn machine_with(hidden: &Hidden) -> VirtualMachine {
    let mut truth = Truth::perfect("table-bc", &low_and_high(), RUN_S);
    truth.hidden = vec![hidden.clone()];
    VirtualMachine::new(table_bc(), truth).unwrap()
}

fn rms_mm(points: &[[f64; 3]]) -> f64 {
    let squares: f64 = points.iter().flatten().map(|value| value * value).sum();
    (squares / (3.0 * points.len() as f64)).sqrt()
}

#[test]
fn every_file_of_hidden_physics_is_registered_and_described() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/physics/hidden");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().replace('_', "-"))
        .filter(|name| !["kind", "size"].contains(&name.as_str()))
        .collect();
    files.sort();
    assert_eq!(files, KINDS.map(|kind| kind.name));
    for kind in KINDS {
        let source = std::fs::read_to_string(format!("{folder}/{}.rs", kind.name.replace('-', "_"))).unwrap();
        let header: Vec<&str> = source.lines().take_while(|line| line.starts_with("//!")).collect();
        assert!(header.len() >= 4 && header.join(" ").contains("Looks like"), "{}: header", kind.name);
        assert!(!kind.about.is_empty() && !kind.amplitude.is_empty(), "{}", kind.name);
    }
    let ids = hidden::ids();
    assert!(ids.iter().enumerate().all(|(i, id)| !ids[..i].contains(id)), "{ids:?}");
    assert!(KINDS.iter().filter(|kind| !kind.catalogued).count() >= 3);
}

#[test]
fn an_unknown_id_names_the_nearest_that_is_allowed() {
    for (wanted, meant) in
        [("gravity-sag:Q", "gravity-sag:"), ("termal-drift", "did you mean thermal-drift?")]
    {
        let problem = hidden::find(wanted).unwrap_err().to_string();
        assert!(problem.contains(wanted) && problem.replacen(wanted, "", 1).contains(meant), "{problem}");
    }
    let unfit = Truth::draw(&table_bc(), &low_and_high(), &[choice("gravity-sag:A")], RUN_S, 1).unwrap_err();
    assert!(unfit.to_string().contains("table-bc"));
}

#[test]
fn every_effect_shows_at_its_size_in_its_cycle_and_nothing_else_shows() {
    let states = grid::compressed(grid::standard_bc(&table_bc(), &low_and_high()), RUN_S);
    for seed in 0..3 {
        for hidden in drawn(seed) {
            let rms_mm = rms_mm(&simulate_points(&machine_with(&hidden), &states));
            match hidden.kind.seen_in {
                SeenIn::StaticGrid => {
                    assert!((rms_mm / TYPICAL_RMS_MM - 1.0).abs() < 0.01, "{} {rms_mm}", hidden.id());
                }
                SeenIn::OnTheFly => assert!(rms_mm < 1e-11, "{} {rms_mm}", hidden.id()),
                SeenIn::Turns => unreachable!("not drawn"),
            }
        }
    }
}

#[test]
fn every_effect_is_finite_over_the_volume() {
    for hidden in drawn(5) {
        let machine = machine_with(&hidden);
        for (b, c) in [(-1.9, -12.0), (0.0, 0.0), (1.9, 12.0), (1e-9, 6.3)] {
            for (xyz, direction, time_s) in
                [(-400.0, -1.0, None), (400.0, 1.0, Some(1e6)), (0.0, 0.0, Some(0.0))]
            {
                let mut state = State { time_s, setup: 1, ..State::default() };
                for letter in Joint::LINEAR {
                    state.position[letter] = xyz;
                    state.velocity[letter] = xyz;
                    state.direction[letter] = direction;
                }
                state.position[Joint::B] = b;
                state.position[Joint::C] = c;
                state.direction[Joint::C] = direction;
                state.velocity[Joint::C] = direction;
                let read = machine.ideal_reading_mm(1, &state);
                assert!(read.iter().all(|value| value.is_finite()), "{} {state:?}", hidden.id());
            }
        }
    }
}

#[test]
fn servo_lag_of_c_is_21_um_a_millisecond_at_360_degrees_a_minute_and_200_mm() {
    // docs/design/physics.md §9.
    let (kind, place) = hidden::find("servo-lag:C").unwrap();
    let lag = Hidden { kind, place, amplitude: 1e-3, shape: vec![1.0] };
    let mut truth = Truth::perfect("table-bc", &low_and_high(), RUN_S);
    truth.hidden = vec![lag];
    truth.setups[0].setup.ball_in_table_mm.x = 200.0;
    let machine = VirtualMachine::new(table_bc(), truth).unwrap();
    let mut state = State::default();
    state.position[Joint::X] = 200.0;
    state.position[Joint::Z] = 60.0;
    state.velocity[Joint::C] = 360_f64.to_radians() / 60.0;
    let [x, y, _] = machine.ideal_reading_mm(0, &state);
    assert!(x.abs() < 1e-5 && (y - 0.02094).abs() < 1e-5, "{x} {y}");
}

#[test]
fn a_random_choice_survives_the_fit_of_location_errors_and_settings() {
    let machine = table_bc();
    let states = grid::compressed(grid::standard_bc(&machine, &low_and_high()), RUN_S);
    let mut seen = Vec::new();
    for seed in 0..24 {
        let choice = hidden::random(&machine, seed);
        assert_eq!(choice, hidden::random(&machine, seed));
        let truth =
            Truth::draw(&machine, &low_and_high(), std::slice::from_ref(&choice), RUN_S, seed).unwrap();
        assert!(truth.hidden[0].kind.catalogued);
        let left_mm = hidden::size::surviving_rms_mm(&truth.hidden[0], &machine, &low_and_high(), &states);
        assert!(left_mm > 0.3e-3, "{} keeps {left_mm} mm", choice.id);
        seen.push(choice.id);
    }
    seen.sort();
    seen.dedup();
    assert!(seen.len() >= 6, "{seen:?}");
}

#[test]
fn a_bowed_guideway_has_neither_slope_nor_offset_over_the_travel_used() {
    let machine = table_bc();
    let states = grid::standard_bc(&machine, &low_and_high());
    for (letter, seed) in [(Joint::X, 1), (Joint::Y, 2), (Joint::Z, 3)] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let choice = choice(&format!("straightness:{letter}"));
        let hidden = Hidden::draw(&choice, &machine, &low_and_high(), RUN_S, &mut rng).unwrap();
        let positions = || states.iter().map(|state| state.position[letter]);
        let low_mm = positions().fold(f64::INFINITY, f64::min);
        let high_mm = positions().fold(f64::NEG_INFINITY, f64::max);
        let virtual_machine = machine_with(&hidden);
        let nothing = Truth::perfect("table-bc", &low_and_high(), RUN_S);
        let straight = VirtualMachine::new(table_bc(), nothing).unwrap();
        // Evenly over the travel; the other axes are at rest, so that readings differ by the deviation alone.
        let (mut offset, mut slope, mut size) = ([0.0; 3], [0.0; 3], 0.0_f64);
        let count = 2000;
        for i in 0..count {
            let s = 2.0 * (f64::from(i) + 0.5) / f64::from(count) - 1.0;
            let mut state = State::default();
            state.position[letter] = low_mm + (s + 1.0) / 2.0 * (high_mm - low_mm);
            let read = virtual_machine.ideal_reading_mm(0, &state);
            let nominal = straight.ideal_reading_mm(0, &state);
            for k in 0..3 {
                let deviation = read[k] - nominal[k];
                offset[k] += deviation / f64::from(count);
                slope[k] += deviation * s * 3.0 / f64::from(count);
                size = size.max(deviation.abs());
            }
        }
        assert!(size > TYPICAL_RMS_MM, "{letter} {size}");
        for k in 0..3 {
            assert!(
                offset[k].abs() < 1e-4 * size && slope[k].abs() < 1e-4 * size,
                "{letter} {offset:?} {slope:?}"
            );
        }
    }
}
