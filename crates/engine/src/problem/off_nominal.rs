//! What the columns of a design would be if every axis stood a little off its position.
//!
//! Recorded positions are off the commanded ones by micrometres. What those alone make visible, the cycle does not show: a
//! direction v is seen by the nominal cycle when ‖A v‖ is larger than ‖ΔA v‖, ΔA the change of the columns for positions off by
//! [`OFF_MM`] and [`OFF_RAD`], signs by chance.
//! Limits: real scatter is at most half as large; structure finer than 10 µm of travel counts as scatter.

use crate::Experiment;
use crate::problem::side_by_side::SideBySide;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use trunnion_core::Slot;

/// Twice the scatter of a poor servo, 5 µm: a direction that scatter alone makes visible then stays below by a factor of two.
pub(crate) const OFF_MM: f64 = 10e-3;
/// The same at a radius of 200 mm.
const OFF_RAD: f64 = 50e-6;
/// So many points show how large a change is.
const ENOUGH_POINTS: usize = 1024;

/// ΔAᵀΔA over all points, rows weighted by `root`. `columns`: A, weighted, where it is at hand.
pub(crate) fn gram(
    experiment: &Experiment,
    joint: &SideBySide,
    root: &DVector<f64>,
    columns: Option<&DMatrix<f64>>,
) -> DMatrix<f64> {
    let width = joint.width();
    let mut gram = DMatrix::zeros(width, width);
    let step = experiment.points.len().div_ceil(ENOUGH_POINTS).max(1);
    for i in (0..experiment.points.len()).step_by(step) {
        let off = |i: usize| {
            let mut state = experiment.points[i].state.clone();
            for slot in Slot::ALL {
                let size = if slot.is_rotary() { OFF_RAD } else { OFF_MM };
                state.position[slot] += size * sign(i, slot.index());
            }
            Cow::Owned(state)
        };
        let rows = experiment.rows_of(i);
        let weighted = |mut columns: DMatrix<f64>| {
            for (k, row) in rows.clone().enumerate() {
                columns.row_mut(k).scale_mut(root[row]);
            }
            columns
        };
        let mut change = weighted(joint.columns_at(experiment, &off, i..i + 1));
        match columns {
            Some(columns) => change -= columns.rows_range(rows.clone()),
            None => change -= weighted(joint.columns(experiment, i..i + 1)),
        }
        gram.gemm_tr(step as f64, &change, &change, 1.0);
    }
    gram
}

/// +1 or −1 by chance, the same on every computer (splitmix64).
fn sign(point: usize, slot: usize) -> f64 {
    let seed = (point as u64) << 8 | slot as u64;
    let z = seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    if (z ^ (z >> 31)) >> 63 == 0 { 1.0 } else { -1.0 }
}
