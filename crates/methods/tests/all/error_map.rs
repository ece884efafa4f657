//! The error map on the outside points sets: agreement with the joint fit, and the calibration of the nest.

use crate::common::{point, points_run};
use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::State;
use trunnion_core::axis::iso::B;
use trunnion_cycles::{Cycle, Pace, Run, RunKind};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, shipped};
use trunnion_methods::findings::{Cell, FoundTable};
use trunnion_methods::recipes::MethodOptions;
use trunnion_methods::{Findings, recipes};

fn error_map(run: Run) -> Findings {
    let method = recipes::find("error-map").expect("registered");
    method.apply(&[run], &MethodOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn number(cell: &Cell) -> f64 {
    match cell {
        Cell::Number(number) => *number,
        other => panic!("{other:?} is no number"),
    }
}

fn table<'a>(findings: &'a Findings, caption: &str) -> &'a FoundTable {
    let found = findings.tables.iter().find(|table| table.caption.starts_with(caption));
    found.unwrap_or_else(|| panic!("no table {caption}"))
}

/// Every location error by maps, by the joint fit with its u, and how far they are apart: µm or µrad.
fn compared(folder: &str) -> Vec<(String, f64, f64)> {
    let findings = error_map(points_run(folder));
    let table = table(&findings, "Location errors");
    assert_eq!(table.rows.len(), 8, "{folder}");
    let row = |row: &Vec<Cell>| {
        let [map, joint, u_joint] = [2, 4, 5].map(|k| number(&row[k]));
        let Cell::Text(name) = &row[0] else { panic!("{:?} is no name", row[0]) };
        (name.clone(), (map - joint).abs(), u_joint)
    };
    table.rows.iter().map(row).collect()
}

#[test]
fn locations_by_maps_agree_with_the_joint_fit_where_nothing_is_hidden() {
    for (name, apart, u_joint) in compared("points-nothing-hidden") {
        assert!(apart <= 0.5 * u_joint, "{name}: {apart} apart, u {u_joint}");
    }
}

/// What is hidden goes into the constants of both ways, a little differently: the joint fit weighs all readings alike, the map all
/// angles of B. It moves EZ0B and EC0B most.
#[test]
fn hidden_effects_move_both_the_same() {
    for (folder, most_um, most_urad) in [
        ("points-gravity", 0.97, 0.5),
        ("points-backlash-and-drift", 0.2, 0.1),
        ("points-unnamed", 0.1, 11.0),
    ] {
        for (name, apart, _) in compared(folder) {
            let is_angle = matches!(name.as_bytes()[1], b'A' | b'B' | b'C');
            let most = if is_angle { most_urad } else { most_um };
            assert!(apart <= most, "{folder} {name}: {apart} apart");
        }
    }
}

/// The range of an error motion of B as read, which its remark states next to the upper bound, µm or µrad.
fn as_read(findings: &Findings, name: &str) -> f64 {
    let value = findings.value(&format!("{name} range at most")).expect("a value");
    let read = value.note.split("as read ").nth(1).and_then(|rest| rest.split(' ').next());
    let read: f64 = read.expect("a range as read").parse().expect("a number");
    assert!(value.u.is_none() && value.value * value.unit.per_inside > read, "{value:?}");
    read
}

/// S1 §5.3: the table sinks when it is tilted; here 6 µm were put in, none of it at B = 0.
#[test]
fn sag_shows_as_errors_of_b_that_vary_with_its_angle() {
    let sagging = error_map(points_run("points-gravity"));
    let rigid = error_map(points_run("points-nothing-hidden"));
    let worst =
        |findings: &Findings| ["EXB", "EZB"].map(|n| as_read(findings, n)).into_iter().fold(0.0, f64::max);
    assert!(worst(&sagging) > 3.0, "{}", worst(&sagging));
    assert!(worst(&rigid) < 0.6, "{}", worst(&rigid));
    let is_sure = |findings: &Findings| {
        let value = findings.value("EZB range at most").expect("a value");
        value.note.contains(", more than noise of the readings makes")
    };
    assert!(is_sure(&sagging) && !is_sure(&rigid));
    let left = |findings: &Findings, name: &str| findings.value(name).expect("a value").value * 1e3;
    assert!(left(&sagging, "left by map of tilting axis") < 0.35 * left(&sagging, "left by location errors"));
}

/// Nests at the radius 150 mm, 100 mm apart in height: one that reads 1 µm off across C leans the line between them, and that makes a wave of 1.5 µm of
/// EZC. It is no error of C, and the value says so.
#[test]
fn a_nest_position_that_is_off_the_other_is_not_taken_for_axial_motion() {
    let named = |run: Run| {
        let findings = error_map(run);
        let range = findings.values.iter().find(|value| value.name.starts_with("EZC range"));
        let range = range.expect("a range of EZC");
        let off = range.note.split("off the other by ").nth(1).and_then(|rest| rest.split(' ').next());
        off.map(|um| (um.parse::<f64>().expect("a number"), range.value * 1e3))
    };
    let run = points_run("points-nothing-hidden");
    assert_eq!(named(run.clone()), None);
    let mut off = run;
    for point in off.points.iter_mut().filter(|point| point.state.setup == 1) {
        let mut turned = point.state.position;
        turned[B] = 0.0;
        let carrier_from_table = off.machine.machine_from_table(&turned, &Default::default()).rotation;
        let reading = Vector3::from(point.reading_mm) + carrier_from_table.inverse() * Vector3::x() * 1e-3;
        point.reading_mm = reading.into();
    }
    let (off_um, range_um) = named(off).expect("a remark");
    assert!(
        (off_um - 1.0).abs() < 0.15 && (range_um - 3.0).abs() < 0.4,
        "{off_um} µm off, range {range_um} µm"
    );
}

#[test]
fn linear_steps_calibrate_the_nest() {
    let plain = points_run("points-nothing-hidden");
    // The probes of the nest read with wrong gains and across each other.
    let reading_from_true = Matrix3::new(1.02, 0.01, -0.004, -0.006, 0.985, 0.008, 0.003, -0.012, 1.01);
    let mut skewed = plain.clone();
    for point in &mut skewed.points {
        point.reading_mm = (reading_from_true * Vector3::from(point.reading_mm)).into();
    }
    let without = error_map(skewed.clone());
    assert!(without.notes.iter().any(|note| note.contains("no linear steps")));
    for setup in 0..skewed.setups.len() {
        let base = skewed.points.iter().find(|p| p.state.setup == setup).expect("read").clone();
        for k in 0..3 {
            for step_mm in [-0.2, -0.1, 0.1, 0.2] {
                let mut state = State { ..base.state.clone() };
                state.position.0[k] += step_mm;
                let machine = &skewed.machine;
                let turned =
                    machine.machine_from_table(&state.position, &Default::default()).rotation.inverse();
                let seen = reading_from_true * (turned * (Vector3::ith(k, 1.0) * step_mm));
                let reading = Vector3::from(base.reading_mm) + seen;
                skewed.points.push(point(state, reading.into()));
            }
        }
    }
    let found = error_map(skewed);
    let gains = table(&found, "Probe directions");
    for (row, k) in gains.rows.iter().zip([0, 1, 2, 0, 1, 2]) {
        let expected = reading_from_true.row(k).norm();
        assert!((number(&row[2]) - expected).abs() < 1e-9, "{row:?}");
    }
    let (mended, plain) = (found, error_map(plain));
    for (row, plain_row) in table(&mended, "Location").rows.iter().zip(&table(&plain, "Location").rows) {
        assert!((number(&row[2]) - number(&plain_row[2])).abs() < 1e-6, "{row:?}");
    }
    for (row, plain_row) in
        table(&without, "Location").rows.iter().zip(&table(&plain, "Location").rows).take(1)
    {
        assert!((number(&row[2]) - number(&plain_row[2])).abs() > 0.05, "the skew must matter: {row:?}");
    }
}

#[test]
fn a_ball_out_of_the_nest_is_refused() {
    let mut run = points_run("points-nothing-hidden");
    run.points[7].state.position.0[0] += 12.0;
    let method = recipes::find("error-map").expect("registered");
    let error = method.apply(&[run], &MethodOptions::default()).unwrap_err().to_string();
    assert!(error.contains("12.0 mm off the nest") && error.contains("linear axes"), "{error}");
}

#[test]
fn errors_of_c_have_uncertainties_that_hold_where_nothing_is_hidden() {
    let findings = error_map(points_run("points-nothing-hidden"));
    let map = table(&findings, "Errors of C at each pose");
    let count = (map.columns.len() - 2) / 2;
    assert_eq!(count, 5);
    assert!((0..count).all(|k| map.columns[2 + count + k].name == format!("u {}", map.columns[2 + k].name)));
    let pairs = map
        .rows
        .iter()
        .flat_map(|row| (0..count).map(|k| (number(&row[2 + k]), number(&row[2 + count + k]))));
    let held: Vec<bool> = pairs.map(|(value, u)| value.abs() <= 1.96 * u).collect();
    let share = held.iter().filter(|held| **held).count() as f64 / held.len() as f64;
    // 95 % of some 400 numbers, a little more where the map of B has taken the mean over C.
    assert!((0.92..=0.995).contains(&share), "{share} of {}", held.len());
    for name in ["EXC", "EYC", "EZC", "EAC", "EBC"] {
        let of = |ending: &str| findings.value(&format!("{name} {ending}"));
        assert!(of("variation").is_none(), "a range as read has no place next to one without noise");
        let (found, bound) = (of("range"), of("range of one wave at most"));
        assert!(found.is_some_and(|v| v.u.is_some()) != bound.is_some_and(|v| v.value > 0.0), "{name}");
        // The largest of several tilts was chosen by its noise: no value with u, an upper bound.
        assert!(of("largest range").is_none(), "{name}");
        assert!(of("largest range at most").is_some_and(|v| v.value > 0.0 && v.u.is_none()), "{name}");
    }
}

#[test]
fn coning_is_printed_as_the_source_prints_it_and_maps_have_the_magnification_asked_for() {
    let options = MethodOptions {
        convention: recipes::Convention::Source,
        magnification: Some(20_000.0),
        ..MethodOptions::default()
    };
    let method = recipes::find("error-map").expect("registered");
    let mut run = points_run("points-nothing-hidden");
    // The table leans about X by 200 µrad · sin B; what of it is no location error stays.
    let machine = run.machine.clone();
    for point in &mut run.points {
        let position = &point.state.position;
        let lean = 200e-6 * position[trunnion_core::Joint::B].sin();
        let machine_from_table = machine.machine_from_table(position, &Default::default());
        let frame = machine.joint_frame(trunnion_core::Joint::B, position).expect("B");
        let nest = machine_from_table * run.setups[point.state.setup].ball_in_table_mm;
        let twist = trunnion_core::Twist::rotation(Vector3::x() * lean);
        let moved = machine_from_table.rotation.inverse() * -frame.displacement_mm(&nest, &twist);
        point.reading_mm = (Vector3::from(point.reading_mm) + moved).into();
    }
    let findings = method.apply(&[run], &options).unwrap_or_else(|error| panic!("{error}"));
    let note = findings.value("EAB range at most").expect("a value").note.replace('−', "-");
    let mut ends = note.split("; ").next().unwrap().trim_start_matches("from ").split(" to ");
    let mut end =
        || ends.next().unwrap().trim_end_matches('°').parse::<f64>().unwrap_or_else(|_| panic!("{note}"));
    let (low, high) = (end(), end());
    assert!(low < -0.002 && high > 0.002, "{note}");
    let as_read = (as_read(&findings, "EAB") * 1e-6).to_degrees();
    assert!((high - low - as_read).abs() < 2e-4, "{note}: {as_read}");
    let maps = findings.charts.iter().filter_map(|chart| match &chart.plot {
        trunnion_methods::findings::Plot::PlaneMap { magnification, .. } => Some(*magnification),
        _ => None,
    });
    let maps: Vec<f64> = maps.collect();
    assert!(maps.len() >= 4 && maps.iter().all(|m| *m == 20_000.0), "{maps:?}");
}

/// Six angles of C, each pose read once: nothing repeats, and the errors of C take five of the readings of a pose.
#[test]
fn uncertainties_of_a_small_grid_hold() {
    const NOISE_MM: f64 = 0.3e-3;
    const SEEDS: u64 = 40;
    let path = format!("{}/../../config/cycles/r-test-static.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("to_deg = 330\nstep_deg = 30", "to_deg = 300\nstep_deg = 60");
    let text = text.replace("passes = [\"+\", \"-\"]", "passes = [\"+\"]");
    let cycle = Cycle::parse("cycle.toml", &text).unwrap_or_else(|problems| panic!("{problems}"));
    let machine = shipped::machine(&cycle.machine).unwrap();
    let states = cycle.visits(&machine, &Pace::default()).unwrap().states;
    // Further nest positions against the first: none, one on the line of the two, one far from it. u(EXC) by hand where the heights z
    // above the joint decide alone: 0.3 µm √(1/N + z̄²/Σ(z − z̄)²) for 60, 160 and for 60, 110, 160 mm.
    let further =
        [(None, Some(0.513)), (Some([0.0, 0.0, 50.0]), Some(0.498)), (Some([40.0, -150.0, 30.0]), None)];
    for (third, by_hand_um) in further {
        let (mut setups, mut states) = (cycle.setups.clone(), states.clone());
        if let Some(offset) = third {
            let mut setup = setups[0].clone();
            setup.name = "third".into();
            setup.ball_in_table_mm += Vector3::from(offset);
            setups.push(setup);
            // The linear axes follow the ball: to the place of the first, moved by as much as the table turns.
            let of_first: Vec<State> = states.iter().filter(|state| state.setup == 0).cloned().collect();
            states.extend(of_first.into_iter().map(|state| moved_to(&machine, &setups, state)));
        }
        let (mut squares, mut count, mut u2_um2) = (0.0, 0.0, 0.0);
        for seed in 0..SEEDS {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
            let mut read = |state: &State| {
                let nominal = predict(&machine, &setups[state.setup], state, &Errors::default());
                point(state.clone(), [0, 1, 2].map(|k| nominal[k] + NOISE_MM * noise()))
            };
            let points = states.iter().map(&mut read).collect();
            let (name, setups) = (cycle.name.clone(), setups.clone());
            let kind = RunKind::Static;
            let run = Run { name, machine: machine.clone(), kind, setups, channels: vec![], points };
            let findings = error_map(run);
            let map = table(&findings, "Errors of C at each pose");
            assert_eq!(map.rows.len(), 42);
            for row in &map.rows {
                for k in 0..5 {
                    squares += (number(&row[2 + k]) / number(&row[7 + k])).powi(2);
                    count += 1.0;
                }
            }
            u2_um2 += (number(&map.rows[0][7]) * 1e3).powi(2) / SEEDS as f64;
        }
        // The mean over C counts as an error of B: at a tilt that is one sixth of what two nest positions show.
        let rms = f64::sqrt(squares / count);
        // u has some 41 degrees of freedom: √(41/39) = 1.025 is expected where that does not lower it.
        assert!((0.85..=1.05).contains(&rms), "rms of value over u: {rms}, third {third:?}");
        // 40 times 41 degrees of freedom: u to 2 %.
        let u_um = u2_um2.sqrt();
        assert!(
            by_hand_um.is_none_or(|um| (u_um / um - 1.0).abs() < 0.05),
            "u(EXC) {u_um} µm, third {third:?}"
        );
    }
}

/// The same pose with the ball of the last setup at the tool.
fn moved_to(machine: &trunnion_machine::Machine, setups: &[trunnion_core::Setup], mut state: State) -> State {
    let table = machine.machine_from_table(&state.position, &Default::default());
    let last = setups.len() - 1;
    let by = table.rotation * (setups[last].ball_in_table_mm - setups[state.setup].ball_in_table_mm);
    (0..3).for_each(|k| state.position.0[k] += by[k]);
    state.setup = last;
    state
}
