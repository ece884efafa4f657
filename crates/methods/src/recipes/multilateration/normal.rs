//! The normal equations: stations with their dead paths, and targets that are eliminated one by one.
//!
//! e_ij = (x_i − X_j)/‖x_i − X_j‖, a_ij = (−e_ij, −1) of station j:  D_i = Σ e eᵀ, E_i = Σ e aᵀ, F = Σ a aᵀ, and with the residuals b_i = Σ e r,
//! c = Σ a r.  F′ = F − Σ Eᵀ D⁻¹ E has the six rigid motions as its null space; B, those of the stations, fix them: (F′ + B Bᵀ) s = c − Σ Eᵀ D⁻¹ b,
//! then D d_i = b_i − E s.

use super::observed::Group;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Vector3};

/// Rigid motions.
const RIGID: usize = 6;
/// Eigenvalues of the reduced normal matrix below this share of the largest are rounding: singular values below 10⁻⁶, next to the floor of
/// a Gram form (docs/design/numerics.md §1.2).
const FLOOR: f64 = 1e-12;

/// Places of all, mm.
#[derive(Clone)]
pub(super) struct Places {
    pub stations: Vec<Vector3<f64>>,
    pub dead_paths: Vec<f64>,
    pub targets: Vec<Vector3<f64>>,
}

/// Normal equations, targets apart.
pub(super) struct Normal {
    /// D⁻¹ of each target.
    pub own_inverse: Vec<Matrix3<f64>>,
    /// E of each target.
    pub mixed: Vec<Matrix3xX<f64>>,
    /// F′ + B Bᵀ.
    pub reduced: DMatrix<f64>,
    of_targets: Vec<Vector3<f64>>,
    of_stations: DVector<f64>,
}

/// `None` when a target is seen from directions in one plane.
pub(super) fn normal(group: &Group, at: &Places) -> Option<Normal> {
    let unknowns = 4 * at.stations.len();
    let mut own = vec![Matrix3::zeros(); at.targets.len()];
    let mut mixed = vec![Matrix3xX::zeros(unknowns); at.targets.len()];
    let mut of_targets = vec![Vector3::zeros(); at.targets.len()];
    let mut reduced = DMatrix::zeros(unknowns, unknowns);
    let mut of_stations = DVector::zeros(unknowns);
    for d in &group.distances {
        let (i, first) = (d.target, 4 * d.station);
        let e = (at.targets[i] - at.stations[d.station]).try_normalize(f64::MIN_POSITIVE)?;
        let a = nalgebra::Vector4::new(-e.x, -e.y, -e.z, -1.0);
        let r = at.residual_mm(d.station, i, d.length_mm);
        own[i] += e * e.transpose();
        let mut of_mixed = mixed[i].columns_mut(first, 4);
        of_mixed += e * a.transpose();
        let mut of_reduced = reduced.view_mut((first, first), (4, 4));
        of_reduced += a * a.transpose();
        of_targets[i] += e * r;
        let mut of_right = of_stations.rows_mut(first, 4);
        of_right += a * r;
    }
    let own_inverse: Vec<Matrix3<f64>> =
        own.iter().map(|own| own.cholesky().map(|own| own.inverse())).collect::<Option<_>>()?;
    for i in 0..at.targets.len() {
        let eliminated = own_inverse[i] * &mixed[i];
        reduced -= mixed[i].transpose() * &eliminated;
        of_stations -= eliminated.transpose() * of_targets[i];
    }
    Some(Normal { own_inverse, mixed, reduced: reduced + fixed(at), of_targets, of_stations })
}

/// B Bᵀ.
fn fixed(at: &Places) -> DMatrix<f64> {
    let count = at.stations.len();
    let middle = at.stations.iter().sum::<Vector3<f64>>() / count as f64;
    let mut rigid = DMatrix::zeros(4 * count, RIGID);
    for (k, station) in at.stations.iter().enumerate() {
        rigid.view_mut((4 * k, 0), (3, RIGID)).copy_from(&rigid_motions(&(station - middle)));
    }
    let basis = rigid.qr().q();
    &basis * basis.transpose()
}

/// Displacement of a place, seen from the middle, for each rigid motion: (I, −[p]×).
pub(super) fn rigid_motions(place: &Vector3<f64>) -> nalgebra::Matrix3x6<f64> {
    let mut motions = nalgebra::Matrix3x6::zeros();
    motions.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
    motions.fixed_view_mut::<3, 3>(0, 3).copy_from(&-place.cross_matrix());
    motions
}

/// A step of all unknowns.
pub(super) struct Step {
    stations: DVector<f64>,
    targets: Vec<Vector3<f64>>,
}

impl Step {
    pub fn largest_mm(&self) -> f64 {
        self.targets.iter().map(Vector3::amax).fold(self.stations.amax(), f64::max)
    }
}

impl Normal {
    /// True when nothing but the rigid motions was undetermined.
    pub fn determined(&self) -> bool {
        let eigen = self.reduced.clone().symmetric_eigenvalues();
        eigen.min() > FLOOR * eigen.max()
    }

    pub fn step(&self) -> Option<Step> {
        let stations = self.reduced.clone().cholesky()?.solve(&self.of_stations);
        let target = |i: usize| self.own_inverse[i] * (self.of_targets[i] - &self.mixed[i] * &stations);
        let targets = (0..self.of_targets.len()).map(target).collect();
        Some(Step { stations, targets })
    }

    /// What a step takes off the sum of squares, to first order in it: the square of the step in units of u, times s².
    pub fn falls_by(&self, step: &Step) -> f64 {
        let of_target = |(own, right): (&Matrix3<f64>, &Vector3<f64>)| right.dot(&(own * right));
        let of_targets: f64 = self.own_inverse.iter().zip(&self.of_targets).map(of_target).sum();
        of_targets + step.stations.dot(&self.of_stations)
    }
}

impl Places {
    pub fn residual_mm(&self, station: usize, target: usize, length_mm: f64) -> f64 {
        let distance_mm = (self.targets[target] - self.stations[station]).norm();
        length_mm - (distance_mm - self.dead_paths[station])
    }

    pub fn moved(&self, step: &Step, share: f64) -> Self {
        let mut moved = self.clone();
        for k in 0..self.stations.len() {
            moved.stations[k] += step.stations.fixed_rows::<3>(4 * k) * share;
            moved.dead_paths[k] += step.stations[4 * k + 3] * share;
        }
        for (target, by) in moved.targets.iter_mut().zip(&step.targets) {
            *target += by * share;
        }
        moved
    }

    /// Moves and turns all together so that the targets are nearest to these places (Kabsch 1976).
    pub fn fit_to(&mut self, nominal_mm: &[Vector3<f64>]) {
        let middle = |of: &[Vector3<f64>]| of.iter().sum::<Vector3<f64>>() / of.len() as f64;
        let (from, to) = (middle(&self.targets), middle(nominal_mm));
        let scatter: Matrix3<f64> =
            self.targets.iter().zip(nominal_mm).map(|(x, n)| (x - from) * (n - to).transpose()).sum();
        let svd = scatter.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return };
        let handed = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
        let turn = v_t.transpose() * Matrix3::from_diagonal(&handed) * u.transpose();
        for place in self.targets.iter_mut().chain(&mut self.stations) {
            *place = turn * (*place - from) + to;
        }
    }
}
