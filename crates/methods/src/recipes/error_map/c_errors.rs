//! Errors of the turning axis at each pose from what the tilting axis leaves [S1 eq. 16–22].
//!
//! In the axes of what carries the turning axis: tilts ω = (α, β, 0) from the differences between nest positions,
//! `e_s − ē = ω × (ρ_s − ρ̄)`, then `δ = ē − ω × ρ̄`. The rotation about the axis itself is taken as zero.

use super::b_errors::BErrors;
use super::grid::{Cell, Grid};
use nalgebra::{Matrix2, Vector2, Vector3};
use trunnion_core::Twist;

/// Errors of the turning axis.
pub(super) struct CErrors {
    /// `at[tilt][turn]`; `None` where a nest position is missing.
    pub at: Vec<Vec<Option<Twist>>>,
    /// What is left of every reading, table axes, mm.
    pub residual_mm: Vec<Vector3<f64>>,
}

impl CErrors {
    pub fn of(grid: &Grid<'_>, b_errors: &BErrors) -> Self {
        let mut errors = Self { at: Vec::new(), residual_mm: Vec::new() };
        for tilt in 0..grid.tilts_rad.len() {
            let mut of_tilt = vec![None; grid.turns_rad.len()];
            let left: Vec<_> = grid.at_tilt(tilt).zip(&b_errors.residual_mm[tilt]).collect();
            for turn in 0..grid.turns_rad.len() {
                let here: Vec<(&Cell, Vector3<f64>)> = left
                    .iter()
                    .filter(|((j, ..), _)| *j == turn)
                    .map(|((.., cell), left)| (*cell, **left))
                    .collect();
                of_tilt[turn] = grid.has_all(tilt, turn).then(|| at_pose(grid, &here)).flatten();
                let twist = of_tilt[turn].unwrap_or_default();
                errors.residual_mm.extend(here.iter().map(|(cell, left)| left - cell.of_turning(&twist)));
            }
            errors.at.push(of_tilt);
        }
        errors
    }
}

/// `None` when the nest positions lie on one line along which no tilt is seen.
fn at_pose(grid: &Grid<'_>, here: &[(&Cell, Vector3<f64>)]) -> Option<Twist> {
    let along = grid.turning.index() % 3;
    let across = [(along + 1) % 3, (along + 2) % 3].map(|k| Vector3::<f64>::ith(k, 1.0));
    let in_carrier = |(cell, left): &(&Cell, Vector3<f64>)| {
        let carrier_from_machine = cell.turning.machine_from_carrier.inverse();
        let moved = -(carrier_from_machine * (cell.machine_from_table * left));
        let arm = carrier_from_machine * (cell.nest_in_machine_mm - cell.turning.origin_in_machine_mm);
        (moved, arm)
    };
    let places: Vec<(Vector3<f64>, Vector3<f64>)> = here.iter().map(in_carrier).collect();
    let count = places.len() as f64;
    let moved_mean = places.iter().map(|p| p.0).sum::<Vector3<f64>>() / count;
    let arm_mean = places.iter().map(|p| p.1).sum::<Vector3<f64>>() / count;
    let (mut normal, mut right) = (Matrix2::<f64>::zeros(), Vector2::<f64>::zeros());
    for (moved, arm) in &places {
        let columns = across.map(|unit| unit.cross(&(arm - arm_mean)));
        for k in 0..2 {
            right[k] += columns[k].dot(&(moved - moved_mean));
            for l in 0..2 {
                normal[(k, l)] += columns[k].dot(&columns[l]);
            }
        }
    }
    let tilts = normal.try_inverse()? * right;
    let omega = across[0] * tilts[0] + across[1] * tilts[1];
    Some(Twist { translation_mm: moved_mean - omega.cross(&arm_mean), rotation_rad: omega })
}
