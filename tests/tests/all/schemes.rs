//! The schemes over many seeds: the table of docs/measured/schemes.md, and one of its cells.

use trunnion_tests::schemes::rows::rows;
use trunnion_tests::schemes::{NoiseKind, SECTION, Tried, trial};
use trunnion_tests::section::Section;
use trunnion_tests::workspace_root;

#[test]
fn every_scheme_has_its_line_of_seeds() {
    let document = std::fs::read_to_string(workspace_root().join("docs/measured/schemes.md")).unwrap();
    let section = Section::of(&document, SECTION).unwrap();
    // Without the two lines of the head.
    let schemes: Vec<&str> =
        section.inside.lines().skip(2).map(|line| line.split(" | ").next().unwrap()).collect();
    let expected: Vec<String> = rows().map(|row| format!("| {}", row.scheme)).collect();
    assert_eq!(schemes, expected, "run schemes-trial -- --write");
}

/// A row that has a fair u in both noises and takes seconds; the others are in the table.
#[test]
fn standard_uncertainties_of_a_laser_ball_bar_are_fair_under_drift() {
    let row = rows().find(|row| row.cycle == "laser-ball-bar").unwrap();
    let found = (1..=10).flat_map(|seed| trial(row, NoiseKind::DriftAndSteps, seed).unwrap()).collect();
    let tried = Tried { found, failed: 0 };
    // 60 numbers: rms z of a normal distribution is within 0.72 and 1.28 in 998 of 1000 cases (chi-squared, 60 degrees of freedom).
    assert!((0.72..=1.28).contains(&tried.rms_z()), "{}", tried.rms_z());
}

/// Recipes whose readings show little of the drift between setups: intervals by the scatter within a pass held 18 to 74 % of these.
#[test]
fn intervals_of_recipes_hold_what_they_say_under_drift() {
    for (cycle, method) in [("s4-c", "ball-bar"), ("s4-b", "ball-bar"), ("two-height-c", "two-height")] {
        let row = rows().find(|row| row.cycle == cycle && row.method == Some(method)).unwrap();
        let found: Vec<_> =
            (1..=8).flat_map(|seed| trial(row, NoiseKind::DriftAndSteps, seed).unwrap()).collect();
        let location: Vec<_> = found.iter().filter(|found| !found.name.contains("range")).collect();
        let held = location.iter().filter(|found| (found.value - found.expected).abs() <= 1.96 * found.u);
        let held = held.count() as f64 / location.len() as f64;
        // 32 numbers, those of one run alike: 95 % of 16 independent ones are 81 % or more in 97 of 100 cases (binomial).
        assert!(held >= 0.81, "{method}, {cycle}: {held}");
    }
}
