//! Covariances for unit noise, with the rigid fit to the commanded places propagated.
//!
//! G_i = D_i⁻¹ E_i, Q = (F′ + B Bᵀ)⁻¹: d_i = ε_i − G_i s, where ε_i (covariance D_i⁻¹) and s (Q) are independent. R_i rigid motions of target i,
//! H = (Σ Rᵀ R)⁻¹, A_i = H R_iᵀ; the fit takes off R_i Σ A_k d_k. With K = Σ A_k G_k and V = Σ A_k D_k⁻¹ A_kᵀ:
//!     cov Δ_i = D_i⁻¹ − D_i⁻¹ A_iᵀ R_iᵀ − R_i A_i D_i⁻¹ + R_i V R_iᵀ + (G_i − R_i K) Q (G_i − R_i K)ᵀ
//!     cov X_j = (P_j + R_j K) Q (P_j + R_j K)ᵀ + R_j V R_jᵀ,  P_j picks station j out of s.
//! What B leaves to the rigid motions drops out, for G_i − R_i K and P_j + R_j K are zero for them.

use super::normal::{Normal, Places, rigid_motions};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Matrix6, Matrix6xX, Vector3};

/// For unit noise of a reading, mm².
pub(super) struct Covariance {
    pub targets: Vec<Matrix3<f64>>,
    pub stations: Vec<Matrix3<f64>>,
    pub dead_paths: Vec<f64>,
    of_stations: DMatrix<f64>,
}

/// `None` when the targets fix no turn, or the stations are undetermined.
pub(super) fn covariance(normal: &Normal, at: &Places) -> Option<Covariance> {
    let of_stations = normal.reduced.clone().cholesky()?.inverse();
    let middle = at.targets.iter().sum::<Vector3<f64>>() / at.targets.len() as f64;
    let motions: Vec<_> = at.targets.iter().map(|target| rigid_motions(&(target - middle))).collect();
    let scatter: Matrix6<f64> = motions.iter().map(|r| r.transpose() * r).sum();
    let inverse = scatter.cholesky()?.inverse();
    let by_stations: Vec<Matrix3xX<f64>> =
        normal.own_inverse.iter().zip(&normal.mixed).map(|(own, mixed)| own * mixed).collect();
    let mut of_fit = Matrix6xX::zeros(of_stations.nrows());
    let mut fit_variance = Matrix6::zeros();
    for ((r, g), own) in motions.iter().zip(&by_stations).zip(&normal.own_inverse) {
        let a = inverse * r.transpose();
        of_fit += a * g;
        fit_variance += a * own * a.transpose();
    }
    let target = |i: usize| {
        let (r, own) = (&motions[i], &normal.own_inverse[i]);
        let mutual = r * inverse * r.transpose() * own;
        let left = &by_stations[i] - r * &of_fit;
        own - mutual - mutual.transpose()
            + r * fit_variance * r.transpose()
            + &left * &of_stations * left.transpose()
    };
    let station = |j: usize| {
        let r = rigid_motions(&(at.stations[j] - middle));
        let mut left = r * &of_fit;
        let mut own = left.columns_mut(4 * j, 3);
        own += Matrix3::identity();
        &left * &of_stations * left.transpose() + r * fit_variance * r.transpose()
    };
    let stations = 0..at.stations.len();
    Some(Covariance {
        targets: (0..at.targets.len()).map(target).collect(),
        stations: stations.clone().map(station).collect(),
        dead_paths: stations.map(|j| of_stations[(4 * j + 3, 4 * j + 3)]).collect(),
        of_stations,
    })
}

impl Covariance {
    /// Uncertainty of how far the stations are off their plane in all, along the pattern in which they are; rigid motions do not change it.
    pub fn off_plane(&self, off_mm: &DVector<f64>, normal: &Vector3<f64>) -> f64 {
        let mut pattern = DVector::zeros(self.of_stations.nrows());
        let length = off_mm.norm().max(f64::MIN_POSITIVE);
        for (j, off) in off_mm.iter().enumerate() {
            pattern.rows_mut(4 * j, 3).copy_from(&(normal * (off / length)));
        }
        (pattern.transpose() * &self.of_stations * &pattern)[0].max(0.0).sqrt()
    }
}
