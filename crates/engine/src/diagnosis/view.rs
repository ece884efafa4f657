//! The readings with some columns in the model: the noise learned with them, and what everything named scores there.

use crate::diagnosis::scan::Scan;
use crate::diagnosis::vocabulary::Term;
use crate::evidence::{Evidence, evidence_of, evidence_of_grams, joined, orthonormal, parallel};
use crate::noise::learned::Real;
use crate::noise::learned::mode::{Effort, Mode};
use crate::noise::learned::sigma::{Projected, Sigma};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// In a quiet noise every size is at most this share of the noise of a single reading: the learned noise may have swallowed an effect.
/// A judgement, as is the next: small enough to hide nothing worth a name, large enough for a covariance. They only choose what is looked at
/// again in the learned noise; no claim rests on them. Half and double were not tried.
const QUIET: f64 = 0.05;
/// And at least this much below what was learned, ln.
const QUIETER_LN: f64 = 1.5;
/// Share of a block's norm that the model must leave for the block to be visible.
const SURVIVAL: f64 = 0.03;

/// What was added to the model.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// Index of a named effect.
    Named(usize),
    /// Something without a name.
    Open(Term),
}

impl What {
    /// Index of a named effect.
    pub fn group(&self) -> Option<usize> {
        match self {
            Self::Named(group) => Some(*group),
            Self::Open(_) => None,
        }
    }
}

/// One addition with its columns.
#[derive(Clone, Debug)]
pub struct Item {
    pub what: What,
    /// Shape numbers.
    pub shape: Vec<f64>,
    /// Weighted, rows × columns.
    pub columns: DMatrix<f64>,
    /// ln odds when it was last scored, the others in the model.
    pub ln_odds: f64,
}

impl Item {
    pub fn is_open(&self) -> bool {
        matches!(self.what, What::Open(_))
    }
}

/// A named effect on its grid at the noise learned without it.
#[derive(Clone, Copy, Debug)]
pub struct OnGrid {
    /// At the learned noise: ln Bayes factor, shapes averaged; best shape among all parts.
    pub ln_bf: f64,
    pub part: usize,
    /// The same in a quiet noise.
    pub quiet_ln_bf: f64,
    pub quiet_part: usize,
    /// False where the model imitates all of it.
    pub visible: bool,
}

/// The readings with columns in the model.
pub struct View {
    /// Weighted, rows × columns.
    pub chosen: DMatrix<f64>,
    /// Orthonormal columns of the model with what was chosen.
    pub basis: DMatrix<Real>,
    /// The noise with nothing more.
    pub null: Mode,
    /// The same columns at a quiet noise.
    pub quiet: Projected,
    pub named: Vec<OnGrid>,
    /// AᵀPA of everything named, one for each shape.
    pub grams: Vec<DMatrix<f64>>,
    /// Noises of this scan, each once: with further columns in the model the noise may be near any of them.
    near: Vec<Arc<Sigma>>,
}

/// The noise learned with some columns in the model.
pub struct Relearned {
    /// With the columns in the model.
    pub mode: Mode,
    /// The same noise without them.
    pub alone: Projected,
    /// What this noise costs against that of nothing more, ln.
    pub offset_ln: f64,
}

impl View {
    /// `near`: noises that may be near by, each once.
    pub fn of(scan: &Scan<'_>, chosen: DMatrix<f64>, mut near: Vec<Arc<Sigma>>) -> Option<Self> {
        let readings = scan.readings();
        let basis = orthonormal(&joined(&scan.remainder.base, &chosen)).cast::<Real>();
        let null = if chosen.ncols() == 0 {
            scan.first.clone()
        } else {
            readings.learn(&basis, &near, Effort::AGAIN)?
        };
        let mut x = null.x().to_vec();
        for (x, mean) in x[1..].iter_mut().zip(scan.remainder.kernels.means()) {
            *x = (x.min((QUIET * scan.remainder.kernels.single).ln()) - QUIETER_LN).max((*x).min(mean - 1.0));
        }
        let quiet = Projected::new(readings.sigma(&x)?, &scan.remainder.y, &basis)?;
        let at = [&null.here, &quiet];
        let mut grams = parallel(at.len(), |i| at[i].grams(&scan.columns, &scan.widths));
        let [at_null, at_quiet] = [0, 1].map(|i| evidence_of_grams(at[i], &scan.columns, &grams[i]));
        let named = on_grid(scan, &basis, &at_null, &at_quiet);
        add_once(&mut near, &null.here.sigma);
        Some(Self { chosen, basis, null, quiet, named, grams: grams.swap_remove(0), near })
    }

    /// ln Bayes factor of turned columns at the learned noise or in a quiet one, whichever is larger.
    pub fn ln_bf(&self, columns: &DMatrix<f64>) -> f64 {
        evidence_of(&self.null.here, columns).ln_bf.max(evidence_of(&self.quiet, columns).ln_bf)
    }

    /// Learns the noise with columns in the model.
    pub fn relearned(&self, scan: &Scan<'_>, columns: &DMatrix<f64>) -> Option<Relearned> {
        let readings = scan.readings();
        let all = joined(&joined(&scan.remainder.base, &self.chosen), columns);
        let basis = orthonormal(&all).cast::<Real>();
        let mode = readings.learn(&basis, &self.near, Effort::AGAIN)?;
        let alone = Projected::new(mode.here.sigma.clone(), &scan.remainder.y, &self.basis)?;
        let offset_ln = readings.posterior(&alone) - 0.5 * mode.log_information - self.null.evidence();
        Some(Relearned { mode, alone, offset_ln })
    }

    /// Mean square in a reading of what turned columns explain, in units of the white variance.
    pub fn share(&self, scan: &Scan<'_>, noise: &Relearned, columns: &DMatrix<f64>) -> f64 {
        let fitted = fitted(&noise.alone, columns);
        let basis = self.basis.map(f64::from);
        let left = &fitted - &basis * basis.tr_mul(&fitted);
        left.norm_squared() / scan.remainder.y.len() as f64 / noise.mode.white().powi(2)
    }
}

/// A β̂ at a noise.
pub fn fitted(here: &Projected, columns: &DMatrix<f64>) -> DVector<f64> {
    let single = columns.map(|x| x as Real);
    let gram = here.grams(&single, &[columns.ncols()]).remove(0);
    let on_readings = single.tr_mul(&here.py).cast::<f64>();
    let eigen = ((&gram + gram.transpose()) * 0.5).symmetric_eigen();
    let least = 1e-4 * eigen.eigenvalues.amax();
    let inverse = eigen.eigenvalues.map(|x| if x > least { x.recip() } else { 0.0 });
    let values =
        &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.tr_mul(&on_readings);
    columns * values
}

/// Adds a noise where it is not among the others.
pub fn add_once(near: &mut Vec<Arc<Sigma>>, sigma: &Arc<Sigma>) {
    if !near.iter().any(|other| Arc::ptr_eq(other, sigma)) {
        near.push(sigma.clone());
    }
}

fn on_grid(
    scan: &Scan<'_>,
    basis: &DMatrix<Real>,
    at_null: &[Evidence],
    at_quiet: &[Evidence],
) -> Vec<OnGrid> {
    let on_basis = basis.transpose() * &scan.columns;
    let total = scan.remainder.y.len() as Real;
    let left: Vec<Real> =
        on_basis.column_iter().map(|shadow| (total - shadow.norm_squared()).max(0.0) / total).collect();
    let first_column: Vec<usize> = scan
        .widths
        .iter()
        .scan(0, |next, width| {
            *next += width;
            Some(*next - width)
        })
        .collect();
    let of_named = |named: &crate::diagnosis::scan::Named| {
        let best = |scores: &[Evidence]| {
            let own = &scores[named.parts.clone()];
            let ln: Vec<f64> = own.iter().map(|score| score.ln_bf).collect();
            let best = (0..own.len()).max_by(|&a, &b| ln[a].total_cmp(&ln[b])).unwrap_or(0);
            (named.averaged(&ln), named.parts.start + best)
        };
        let ((ln_bf, part), (quiet_ln_bf, quiet_part)) = (best(at_null), best(at_quiet));
        let visible = named.parts.clone().any(|part| {
            let columns = first_column[part]..first_column[part] + scan.widths[part];
            columns.into_iter().any(|column| left[column] > (SURVIVAL * SURVIVAL) as Real)
        });
        OnGrid { ln_bf, part, quiet_ln_bf, quiet_part, visible }
    };
    scan.named.iter().map(of_named).collect()
}

/// What turned columns say at a noise learned with some columns in the model: with its price against nothing more.
pub fn evidence_relearned(noise: &Relearned, columns: &DMatrix<f64>) -> Evidence {
    let plain = evidence_of(&noise.alone, columns);
    Evidence { ln_bf: plain.ln_bf + noise.offset_ln, fit_ln: plain.fit_ln + noise.offset_ln }
}

/// Columns of several items together.
pub fn columns_of<'a>(items: impl Iterator<Item = &'a Item>, rows: usize) -> DMatrix<f64> {
    items.fold(DMatrix::zeros(rows, 0), |all, item| joined(&all, &item.columns))
}
