//! Held-out error: each unit predicted by the fit to the others.
//!
//! For each unit q the change δ of the fit without q follows from the normal equations of the other units; the residual of q
//! with it is r_q − A_q δ. Directions that only q sees (its own ball setting) keep the value of the full fit. A unit of which
//! the others see no direction is not predicted by them and does not count; `None` when fewer than two do.
//!
//! Of effects that were added, what the others see but hardly know is predicted to be nothing: their values have a prior about zero that is worth
//! one reading [Wasserman 1995], (G_o + K) δ = g_o − K θ with K the information of all units on them, the other parameters
//! projected out, over the number of rows.

use crate::fit::identification::Holdout;
use crate::fit::uncertainty::Sums;
use crate::solve::linear::Reduced;
use nalgebra::{DMatrix, DVector};

/// Relative singular value of the other units below which they do not see a direction.
const UNSEEN: f64 = 1e-6;
/// Share of a direction of the other units below which a unit does not depend on it.
const APART: f64 = 1e-9;

/// K and K θ: what the values of the effects that were added are worth beforehand.
struct Beforehand {
    information: DMatrix<f64>,
    pull: DVector<f64>,
}

impl Beforehand {
    /// `added`: columns of the normal equations that belong to such effects, with their values.
    fn new(sums: &Sums, added: &[(usize, f64)]) -> Option<Self> {
        let width = sums.units.first()?.score.len();
        let all = sums.units.iter().fold(DMatrix::zeros(width, width), |all, unit| all + &unit.gram);
        let rows: usize = sums.units.iter().map(|unit| unit.rows).sum();
        let (mut information, mut values) = (DMatrix::zeros(width, width), DVector::zeros(width));
        if !added.is_empty() {
            let own: Vec<usize> = added.iter().map(|(column, _)| *column).collect();
            // T Tᵀ is the covariance with all parameters free.
            let turn = Reduced::from_gram(&all).orthonormal(UNSEEN).select_rows(&own);
            let seen = Reduced::from_gram(&(&turn * turn.transpose())).orthonormal(UNSEEN);
            let of_added = &seen * seen.transpose() / rows as f64;
            for (a, &(i, value)) in added.iter().enumerate() {
                values[i] = value;
                added.iter().enumerate().for_each(|(b, &(j, _))| information[(i, j)] = of_added[(a, b)]);
            }
        }
        let pull = &information * values;
        Some(Self { information, pull })
    }
}

/// Root mean square of units predicted from the others, unweighted. `added`: columns of the normal equations that belong to effects which were added to
/// a model of location errors and settings, with their values.
pub(crate) fn holdout(sums: &Sums, added: &[(usize, f64)]) -> Option<Holdout> {
    let beforehand = Beforehand::new(sums, added)?;
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
            if seen.tr_mul(&(&unit.gram * &seen)).trace() <= APART {
                continue;
            }
            let prior = seen.tr_mul(&(&beforehand.information * &seen));
            let known = DMatrix::identity(seen.ncols(), seen.ncols()) + prior;
            let change = known.cholesky()?.solve(&seen.tr_mul(&(score - &beforehand.pull)));
            seen * change
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
