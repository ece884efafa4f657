//! `circular` on readings made from the states of a shipped cycle: each error is found alone, and what is on no list is left.

use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::TAU;
use trunnion_core::axis::iso::{X, Y};
use trunnion_core::direction::Travel;
use trunnion_core::{Point, Quality, State};
use trunnion_cycles::Pace;
use trunnion_cycles::{Cycle, Run, RunKind};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, shipped};
use trunnion_methods::findings::Cell;
use trunnion_methods::recipes::MethodOptions;
use trunnion_methods::{Findings, recipes};

const UM: f64 = 1e-3;
const R_MM: f64 = 150.0;

/// The shipped XY circle; the tool is displaced by `(x, y)` mm of the state; noise in µm.
pub fn circle(displaced: impl Fn(&State) -> (f64, f64), noise_um: f64, calibrated: bool) -> Run {
    circle_with(displaced, noise_um, calibrated, 5)
}

fn circle_with(displaced: impl Fn(&State) -> (f64, f64), noise_um: f64, calibrated: bool, seed: u64) -> Run {
    let path = format!("{}/../../config/cycles/circle-xy.toml", env!("CARGO_MANIFEST_DIR"));
    let mut cycle = Cycle::parse("cycle.toml", &std::fs::read_to_string(path).unwrap())
        .unwrap_or_else(|problems| panic!("{problems}"));
    cycle.setups[0].calibrated = calibrated;
    let machine = shipped::machine(&cycle.machine).unwrap();
    let states = cycle.visits(&machine, &Pace::default()).unwrap_or_else(|error| panic!("{error}")).states;
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, noise_um.max(1e-9) * UM).unwrap();
    let point = |state: State| {
        let nominal_mm = predict(&machine, &cycle.setups[0], &state, &Errors::default()).x;
        let (x, y) = displaced(&state);
        let (sin, cos) = angle(&state).sin_cos();
        let reading_mm = [nominal_mm + x * cos + y * sin + noise.sample(&mut rng), 0.0, 0.0];
        Point { reading_mm, state, spread_mm: [0.0; 3], samples: 1, quality: Quality::Good }
    };
    let points = states.into_iter().map(point).collect();
    let setups = cycle.setups.clone();
    Run {
        name: "circle".into(),
        machine: machine.clone(),
        kind: RunKind::OnTheFly,
        setups,
        channels: vec![],
        points,
    }
}

fn angle(state: &State) -> f64 {
    state.position[Y].atan2(state.position[X])
}

pub fn circular(run: Run) -> Findings {
    let method = recipes::find("circular").unwrap();
    method.apply(&[run], &MethodOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

pub fn value(findings: &Findings, name: &str) -> f64 {
    findings.value(name).unwrap_or_else(|| panic!("no value {name}")).value
}

pub fn near(found: f64, injected: f64, within: f64, what: &str) {
    assert!((found - injected).abs() <= within, "{what}: {found}, injected {injected}");
}

/// Error and circularity (mm) of the ranking, in its order.
fn ranking(findings: &Findings) -> Vec<(String, f64)> {
    let row = |row: &Vec<Cell>| match (&row[1], &row[2]) {
        (Cell::Text(name), Cell::Number(circularity)) => (name.clone(), *circularity),
        other => panic!("{other:?}"),
    };
    findings.tables[0].rows.iter().map(row).collect()
}

/// One error alone: it ranks first with this circularity, has this value, and little else is seen or left.
fn check(name: &str, displaced: impl Fn(&State) -> (f64, f64), injected: f64, circularity_um: f64) {
    let found = circular(circle(displaced, 0.0, false));
    let ranked = ranking(&found);
    assert_eq!(ranked[0].0, name, "{ranked:?}");
    near(value(&found, &format!("XY {name}")), injected, 0.02 * injected.abs(), name);
    near(ranked[0].1, circularity_um * UM, 0.03 * circularity_um * UM, name);
    assert!(ranked[1].1 < 0.05 * ranked[0].1, "{ranked:?}");
    assert!(value(&found, "XY unexplained share") < 1e-3, "{name}: {ranked:?}");
}

#[test]
fn each_error_of_the_list_is_found_alone_with_its_own_circularity() {
    // Circularities by hand: an oval ½ γ R sin 2φ ranges over γ R; the same of scale, and of servo over τ v.
    check("EC0Y", |s| (-20e-6 * s.position[Y], 0.0), 20e-6, 20e-6 * R_MM / UM);
    check("scale X−Y", |s| (10e-6 * s.position[X], -10e-6 * s.position[Y]), 20e-6, 20e-6 * R_MM / UM);
    let feed = 1000.0 / 60.0;
    check("servo X−Y", |s| (-0.2e-3 * s.velocity[X], 0.0), 0.2e-3, 0.2e-3 * feed / UM);
    // ½ h |cos φ| with its sign jumping at 0° and 180°: from −½ h to ½ h, no more after centring.
    check("backlash X", |s| (-2.0 * UM * s.direction[X], 0.0), -4.0 * UM, 4.0);
    check("backlash Y", |s| (0.0, 2.0 * UM * s.direction[Y]), 4.0 * UM, 4.0);
    // sin²φ cos φ = (cos φ − cos 3φ)/4: three lobes of range w/2.
    check("straightness Y", |s| (6.0 * UM * (s.position[Y] / R_MM).powi(2), 0.0), 6.0 * UM, 3.0);
    // ½ p |sin φ| less its mean, opposite in the two ways: from −½ p to ½ p.
    check("lateral play X", |s| (0.0, 2.0 * UM * s.direction[X]), 4.0 * UM, 4.0);
    // One wave a lead of 12 mm, none at the ends: crests at x = 147 and 141 mm of opposite sign, times cos φ.
    check(
        "cyclic X",
        |s| (1.5 * UM * (TAU * s.position[X] / 12.0).sin(), 0.0),
        1.5 * UM,
        1.5 * (147.0 + 141.0) / R_MM,
    );
    let spike = |s: &State| (0.0, -5.0 * UM * s.direction[Y] * (-s.since_reversal[Y].abs() / 2.5).exp());
    let found = circular(circle(spike, 0.0, false));
    assert_eq!(ranking(&found)[0].0, "reversal spike Y");
    near(value(&found, "XY reversal spike Y"), 5.0 * UM, 0.15 * UM, "spike");
    assert!(value(&found, "XY unexplained share") < 0.01);
}

/// The same circle on a grid plate that lies off its place and turned: what a bar reads, at 1 mm of radius too.
#[test]
fn a_grid_plate_reads_the_errors_of_a_circle_of_one_millimetre() {
    let path = format!("{}/../../config/cycles/cross-grid-small.toml", env!("CARGO_MANIFEST_DIR"));
    let cycle = Cycle::parse("cycle.toml", &std::fs::read_to_string(path).unwrap())
        .unwrap_or_else(|problems| panic!("{problems}"));
    let machine = shipped::machine(&cycle.machine).unwrap();
    let turn_rad = 300e-6;
    let point = |state: State| {
        let (x, y) = (state.position[X], state.position[Y]);
        // Backlash of X of 3 µm, servo mismatch of 2 ms.
        let (x, y) = (x + 1.5 * UM * state.direction[X] - 2e-3 * state.velocity[X], y);
        let reading_mm = [x + turn_rad * y + 12.3, y - turn_rad * x - 4.5, 0.0];
        Point { reading_mm, state, spread_mm: [0.0; 3], samples: 1, quality: Quality::Good }
    };
    let states = cycle.visits(&machine, &Pace::default()).unwrap_or_else(|error| panic!("{error}")).states;
    let run = Run {
        name: "plate".into(),
        machine: machine.clone(),
        kind: RunKind::OnTheFly,
        setups: cycle.setups.clone(),
        channels: vec![],
        points: states.into_iter().map(point).collect(),
    };
    let found = circular(run);
    near(value(&found, "XY backlash X"), 3.0 * UM, 0.06 * UM, "backlash");
    near(value(&found, "XY servo X−Y"), 2e-3, 0.05e-3, "servo");
    // A calibrated plate knows its lengths, so D and F are there.
    assert!(found.value("XY D").is_some() && found.value("XY F max").is_some());
    assert!(value(&found, "XY unexplained share") < 0.01);
}

#[test]
fn several_errors_together_are_distinguished_in_noise() {
    let found = circular(circle(
        |s| {
            let (x, y) = (s.position[X], s.position[Y]);
            (-30e-6 * y + 15e-6 * x - 1.5 * UM * s.direction[X], -0.3e-3 * s.velocity[Y])
        },
        0.3,
        false,
    ));
    for (name, injected) in [
        ("EC0Y", 30e-6),
        ("scale X−Y", 15e-6),
        ("backlash X", -3.0 * UM),
        ("servo X−Y", -0.3e-3),
        ("backlash Y", 0.0),
    ] {
        let found = found.value(&format!("XY {name}")).unwrap();
        let u = found.u.unwrap();
        assert!(
            (found.value - injected).abs() < 4.0 * u,
            "{name}: {} u {u}, injected {injected}",
            found.value
        );
    }
    assert!(value(&found, "XY unexplained beyond noise") < 0.1 * UM);
    // A page has one figure for the whole trace.
    assert_eq!(ranking(&found).last(), Some(&("whole trace".to_string(), value(&found, "XY G(b)"))));
    assert!(!found.notes.iter().any(|note| note.contains("does not explain everything")));
}

#[test]
fn a_run_without_speed_keeps_backlash_and_spikes_clear_of_the_servo_mismatch() {
    let feed = 1000.0 / 60.0;
    let displaced = |s: &State| (-UM * s.direction[X] - 0.4e-3 * s.velocity[X], 0.0);
    let mut run = circle(displaced, 0.2, false);
    run.kind = RunKind::Static;
    for point in &mut run.points {
        let State { velocity, acceleration, since_reversal, .. } = State::default();
        point.state = State { velocity, acceleration, since_reversal, time_s: None, ..point.state.clone() };
    }
    let found = circular(run);
    for (name, injected) in
        [("backlash X", -2.0 * UM), ("backlash Y", 0.0), ("servo X−Y × speed", 0.4e-3 * feed)]
    {
        let found = found.value(&format!("XY {name}")).unwrap_or_else(|| panic!("{name}"));
        let u = found.u.unwrap();
        assert!((found.value - injected).abs() < 4.0 * u && u < 0.1 * UM, "{name}: {} u {u}", found.value);
    }
    assert!(
        !ranking(&found).iter().any(|(name, _)| name.starts_with("reversal spike")),
        "{:?}",
        ranking(&found)
    );
    assert!(found.notes.iter().any(|note| note.contains("knows no speed")), "{:?}", found.notes);
}

#[test]
fn the_noise_is_that_of_the_readings_whatever_the_list_lacks() {
    // Four waves a turn of 8 µm on no list, noise 0.3 µm: the verdict must not take the waves for noise.
    let off_list = |s: &State| {
        let radial = 8.0 * UM * (4.0 * angle(s)).cos();
        (radial * angle(s).cos(), radial * angle(s).sin())
    };
    let said_um = |seed: u64| -> f64 {
        let found = circular(circle_with(off_list, 0.3, false, seed));
        let note = &found.value("XY unexplained share").unwrap().note;
        assert!(note.contains("more than noise"), "{note}");
        let said = note.split("noise of the readings ").nth(1).and_then(|rest| rest.split(' ').next());
        said.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{note}"))
    };
    // Of 1130 readings the median of second differences gives it to 4 %, of twelve runs to 1.2 %.
    let mean_um = (0..12).map(said_um).sum::<f64>() / 12.0;
    near(mean_um, 0.3, 0.01, "noise");
}

#[test]
fn what_to_enter_has_the_sign_that_takes_the_error_away() {
    let found = circular(circle(|s| (-2.0 * UM * s.direction[X], 0.0), 0.1, false));
    let last = |row: &Vec<Cell>| row.last().cloned();
    let texts: Vec<_> = found.tables[0].rows.iter().filter_map(last).collect();
    assert!(texts.contains(&Cell::Text("backlash compensation of X: add +4.0 µm".into())), "{texts:?}");
    assert_eq!(texts.iter().filter(|cell| matches!(cell, Cell::Text(_))).count(), 1, "{texts:?}");
    let [look, .., enter] = &found.to_do[..] else { panic!("{:?}", found.to_do) };
    assert!(
        look.starts_with("Look for: Backlash")
            && look.contains("(backlash X). Alone it makes ")
            && look.contains("Likely cause: "),
        "{look}"
    );
    assert!(
        enter.contains("backlash compensation of X: add +4.0 µm") && enter.contains("a wrong sign"),
        "{enter}"
    );
}

#[test]
fn what_is_on_no_list_is_left_as_unexplained() {
    // Sticks between 100° and 112° one way only, and a dent at 250° both ways.
    let off_list = |s: &State| {
        let (angle, counter_clockwise) = (angle(s).rem_euclid(TAU), s.direction[Y] * s.position[X] > 0.0);
        let stuck = counter_clockwise && (1.745..1.955).contains(&angle);
        let dent = 5.0 * UM * (-0.5 * ((angle - 4.363) / 0.08).powi(2)).exp();
        let radial = dent + if stuck { 4.0 * UM } else { 0.0 };
        (radial * angle.cos() - 20e-6 * s.position[Y], radial * angle.sin())
    };
    let found = circular(circle(off_list, 0.3, false));
    // What is on the list is found all the same, within its wider uncertainty.
    let squareness = found.value("XY EC0Y").unwrap();
    near(squareness.value, 20e-6, 4.0 * squareness.u.unwrap(), "squareness");
    near(squareness.value, 20e-6, 6e-6, "squareness");
    let beyond = value(&found, "XY unexplained beyond noise");
    assert!(beyond > 0.5 * UM, "{beyond}");
    assert!(value(&found, "XY unexplained circularity") > 4.0 * UM);
    assert!(value(&found, "XY unexplained share") > 0.15);
    assert!(found.notes.iter().any(|note| note.contains("does not explain everything")));
}

/// ISO 230-4 speaks of whole circles.
#[test]
fn values_of_an_arc_are_said_to_be_no_circles() {
    let said = |is_read: fn(&State) -> bool| {
        let mut run = circle(|_| (0.0, 0.0), 0.3, true);
        run.points.retain(|point| is_read(&point.state));
        let found = circular(run);
        let note = found.value("XY G(b)").unwrap().note.clone();
        (
            note.contains("of an arc of 180° alone"),
            found.notes.iter().any(|note| note.contains("Run whole circles")),
        )
    };
    assert_eq!(said(|_| true), (false, false));
    assert_eq!(said(|state| state.position[Y] > 0.0), (true, true));
}

#[test]
fn values_of_iso_230_4_are_those_computed_by_hand() {
    // Oval of ±2 µm alike both ways, radius 3 µm too large, setting of (8, −5) µm.
    let displaced = |s: &State| {
        let angle = angle(s);
        let radial = UM * (3.0 + 2.0 * (2.0 * angle).cos());
        (radial * angle.cos() + 8.0 * UM, radial * angle.sin() - 5.0 * UM)
    };
    let known = circular(circle(displaced, 0.0, true));
    for (name, by_hand) in
        [("G(+)", 4.0), ("G(−)", 4.0), ("G(b)", 4.0), ("D", 3.0), ("F max", 5.0), ("F min", 1.0)]
    {
        near(value(&known, &format!("XY {name}")) / UM, by_hand, 0.06, name);
    }
    // Opposite both ways: each way has its own oval, both together no more, their mean none.
    let flips = circular(circle(|s| (-0.24e-3 * s.velocity[X], 0.0), 0.0, false));
    near(value(&flips, "XY G(b)") / UM, 4.0, 0.06, "G(b) of a servo mismatch");
    assert!(flips.value("XY D").is_none() && flips.value("XY F max").is_none());
}

#[test]
fn a_static_run_whose_rows_follow_the_path_has_the_speed_of_its_times() {
    let displaced = |s: &State| (-UM * s.direction[X] - 0.4e-3 * s.velocity[X], 0.0);
    let mut run = circle(displaced, 0.2, false);
    run.kind = RunKind::Static;
    for point in &mut run.points {
        let State { velocity, acceleration, since_reversal, .. } = State::default();
        point.state = State { velocity, acceleration, since_reversal, ..point.state.clone() };
    }
    let found = circular(run.clone());
    for (name, injected) in [("servo X−Y", 0.4e-3), ("backlash X", -2.0 * UM)] {
        let found = found.value(&format!("XY {name}")).unwrap_or_else(|| panic!("{name}"));
        assert!((found.value - injected).abs() < 4.0 * found.u.unwrap(), "{found:?}");
    }
    assert!(found.notes.iter().any(|note| note.contains("by time_s") && note.contains("--kind on-the-fly")));
    assert!(found.notes.iter().any(|note| note.contains("feed 1000 mm/min")), "{:?}", found.notes);
    // Rows on the fly that are too far apart for a speed at each of them: nothing was imported as static.
    let found = circular(Run { kind: RunKind::OnTheFly, ..run.clone() });
    assert!(found.notes.iter().any(|note| note.contains("too far apart in time")), "{:?}", found.notes);
    assert!(!found.notes.iter().any(|note| note.contains("imported as static")), "{:?}", found.notes);
    // Times to the second, where ten rows follow one another in it.
    let mut coarse = run.clone();
    for point in &mut coarse.points {
        point.state.time_s = point.state.time_s.map(f64::floor);
    }
    let found = circular(coarse);
    assert!(found.value("XY servo X−Y × speed").is_some());
    assert!(found.notes.iter().any(|note| note.contains("too few decimals")), "{:?}", found.notes);
    assert!(!found.notes.iter().any(|note| note.contains("do not follow the path")), "{:?}", found.notes);
    // Times that say nothing of the way from row to row.
    run.points.reverse();
    let found = circular(run);
    assert!(found.value("XY servo X−Y × speed").is_some());
    let note = found.notes.iter().find(|note| note.contains("knows no speed")).expect("a note");
    assert!(note.contains("has time_s") && note.contains("--kind on-the-fly"), "{note}");
}

/// What a table without directions becomes, of readings that stick where the row before says that the axis has reversed.
#[test]
fn a_row_between_two_directions_spoils_no_spike_and_no_backlash() {
    let stuck = |state: &State| {
        let spike = -6.0 * UM * state.direction[Y] * (-state.since_reversal[Y].abs() / 2.5).exp();
        (-2.0 * UM * state.direction[X], spike)
    };
    for seed in 1..=6 {
        let read = circle_with(stuck, 0.3, false, seed);
        let by_speed = |point: &Point| {
            let mut point = point.clone();
            for joint in [X, Y] {
                let turned = point.state.velocity[joint].signum();
                if turned != point.state.direction[joint] {
                    point.state.direction[joint] = turned;
                    point.state.since_reversal[joint] = R_MM - point.state.position[joint].abs();
                }
            }
            point
        };
        let moving = Run { points: read.points.iter().map(by_speed).collect(), ..read.clone() };
        let mut travel = Travel::default();
        let by_row = |point: &Point| {
            let position = point.state.position;
            let mut state = State { position, time_s: point.state.time_s, ..State::default() };
            travel.fill(&mut state, &[X, Y]);
            Point { state, ..point.clone() }
        };
        let points = read.points.iter().map(by_row).collect();
        let at_rest = Run { kind: RunKind::Static, points, ..read };
        for run in [moving, at_rest] {
            let kind = run.kind;
            let found = circular(run);
            for (name, injected) in [("reversal spike Y", 6.0 * UM), ("backlash X", -4.0 * UM)] {
                let value = found.value(&format!("XY {name}")).unwrap();
                let u = value.u.unwrap();
                assert!(u < 0.2 * UM, "{seed}, {kind:?}: {value:?}");
                near(value.value, injected, 4.5 * u, &format!("{seed}, {kind:?}: {name}"));
            }
            assert!(
                found.notes.iter().any(|note| note.contains("just after an axis reversed")),
                "{:?}",
                found.notes
            );
            let said = format!("{:?} {:?}", found.notes, found.values);
            assert!(!said.contains("backlash:X"), "{said}");
        }
    }
}
