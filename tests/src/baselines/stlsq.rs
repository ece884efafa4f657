//! Sequentially thresholded least squares [Brunton 2016].
//!
//! x = argmin ‖y − A x‖² + α ‖x‖²; columns with |x_j| < λ are dropped and the rest is fitted again until none drops. λ by BIC over a
//! grid from keeping nearly all columns to keeping none; α = 0.05 as in PySINDy.

use super::problem::{Baseline, Problem};

pub const BASELINE: Baseline = Baseline { name: "STLSQ, threshold by BIC", chosen };

/// α, PySINDy's default.
const RIDGE: f64 = 0.05;
/// λ in units of the rms of the readings: falling geometrically.
const THRESHOLDS: usize = 24;
const LARGEST: f64 = 2.0;
const SMALLEST: f64 = 0.03;
/// A round that drops nothing ends it; so many are never needed.
const MOST_ROUNDS: usize = 20;

fn chosen(problem: &Problem) -> Vec<usize> {
    let rms = (problem.squares / problem.rows as f64).sqrt();
    let ridge = RIDGE / problem.rows as f64;
    let all: Vec<usize> = (0..problem.score.len()).collect();
    let full = problem.solve(&all, ridge);
    let mut best = (problem.bic(&[]), Vec::new());
    for step in 0..THRESHOLDS {
        let share = step as f64 / (THRESHOLDS - 1) as f64;
        let threshold = rms * LARGEST * (SMALLEST / LARGEST).powf(share);
        let mut kept: Vec<usize> = all.iter().copied().filter(|&j| full[j].abs() >= threshold).collect();
        for _ in 0..MOST_ROUNDS {
            let x = problem.solve(&kept, ridge);
            let next: Vec<usize> =
                kept.iter().zip(x.iter()).filter(|(_, x)| x.abs() >= threshold).map(|(&j, _)| j).collect();
            if next.len() == kept.len() {
                break;
            }
            kept = next;
        }
        let bic = problem.bic(&kept);
        if bic < best.0 {
            best = (bic, kept);
        }
    }
    best.1
}
