//! Lengths of a laser next to positions that are no targets.

use crate::mistakes::Files;

const STATIONS: usize = 11;
const PASSES: usize = 10;

/// A linear axis with a scale error, a reversal and noise: positions by row from its target and from what a laser read, mm.
fn laser(position: impl Fn(usize, f64, f64) -> f64) -> Files {
    let row = |row: usize| {
        let (pass, at) = (row / STATIONS, row % STATIONS);
        let station = if pass.is_multiple_of(2) { at } else { STATIONS - 1 - at };
        let target = -180.0 + 36.3 * station as f64;
        let reversal = if pass.is_multiple_of(2) { 0.0 } else { 0.003 };
        let noise = 3e-4 * (row as f64 * 12.9898).sin();
        let read = (1.0 + 30e-6) * (target + 180.0) + reversal + noise + 1.2345;
        let position = position(row, target, read);
        [
            "x".into(),
            (3 * row).to_string(),
            format!("{position:.3}"),
            "0".into(),
            "100".into(),
            format!("{read:.6}"),
        ]
        .into()
    };
    let header = ["setup", "time_s", "x_mm", "y_mm", "z_mm", "l_mm"].map(String::from).into();
    let setup = "format = \"trunnion-points/1\"\nmachine = \"three-axis\"\n[[setup]]\nname = \"x\"\ninstrument = \"diagonal\"\n\
                 ball_in_table_mm = [-180, 0, 100]\ndirection = [1, 0, 0]\n";
    Files { header, rows: (0..STATIONS * PASSES).map(row).collect(), setup: setup.into() }
}

#[test]
fn positions_that_are_the_readings_are_no_targets() {
    let found = laser(|_, _, read| read - 180.0).open().check().plausibility;
    let [one] = &found[..] else { panic!("{found:?}") };
    assert!(
        one.finding.contains("the positions of setup x do not come back to their targets: at 11 of 11"),
        "{}",
        one.finding
    );
    assert!(one.hypothesis.contains("the positions that the program asked for"), "{}", one.hypothesis);
}

#[test]
fn targets_and_positions_of_an_encoder_next_to_them_raise_no_doubt() {
    assert_eq!(laser(|_, target, _| target).open().check().plausibility, []);
    let encoder = |row: usize, target: f64, _| target + 6e-4 * (row as f64 * 78.233).sin();
    assert_eq!(laser(encoder).open().check().plausibility, []);
}
