//! The error map on the outside points sets: agreement with the joint fit, and the calibration of the nest.

use crate::common::{point, points_run};
use nalgebra::{Matrix3, Vector3};
use trunnion_core::State;
use trunnion_cycles::Run;
use trunnion_methods::findings::{Cell, FoundTable};
use trunnion_methods::recipes::MethodOptions;
use trunnion_methods::{Findings, recipes};

fn error_map(run: Run) -> Findings {
    let method = recipes::find("error-map").expect("registered");
    (method.run)(&[run], &MethodOptions::default()).unwrap_or_else(|error| panic!("{error}"))
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
fn hidden_effects_move_both_alike() {
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

/// S1 §5.3: the table sinks when it is tilted; here 6 µm were put in, none of it at B = 0.
#[test]
fn sag_shows_as_errors_of_b_that_vary_with_its_angle() {
    let sagging = error_map(points_run("points-gravity"));
    let rigid = error_map(points_run("points-nothing-hidden"));
    let range = |findings: &Findings, name: &str| findings.value(name).expect("a value").value * 1e3;
    let worst = |findings: &Findings| {
        ["EXB variation", "EZB variation"].map(|n| range(findings, n)).into_iter().fold(0.0, f64::max)
    };
    assert!(worst(&sagging) > 3.0, "{}", worst(&sagging));
    assert!(worst(&rigid) < 0.6, "{}", worst(&rigid));
    let left = |findings: &Findings, name: &str| range(findings, name);
    assert!(left(&sagging, "left by map of tilting axis") < 0.35 * left(&sagging, "left by location errors"));
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
fn a_ball_beside_the_nest_is_refused() {
    let mut run = points_run("points-nothing-hidden");
    run.points[7].state.position.0[0] += 12.0;
    let method = recipes::find("error-map").expect("registered");
    let error = (method.run)(&[run], &MethodOptions::default()).unwrap_err().to_string();
    assert!(error.contains("12.0 mm off the nest") && error.contains("linear axes"), "{error}");
}
