//! Removing the rigid displacement that fits a map best.
//!
//! e(w) = t + ω × (w − w̄): t the mean, ω by least squares, N ω = Σ (w − w̄) × e, N = Σ (|w − w̄|² 1 − (w − w̄)(w − w̄)ᵀ); of the
//! orientation ω is taken off as well. Where all places lie on a line, the turn about it is left alone.

use nalgebra::{DMatrix, Matrix3, Point3, Vector3};

/// Relative inertia about a direction below which the places do not show a turn.
const SHOWS_A_TURN: f64 = 1e-9;

/// Every column of a map without its best rigid displacement; rows: X Y Z A B C of each place.
pub fn removed(map: &DMatrix<f64>, in_table_mm: &[Point3<f64>]) -> DMatrix<f64> {
    let count = in_table_mm.len().max(1) as f64;
    let middle = in_table_mm.iter().map(|w| w.coords).sum::<Vector3<f64>>() / count;
    let arms: Vec<Vector3<f64>> = in_table_mm.iter().map(|w| w.coords - middle).collect();
    let inertia: Matrix3<f64> =
        arms.iter().map(|arm| Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()).sum();
    let principal = inertia.symmetric_eigen();
    let least = SHOWS_A_TURN * principal.eigenvalues.max();
    let inverse =
        |k: usize| if principal.eigenvalues[k] > least { principal.eigenvalues[k].recip() } else { 0.0 };
    let turn_from_moment: Matrix3<f64> = (0..3)
        .map(|k| principal.eigenvectors.column(k) * principal.eigenvectors.column(k).transpose() * inverse(k))
        .sum();
    let mut left = map.clone();
    for mut column in left.column_iter_mut() {
        let at = |k: usize| Vector3::new(column[6 * k], column[6 * k + 1], column[6 * k + 2]);
        let shift = (0..arms.len()).map(at).sum::<Vector3<f64>>() / count;
        let moment: Vector3<f64> = (0..arms.len()).map(|k| arms[k].cross(&at(k))).sum();
        let turn = turn_from_moment * moment;
        for (k, arm) in arms.iter().enumerate() {
            let rigid = shift + turn.cross(arm);
            for i in 0..3 {
                column[6 * k + i] -= rigid[i];
                column[6 * k + 3 + i] -= turn[i];
            }
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> Vec<Point3<f64>> {
        (0..8)
            .map(|k| {
                Point3::new(f64::from(k & 1) * 300.0, f64::from(k >> 1 & 1) * 200.0, f64::from(k >> 2) * 90.0)
            })
            .collect()
    }

    #[test]
    fn a_rigid_displacement_leaves_nothing_and_a_scale_stays() {
        let (shift, turn) = (Vector3::new(0.01, -0.02, 0.005), Vector3::new(3e-5, -1e-5, 2e-5));
        let places = corners();
        let rigid = |i: usize| {
            let moved = shift + turn.cross(&places[i / 6].coords);
            if i % 6 < 3 { moved[i % 6] } else { turn[i % 6 - 3] }
        };
        let scale = |i: usize| if i.is_multiple_of(6) { places[i / 6].x * 1e-5 } else { 0.0 };
        let map = DMatrix::from_fn(48, 2, |i, j| if j == 0 { rigid(i) } else { rigid(i) + scale(i) });
        let left = removed(&map, &places);
        assert!(left.column(0).amax() < 1e-15, "{}", left.column(0));
        // 10 µm/m over 300 mm, about the middle.
        assert!((left.column(1).amax() - 1.5e-3).abs() < 1e-12);
    }
}
