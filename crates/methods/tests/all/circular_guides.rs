//! `circular` where the guides are S-shaped: what they make of a squareness, and what is said of it.

use crate::circular::{circle, circular, near, value};
use trunnion_core::State;
use trunnion_core::axis::iso::{X, Y};
use trunnion_methods::Findings;
use trunnion_methods::findings::Cell;

const UM: f64 = 1e-3;
const R_MM: f64 = 150.0;

/// S-shaped guide of X over ±240 mm: deviation from its own straight line, 1.5 µm at its ends (Legendre P₃), and EC0Y = 30 µrad over the same range.
fn s_shaped(noise_um: f64) -> Findings {
    let s_shape = |s: f64| 1.5 * UM * (5.0 * s.powi(3) - 3.0 * s) / 2.0;
    circular(circle(|s| (-30e-6 * s.position[Y], s_shape(s.position[X] / 240.0)), noise_um, false))
}

/// The row of the table of doubts for an error and a cause: u, value with the cause, most within the circle, most over the travel.
fn doubt(findings: &Findings, error: &str, cause: &str) -> [f64; 4] {
    let table = findings.tables.iter().find(|t| t.caption.starts_with("What else may read")).expect("doubts");
    let row = table
        .rows
        .iter()
        .find(|row| row[0] == Cell::Text(error.into()) && row[4] == Cell::Text(cause.into()));
    let row = row.unwrap_or_else(|| panic!("{error}, {cause}: {:?}", table.rows));
    [2, 8, 9, 10].map(|k| match &row[k] {
        Cell::Number(number) => *number,
        other => panic!("{other:?}"),
    })
}

#[test]
fn an_s_shaped_guide_is_announced_and_the_doubt_covers_the_squareness() {
    let found = s_shaped(0.3);
    let squareness = found.value("XY EC0Y").unwrap();
    let (value, u) = (squareness.value * 1e6, squareness.u.unwrap() * 1e6);
    // By hand: least-squares slope of the guide within ±h, h = 150 mm: 1.5 µm/240 mm (2.5 · 3/5 (150/240)² − 1.5) = −5.71 µrad.
    let within_circle = 30.0 + 5.71;
    assert!((value - within_circle).abs() <= 2.0 * u, "{value} ± {u}, within the circle {within_circle}");
    assert!(u < 1.5, "the doubt within the circle is no excuse: {u}");
    assert!(
        found.notes.iter().any(|note| note.contains("a table gives what else may read")),
        "{:?}",
        found.notes
    );
    let [u_shown, with_it, _, over_travel] = doubt(&found, "EC0Y", "EYX.P3 (straightness:X)");
    near(u_shown, u, 1e-9, "u of the table");
    near(with_it, within_circle, 0.5, "value with the S-shape");
    assert!((value - 30.0).abs() <= over_travel, "{value}, 30 over ±240 mm, doubt {over_travel}");
    let share = &found.value("XY unexplained share").unwrap().note;
    assert!(share.contains("straightness") && share.contains("shows in it"), "{share}");
    assert!(
        found.notes.iter().any(|note| note.contains("what the list leaves looks like")),
        "{:?}",
        found.notes
    );
}

#[test]
fn guides_that_together_leave_nothing_are_said_to_be_confounded() {
    // S-shapes of both guides, alike: the four waves a turn cancel, the squareness takes all.
    let s_shape = |s: f64| 2.0 * UM * (5.0 * s.powi(3) - 3.0 * s) / 2.0;
    let both = |s: &State| (s_shape(s.position[Y] / R_MM), s_shape(s.position[X] / R_MM));
    let found = circular(circle(both, 0.0, false));
    let squareness = found.value("XY EC0Y").unwrap();
    assert!(squareness.value.abs() > 5e-6 && value(&found, "XY unexplained share") < 1e-3, "{squareness:?}");
    let scale = &found.value("XY scale X−Y").unwrap().note;
    assert!(!scale.contains("together"), "an S-shape takes nothing of the scale: {scale}");
    let of_both = squareness.note.split(';').find(|part| part.contains("together")).expect("named");
    assert!(of_both.contains("EYX.P3") && of_both.contains("EXY.P3"), "{}", squareness.note);
}

#[test]
fn straight_guides_widen_nothing() {
    let found = circular(circle(|s| (-30e-6 * s.position[Y], 0.0), 0.3, false));
    let squareness = found.value("XY EC0Y").unwrap();
    assert!(squareness.u.unwrap() < 0.3e-6, "{squareness:?}");
    assert!(!found.value("XY unexplained share").unwrap().note.contains("shows in it"));
    let [.., over_travel] = doubt(&found, "EC0Y", "EYX.P3 (straightness:X)");
    assert!(over_travel > 1.0, "what the circle does not bound is given all the same: {over_travel}");
}
