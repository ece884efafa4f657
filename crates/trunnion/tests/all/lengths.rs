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

/// Targets with two decimals, each met once, some of them near each other.
#[test]
fn targets_that_are_met_once_need_not_come_back() {
    for seed in 0..20 {
        let files = laser(|row, _, _| {
            let share = ((row + 110 * seed) as f64 * 0.618_033_988_75 * (1.0 + seed as f64)).fract();
            // Drawn near the last one here and there, as among many targets.
            (100.0 * (-180.0 + 360.0 * (share * 1_013.0).fract())).round() / 100.0
        });
        let mut files = files;
        let [x, l] = ["x_mm", "l_mm"].map(|name| files.column(name));
        let mut before_mm = 0.0;
        for (k, row) in files.rows.iter_mut().enumerate() {
            let mut target_mm: f64 = row[x].parse().unwrap();
            if k % 9 == 8 {
                target_mm = before_mm + 0.03 + 0.01 * (k % 5) as f64;
            }
            before_mm = target_mm;
            row[x] = format!("{target_mm:.2}");
            row[l] = format!("{:.6}", target_mm + 180.0 + 1e-3 * (k as f64 * 12.9898).sin());
        }
        assert_eq!(files.open().check().plausibility, [], "seed {seed}");
    }
}

/// There and back, and only the turning point is read twice from one side: its two readings differ by 3 µm.
#[test]
fn one_pose_that_is_read_twice_shows_no_lost_counts() {
    let mut files = laser(|_, target, _| target);
    files.rows.truncate(2 * STATIONS);
    files.header.push("direction_x".into());
    let l = files.column("l_mm");
    for (k, row) in files.rows.iter_mut().enumerate() {
        row.push(if k <= STATIONS { "1" } else { "-1" }.into());
        if k >= STATIONS {
            row[l] = format!("{:.6}", row[l].parse::<f64>().unwrap() + 0.005);
        }
    }
    assert_eq!(files.open().check().plausibility, []);
}

/// A tracker reads the way from its station, which is set anywhere: no base model makes anything of it.
#[test]
fn distances_from_stations_are_not_asked_whether_they_fit_their_positions() {
    let corners =
        [[320.0, 320.0, -320.0], [-320.0, 320.0, -330.0], [-320.0, -320.0, -310.0], [330.0, -310.0, 250.0]];
    let header = ["setup", "time_s", "x_mm", "y_mm", "z_mm", "l_mm"].map(String::from).into();
    let mut setup = "format = \"trunnion-points/1\"\nmachine = \"three-axis\"\n".to_owned();
    let mut rows = Vec::new();
    for (s, corner) in corners.into_iter().enumerate() {
        setup += &format!(
            "[[setup]]\nname = \"s{s}\"\ninstrument = \"tracker\"\nball_in_table_mm = {corner:?}\nball_in_tool_mm = [0.0, 0.0, -60.0]\n"
        );
        for k in 0..60 {
            let at = [0.754_877, 0.569_84, 0.438_3]
                .map(|share| -150.0 + 300.0 * (share * f64::from(k + 1)).fract());
            let square = |i: usize| (at[i] + [0.0, 0.0, -60.0][i] - corner[i]).powi(2);
            let read = (square(0) + square(1) + square(2)).sqrt() + 3e-4 * (f64::from(k) * 12.9898).sin();
            let mut row = vec![format!("s{s}"), (rows.len() * 3).to_string()];
            row.extend(at.map(|mm| format!("{mm:.5}")));
            row.push(format!("{read:.6}"));
            rows.push(row);
        }
    }
    let files = Files { header, rows, setup };
    assert_eq!(files.open().check().plausibility, []);
}
