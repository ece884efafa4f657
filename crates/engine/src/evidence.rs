//! Evidence of columns against nothing at one covariance of the noise (docs/design/statistics.md §2).
//!
//! Columns of a block are turned to be orthogonal with unit rms over the readings; β ~ N(0, τ²I), τ/s averaged over eight doublings.
//! With G = AᵀPA = E Λ Eᵀ and z = EᵀAᵀPy:
//!
//! ln B(τ) = −½ Σ ln(1 + τ²λ_i) + ½ Σ τ² z_i² / (1 + τ²λ_i)
//!
//! P has the columns of the model projected out: a direction that the model imitates has λ ≈ 0 and adds nothing.

mod algebra;
mod best_set;
mod of_gram;

pub use algebra::{joined, off, orthonormal, parallel, turned};
pub use best_set::{BestSet, best_set};
pub use of_gram::{Evidence, evidence_of_gram};

use crate::noise::learned::Real;
use crate::noise::learned::sigma::Projected;
use nalgebra::DMatrix;

/// Blocks of turned columns side by side, each of its width.
pub fn evidence_of_each(here: &Projected, columns: &DMatrix<Real>, widths: &[usize]) -> Vec<Evidence> {
    evidence_of_grams(here, columns, &here.grams(columns, widths))
}

/// The same where AᵀPA of the blocks is known.
pub fn evidence_of_grams(here: &Projected, columns: &DMatrix<Real>, grams: &[DMatrix<f64>]) -> Vec<Evidence> {
    let on_readings = columns.tr_mul(&here.py).cast::<f64>();
    let white = here.sigma.white;
    let mut first = 0;
    let of_block = |gram: &DMatrix<f64>| {
        let of_block = on_readings.rows(first, gram.ncols()).into_owned();
        first += gram.ncols();
        if gram.is_empty() { Evidence::NOTHING } else { evidence_of_gram(gram, &of_block, white) }
    };
    grams.iter().map(of_block).collect()
}

/// One block of turned columns.
pub fn evidence_of(here: &Projected, columns: &DMatrix<f64>) -> Evidence {
    evidence_of_each(here, &columns.map(|x| x as Real), &[columns.ncols()])[0]
}
