//! Several planes together: an axis is in two of three planes, so its backlash is seen twice, and scale and servo mismatches close.
//!
//! Unknowns: scale and lag of each axis less the mean of all axes, backlash of each axis; readings: what each plane gave,
//! weighted by 1/u². Where planes disagree by more than their uncertainties, the list lacks something.

use super::fit::Fitted;
use super::list::ListedKind;
use nalgebra::{DMatrix, DVector};
use trunnion_core::Joint;
use trunnion_effects::Unit;
use trunnion_engine::solve::linear::least_squares;

/// One value of the machine from all planes.
pub(super) struct Together {
    pub name: String,
    pub unit: Unit,
    pub value: f64,
    /// Standard uncertainty, widened by the disagreement of the planes.
    pub u: f64,
    /// Largest difference between a plane and the common value, inside units.
    pub disagreement: f64,
    /// How many planes say something of it.
    pub planes: usize,
}

/// What one plane says: factor of each axis, value, u.
struct Said {
    factors: [f64; 3],
    value: f64,
    u: f64,
}

/// Backlash of each axis, scale and servo mismatches between axes; empty for one plane.
pub(super) fn together(fits: &[Fitted<'_>]) -> Vec<Together> {
    if fits.len() < 2 {
        return Vec::new();
    }
    let mut found = Vec::new();
    let backlash = |kind, plane: [Joint; 2]| match kind {
        ListedKind::Backlash(k) => Some(unit_factor(plane[k])),
        _ => None,
    };
    for letter in Joint::LINEAR {
        found.extend(solve(
            &said(fits, backlash),
            unit_factor(letter),
            format!("backlash {letter}"),
            Unit::UM,
        ));
    }
    let difference = |plane: [Joint; 2]| {
        let (a, b) = (unit_factor(plane[0]), unit_factor(plane[1]));
        [0, 1, 2].map(|k| a[k] - b[k])
    };
    let scale = |kind, plane| (kind == ListedKind::ScaleMismatch).then(|| difference(plane));
    let servo = |kind, plane| (kind == ListedKind::ServoMismatch).then(|| difference(plane));
    for [a, b] in [[Joint::X, Joint::Y], [Joint::Y, Joint::Z], [Joint::Z, Joint::X]] {
        found.extend(solve(&said(fits, scale), difference([a, b]), format!("scale {a}−{b}"), Unit::UM_PER_M));
        found.extend(solve(&said(fits, servo), difference([a, b]), format!("servo {a}−{b}"), Unit::MS));
    }
    found
}

fn unit_factor(letter: Joint) -> [f64; 3] {
    let mut factors = [0.0; 3];
    factors[letter.index()] = 1.0;
    factors
}

fn said(fits: &[Fitted<'_>], factors: impl Fn(ListedKind, [Joint; 2]) -> Option<[f64; 3]>) -> Vec<Said> {
    let mut all = Vec::new();
    for fit in fits {
        for error in &fit.errors {
            if let Some(factors) = factors(error.listed.kind, fit.trace.plane) {
                all.push(Said { factors, value: error.value, u: error.u });
            }
        }
    }
    all
}

/// `wanted` · unknowns, when the planes determine it.
fn solve(said: &[Said], wanted: [f64; 3], name: String, unit: Unit) -> Option<Together> {
    let largest_u = said.iter().map(|s| s.u).fold(0.0, f64::max);
    // Readings that the lists explain to rounding have no u: all planes weigh the same.
    let is_exact = largest_u == 0.0;
    let floor = if is_exact { 1.0 } else { largest_u * 1e-3 };
    let weight = |s: &Said| 1.0 / s.u.max(floor);
    let a = DMatrix::from_fn(said.len(), 3, |i, k| said[i].factors[k] * weight(&said[i]));
    let b = DVector::from_fn(said.len(), |i, _| said[i].value * weight(&said[i]));
    // Determined: the wanted combination is one of the rows.
    let factors = DVector::from_row_slice(&wanted);
    let rows = a.transpose();
    let reached = &rows * least_squares(&rows, &factors, 1e-6).x;
    if said.is_empty() || (reached - &factors).norm() > 1e-6 {
        return None;
    }
    let fit = least_squares(&a, &b, 1e-6);
    let left = (&b - &a * &fit.x).norm();
    let freedom = said.len().saturating_sub(fit.rank);
    let least = if is_exact { 0.0 } else { 1.0 };
    let widened = if freedom > 0 { (left / (freedom as f64).sqrt()).max(least) } else { least };
    let variance = (factors.transpose() * &fit.cofactor * &factors)[(0, 0)];
    let apart = |s: &Said| (s.value - (0..3).map(|k| s.factors[k] * fit.x[k]).sum::<f64>()).abs();
    let about = |s: &&Said| (0..3).any(|k| s.factors[k] != 0.0 && wanted[k] != 0.0);
    Some(Together {
        name,
        unit,
        value: factors.dot(&fit.x),
        u: variance.max(0.0).sqrt() * widened,
        disagreement: said.iter().filter(about).map(apart).fold(0.0, f64::max),
        planes: said.iter().filter(about).count(),
    })
}
