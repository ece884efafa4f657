//! Held-out error: each unit predicted by the fit to the others.
//!
//! For each unit q the change δ of the fit without q follows from the normal equations of the other units; the residual of q
//! with it is r_q − A_q δ. Directions that only q sees (its own ball setting), or that the others know so badly that their noise alone would
//! outweigh that of q, keep the value of the full fit. A unit of which
//! the others see no direction is not predicted by them and does not count; `None` when fewer than two do.

use crate::fit::identification::Holdout;
use crate::fit::uncertainty::Sums;
use crate::solve::linear::Reduced;
use nalgebra::{DMatrix, DVector};

/// Relative singular value of the other units below which they do not see a direction.
const UNSEEN: f64 = 1e-6;
/// Share of a direction of the other units below which a unit does not depend on it.
const APART: f64 = 1e-9;

/// The directions of what the others see in which they foretell a unit of so many rows, from its Gram matrix there. Where it knows a direction μ times as well
/// as they do, their noise alone adds μ σ² to the squares of its rows: beyond μ = rows, more than those have of their own.
fn foretold(gram: DMatrix<f64>, rows: usize) -> DMatrix<f64> {
    let eigen = ((&gram + gram.transpose()) * 0.5).symmetric_eigen();
    let known: Vec<usize> = (0..gram.ncols()).filter(|&i| eigen.eigenvalues[i] <= rows as f64).collect();
    eigen.eigenvectors.select_columns(&known)
}

/// Root mean square of units predicted from the others, unweighted.
pub(crate) fn holdout(sums: &Sums) -> Option<Holdout> {
    let (mut squares, mut rows, mut predicted) = (0.0, 0, 0);
    for (q, unit) in sums.units.iter().enumerate() {
        let width = unit.score.len();
        let (mut gram, mut score) = (DMatrix::zeros(width, width), DVector::zeros(width));
        for (_, other) in sums.units.iter().enumerate().filter(|(k, _)| *k != q) {
            gram += &other.gram;
            score += &other.score;
        }
        let change = if width > 0 {
            // Orthonormal directions of what the others see.
            let seen = Reduced::from_gram(&gram).orthonormal(UNSEEN);
            let mine = seen.tr_mul(&(&unit.gram * &seen));
            if mine.trace() <= APART {
                continue;
            }
            let seen = seen * foretold(mine, unit.rows);
            &seen * seen.tr_mul(&score)
        } else {
            score
        };
        let (gram, score, of_unit) = unit.unweighted(sums.even);
        let left = of_unit - 2.0 * change.dot(score) + change.dot(&(gram * &change));
        squares += left.max(0.0);
        rows += unit.rows;
        predicted += 1;
    }
    (predicted > 1).then(|| Holdout {
        rms_mm: (squares / rows as f64).sqrt(),
        left_out: sums.left_out,
        parts: predicted,
    })
}
