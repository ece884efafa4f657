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
