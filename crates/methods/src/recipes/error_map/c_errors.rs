//! Errors of the turning axis at each pose from what the tilting axis leaves [S1 eq. 16–22].
//!
//! In the axes of what carries the turning axis: tilts ω = (α, β, 0) from the differences between nest positions,
//! `e_s − ē = ω × (ρ_s − ρ̄)`, then `δ = ē − ω × ρ̄`. The rotation about the axis itself is taken as zero.
//! u by propagation of one mean reading: the larger of what repeats say, and of what both maps leave at poses read in all N nest positions,
//! with ν degrees of freedom: the expected sum of squares is σ² tr(S (I − P)) = σ² ν, where P = A (AᵀA)⁻¹ Aᵀ takes out the map of the tilting
//! axis with the offsets A, and S the five errors of each of n poses: ν = (3 N − 5) n − tr((AᵀA)⁻¹ AᵀS A). Of a full grid of two nest positions the
//! trace is 1, the distance of the two offsets: all else in A is a motion of both by the five errors of each pose.

use super::b_errors::BErrors;
use super::grid::{Cell, Grid};
use nalgebra::{DMatrix, Matrix2, Vector2, Vector3};
use trunnion_core::Twist;

/// Fewer degrees of freedom are rounding of none.
const ROUNDING: f64 = 1e-6;

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
        // Of what is left at poses that have errors; AᵀS A.
        let (mut squares_mm2, mut freedom) = (0.0, 0.0);
        let columns = b_errors.design.ncols();
        let (mut gram, mut row) = (DMatrix::zeros(columns, columns), 0);
        for tilt in 0..grid.tilts_rad.len() {
            let mut of_tilt = vec![None; grid.turns_rad.len()];
            let mut leverage = of_tilt.clone();
            let left: Vec<_> = grid.at_tilt(tilt).zip(&b_errors.residual_mm[tilt]).collect();
            let first = row;
            row += 3 * left.len();
            for turn in 0..grid.turns_rad.len() {
                let here: Vec<(&Cell, Vector3<f64>)> = left
                    .iter()
                    .filter(|((j, ..), _)| *j == turn)
                    .map(|((.., cell), left)| (*cell, **left))
                    .collect();
                (of_tilt[turn], leverage[turn]) =
                    grid.has_all(tilt, turn).then(|| at_pose(grid, &here)).flatten().unzip();
                let twist = of_tilt[turn].unwrap_or_default();
                let after = here.iter().map(|(cell, left)| left - cell.of_turning(&twist));
                if of_tilt[turn].is_some() {
                    squares_mm2 += after.clone().map(|left| left.norm_squared()).sum::<f64>();
                    freedom += (3 * here.len() - 5) as f64;
                    let rows: Vec<usize> = (0..left.len()).filter(|n| left[*n].0.0 == turn).collect();
                    let of_column = |k: usize| {
                        let read =
                            |n: &usize| b_errors.design.fixed_view::<3, 1>(first + 3 * n, k).into_owned();
                        let here: Vec<_> =
                            here.iter().map(|(cell, _)| *cell).zip(rows.iter().map(read)).collect();
                        let twist = at_pose(grid, &here).map(|(twist, _)| twist).unwrap_or_default();
                        here.iter()
                            .flat_map(|(cell, read)| {
                                let left = read - cell.of_turning(&twist);
                                [left.x, left.y, left.z]
                            })
                            .collect::<Vec<f64>>()
                    };
                    let left = DMatrix::from_vec(
                        3 * here.len(),
                        columns,
                        (0..columns).flat_map(of_column).collect(),
                    );
                    gram += left.tr_mul(&left);
                }
                errors.residual_mm.extend(after);
            }
            errors.at.push(of_tilt);
            leverages.push(leverage);
        }
        let freedom = freedom - (&b_errors.cofactor * gram).trace();
        let by_residual_mm = (freedom > ROUNDING).then(|| (squares_mm2 / freedom).sqrt());
        // Where neither is known, no u is.
        let u_mm = [by_residual_mm, by_repeats_mm(grid)].into_iter().flatten().reduce(f64::max);
        let scaled = |leverage: Option<Twist>| Some(leverage? * u_mm?);
        errors.u_at =
            leverages.into_iter().map(|of_tilt| of_tilt.into_iter().map(scaled).collect()).collect();
        errors
    }
}

/// Standard uncertainty of one component of the mean of a cell by the repeats of one pose, mm.
fn by_repeats_mm(grid: &Grid<'_>) -> Option<f64> {
    let all = || grid.cells.iter().flatten().flatten().flatten();
    let shares: f64 = all().map(|cell| 1.0 / cell.readings as f64).sum();
    Some(grid.repeat_mm? * (shares / all().count().max(1) as f64).sqrt())
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
