//! S1's map on the simulator: what was put in is found at every pose.

use super::bench::{by_method, cycle, cycle_text, measure, noise, truth, value};
use trunnion_methods::Findings;
use trunnion_methods::findings::Cell;
use trunnion_methods::recipes::Convention;

const UM: f64 = 1e-3;
const URAD: f64 = 1e-6;

const LOCATION: &str = "[location]\nEX0B_um = 3.0\nEZ0B_um = 13.0\nEA0B_urad = 12.0\nEB0B_urad = -20.0\nEC0B_urad = -9.0\n\
     EX0C_um = 4.0\nEY0C_um = 6.0\nEA0C_urad = -16.0\n";

/// Error motions that no constant of the other axis can imitate: of B, tilts of 2 lobes; of C, three lobes a turn.
const MOTIONS: &str = "[[hidden]]\nid = \"tilt-error-motion:B\"\namplitude = 30e-6\n\
     shape = { lobes = 2.0, u_cos = 0.0, u_sin = 1.0, v_cos = 0.0, v_sin = 0.5 }\n\
     [[hidden]]\nid = \"tilt-error-motion:C\"\namplitude = 20e-6\n\
     shape = { lobes = 3.0, u_cos = 1.0, u_sin = 0.0, v_cos = 0.0, v_sin = -0.5 }\n\
     [[hidden]]\nid = \"radial-error-motion:C\"\namplitude = 2e-3\n\
     shape = { lobes = 3.0, u_cos = 0.5, u_sin = 0.0, v_cos = 0.0, v_sin = 1.0 }\n";

fn error_map(rest: &str) -> Findings {
    let cycle = cycle(&cycle_text("r-test-static"));
    let run = measure(&truth("table-bc", 4, &cycle, &[], rest), &cycle);
    by_method("error-map", &run, Convention::RightHanded).unwrap_or_else(|error| panic!("{error}"))
}

fn rows<'a>(findings: &'a Findings, caption: &str) -> Vec<Vec<f64>> {
    let number = |cell: &'a Cell| match cell {
        Cell::Number(number) => *number,
        other => panic!("{other:?} is no number"),
    };
    let table = findings.tables.iter().find(|table| table.caption.starts_with(caption)).expect("a table");
    table.rows.iter().map(|row| row.iter().map(number).collect()).collect()
}

fn near(found: f64, expected: f64, within: f64, what: &str) {
    assert!((found - expected).abs() <= within, "{what}: {found:e}, put in {expected:e}");
}

#[test]
fn location_errors_alone_give_flat_maps() {
    let found = error_map(&format!("{LOCATION}{}", noise(0.0, 0.0)));
    for (name, injected) in [("EX0B", 3.0), ("EZ0B", 13.0), ("EX0C", 4.0), ("EY0C", 6.0)] {
        near(value(&found, name), injected * UM, 0.01 * UM, name);
    }
    for (name, injected) in [("EA0B", 12.0), ("EB0B", -20.0), ("EC0B", -9.0), ("EA0C", -16.0)] {
        near(value(&found, name), injected * URAD, 0.05 * URAD, name);
    }
    // S1 §5.3: a shift of C's line in Y is the average of the map of B.
    for row in rows(&found, "Errors of B") {
        near(row[2], 6.0 * UM, 0.02 * UM, "EYB holds EY0C");
        near(row[5], -20.0 * URAD, 0.1 * URAD, "EBB");
    }
    for row in rows(&found, "Errors of C") {
        assert!(row[2..5].iter().all(|mm| mm.abs() < 0.02 * UM), "{row:?}");
        assert!(row[5..].iter().all(|rad| rad.abs() < 0.1 * URAD), "{row:?}");
    }
    near(value(&found, "left by both maps"), 0.0, 0.01 * UM, "left");
}

#[test]
fn error_motions_of_both_axes_are_found_at_every_pose() {
    let found = error_map(&format!("[location]\n{}{MOTIONS}", noise(0.0, 0.0)));
    for row in rows(&found, "Errors of C") {
        let (sin, cos) = (3.0 * row[1]).sin_cos();
        near(row[2], UM * cos, 0.03 * UM, "EXC");
        near(row[3], 2.0 * UM * sin, 0.03 * UM, "EYC");
        near(row[5], 20.0 * URAD * cos, 0.3 * URAD, "EAC");
        near(row[6], -10.0 * URAD * sin, 0.3 * URAD, "EBC");
    }
    // u, v of B are Z, X: ECB = 30 sin 2B, EAB = 15 sin 2B, but for an offset g of the zero pose about C, which no reading sees:
    // it adds g sin B to EAB and g cos B to ECB.
    let off = rows(&found, "Errors of B").into_iter().map(|row| {
        let sin = (2.0 * row[0]).sin();
        (row[0].sin_cos(), row[4] - 15.0 * URAD * sin, row[6] - 30.0 * URAD * sin)
    });
    let off: Vec<_> = off.collect();
    let g = off.iter().map(|((sin, cos), a, c)| a * sin + c * cos).sum::<f64>() / off.len() as f64;
    for ((sin, cos), a, c) in off {
        near(a, g * sin, 0.3 * URAD, "EAB");
        near(c, g * cos, 0.3 * URAD, "ECB");
    }
    assert!(value(&found, "left by location errors") > 1.0 * UM);
    assert!(value(&found, "left by both maps") < 0.02 * UM);
}

#[test]
fn one_nest_position_is_refused_with_what_to_do() {
    let text = cycle_text("r-test-static").replace("[150.0, 0.0, 160.0]", "[150.0, 0.0, 60.0]");
    let cycle = cycle(&text);
    let run =
        measure(&truth("table-bc", 4, &cycle, &[], &format!("[location]\n{}", noise(0.0, 0.0))), &cycle);
    let error = by_method("error-map", &run, Convention::RightHanded).unwrap_err().to_string();
    assert!(error.contains("apart in height") && error.contains("r-test-static"), "{error}");
}
