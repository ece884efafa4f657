//! Errors of the turning axis at each pose from what the tilting axis leaves [S1 eq. 16–22].
//!
//! In the axes of what carries the turning axis: tilts ω = (α, β, 0) from the differences between nest positions,
//! `e_s − ē = ω × (ρ_s − ρ̄)`, then `δ = ē − ω × ρ̄`. The rotation about the axis itself is taken as zero.
//! u by propagation of one mean reading: the larger of what repeats say, and of what both maps leave with its degrees of freedom (5 at a
//! pose, 6 at a tilt are used up).

use super::b_errors::BErrors;
use super::grid::{Cell, Grid};
use nalgebra::{Matrix2, Vector2, Vector3};
use trunnion_core::Twist;

/// Errors of the turning axis.
pub(super) struct CErrors {
    /// `at[tilt][turn]`; `None` where a nest position is missing.
    pub at: Vec<Vec<Option<Twist>>>,
    /// Their standard uncertainties.
    pub u_at: Vec<Vec<Option<Twist>>>,
    /// What is left of every reading, table axes, mm.
    pub residual_mm: Vec<Vector3<f64>>,
}

impl CErrors {
    pub fn of(grid: &Grid<'_>, b_errors: &BErrors) -> Self {
        let (mut errors, mut leverages) =
            (Self { at: Vec::new(), u_at: Vec::new(), residual_mm: Vec::new() }, Vec::new());
        for tilt in 0..grid.tilts_rad.len() {
            let mut of_tilt = vec![None; grid.turns_rad.len()];
            let mut leverage = of_tilt.clone();
            let left: Vec<_> = grid.at_tilt(tilt).zip(&b_errors.residual_mm[tilt]).collect();
            for turn in 0..grid.turns_rad.len() {
                let here: Vec<(&Cell, Vector3<f64>)> = left
                    .iter()
                    .filter(|((j, ..), _)| *j == turn)
                    .map(|((.., cell), left)| (*cell, **left))
                    .collect();
                (of_tilt[turn], leverage[turn]) =
                    grid.has_all(tilt, turn).then(|| at_pose(grid, &here)).flatten().unzip();
                let twist = of_tilt[turn].unwrap_or_default();
                errors.residual_mm.extend(here.iter().map(|(cell, left)| left - cell.of_turning(&twist)));
            }
            errors.at.push(of_tilt);
            leverages.push(leverage);
        }
        let u_mm = errors.u_of_mean_mm(grid);
        let scaled = |leverage: Option<Twist>| leverage.map(|of_one_mm| of_one_mm * u_mm);
        errors.u_at =
            leverages.into_iter().map(|of_tilt| of_tilt.into_iter().map(scaled).collect()).collect();
        errors
    }

    /// Standard uncertainty of one component of the mean of a cell, mm.
    fn u_of_mean_mm(&self, grid: &Grid<'_>) -> f64 {
        let poses = self.at.iter().flatten().flatten().count();
        let freedom = (3 * self.residual_mm.len()).saturating_sub(5 * poses + 6 * grid.tilts_rad.len());
        let left: f64 = self.residual_mm.iter().map(Vector3::norm_squared).sum();
        let by_residual_mm = (left / freedom.max(1) as f64).sqrt();
        let all = || grid.cells.iter().flatten().flatten().flatten();
        let shares: f64 = all().map(|cell| 1.0 / cell.readings as f64).sum();
        let by_repeats_mm = grid.repeat_mm.unwrap_or(0.0) * (shares / all().count().max(1) as f64).sqrt();
        by_residual_mm.max(by_repeats_mm)
    }
}

/// The errors, and their standard uncertainties for one of 1 mm of each component of a reading; `None` when the nest positions lie on
/// one line along which no tilt is seen.
fn at_pose(grid: &Grid<'_>, here: &[(&Cell, Vector3<f64>)]) -> Option<(Twist, Twist)> {
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
    let cofactor = normal.try_inverse()?;
    let tilts = cofactor * right;
    let omega = across[0] * tilts[0] + across[1] * tilts[1];
    let turned = across.map(|unit| unit.cross(&arm_mean));
    let variance = |of: [f64; 2]| {
        let of = Vector2::from(of);
        (of.transpose() * cofactor * of)[(0, 0)]
    };
    let u = Twist {
        translation_mm: Vector3::from_fn(|k, _| {
            (1.0 / count + variance([turned[0][k], turned[1][k]])).sqrt()
        }),
        rotation_rad: Vector3::from_fn(|k, _| variance([across[0][k], across[1][k]]).sqrt()),
    };
    Some((Twist { translation_mm: moved_mean - omega.cross(&arm_mean), rotation_rad: omega }, u))
}
