//! Good runs that resemble a mistake: a display coarser than the noise, a slip of the ball, play of an axis.

use crate::mistakes::{Files, READINGS};

const SEEDS: u64 = 30;

/// Numbers that are the same in every run of the test.
struct Chance(u64);

impl Chance {
    /// From 0 to 1.
    fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Of a standard normal distribution [Box–Muller].
    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.even()).ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos()
    }
}

/// A machine without errors behind a display: noise alone, and where the ball was set.
fn quiet(step_um: f64, noise_um: f64, chance: &mut Chance) -> Files {
    let mut files = Files::committed("points-nothing-hidden");
    for name in READINGS {
        let (column, set_um) = (files.column(name), 2.0 * chance.normal());
        for row in &mut files.rows {
            let um = set_um + noise_um * chance.normal();
            row[column] = format!("{:.3}", (um / step_um).round() * step_um);
        }
    }
    files
}

#[test]
fn a_display_coarser_than_the_noise_of_a_machine_without_errors_raises_no_doubt() {
    for (step_um, noise_um) in [(1.0, 0.5), (0.5, 0.3), (1.0, 0.25), (0.5, 0.15), (2.0, 0.8)] {
        for seed in 0..SEEDS {
            let found = quiet(step_um, noise_um, &mut Chance(seed)).open().check().plausibility;
            assert_eq!(found, [], "{step_um} µm over {noise_um} µm, seed {seed}");
        }
    }
}

#[test]
fn rows_that_hold_the_readings_before_are_named_behind_such_a_display() {
    for seed in 0..SEEDS {
        let mut files = quiet(0.5, 0.5, &mut Chance(seed));
        let columns = READINGS.map(|name| files.column(name));
        for row in (2..files.rows.len()).step_by(3) {
            columns
                .into_iter()
                .for_each(|column| files.rows[row][column] = files.rows[row - 1][column].clone());
        }
        let found = files.open().check().plausibility;
        assert!(
            found.iter().any(|one| one.finding.contains("those of the row before")),
            "seed {seed}: {found:?}"
        );
    }
}

/// Few poses and small errors: location errors of a part of the run imitate a slip.
#[test]
fn a_slip_of_the_ball_is_no_other_state_of_the_machine() {
    for seed in 0..SEEDS {
        let mut chance = Chance(seed);
        let mut files = quiet(0.001, 0.15, &mut chance);
        files.rows = files.rows.into_iter().skip(seed as usize % 3).step_by(5).collect();
        let slips = 15 + (chance.even() * (files.rows.len() - 30) as f64) as usize;
        for name in READINGS {
            let (column, by_um) = (files.column(name), 6.0 * chance.normal());
            for row in &mut files.rows[slips..] {
                row[column] = format!("{:.3}", row[column].parse::<f64>().unwrap() + by_um);
            }
        }
        assert_eq!(files.open().check().plausibility, [], "seed {seed}, row {slips}");
    }
}

/// Poses that were approached from both sides are no repeats of one another.
#[test]
fn play_of_an_axis_that_comes_from_either_side_is_no_scatter_and_no_loose_probe() {
    for seed in 0..SEEDS {
        for name in READINGS {
            let mut chance = Chance(seed);
            let mut files = quiet(0.001, 0.2, &mut chance);
            let [way, column] = ["direction_c", name].map(|name| files.column(name));
            for row in &mut files.rows {
                let side = if chance.even() < 0.5 { -1.0 } else { 1.0 };
                row[way] = format!("{side}");
                row[column] = format!("{:.3}", row[column].parse::<f64>().unwrap() + 9.0 * side);
            }
            assert_eq!(files.open().check().plausibility, [], "{name}, seed {seed}");
        }
    }
}
