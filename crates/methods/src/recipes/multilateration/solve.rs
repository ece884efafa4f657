//! The least squares: stations with their dead paths, and targets that are eliminated one by one.
//!
//! e_ij = (x_i − X_j)/‖x_i − X_j‖, a_ij = (−e_ij, −1) of station j:  D_i = Σ e eᵀ, E_i = Σ e aᵀ, F = Σ a aᵀ, and with the residuals b_i = Σ e r,
//! c = Σ a r.  F′ = F − Σ Eᵀ D⁻¹ E has the six rigid motions as its null space; B, those of the stations, fix them: (F′ + B Bᵀ) s = c − Σ Eᵀ D⁻¹ b,
//! then D d_i = b_i − E s.

use super::observed::Group;
use super::uncertainty::{Covariance, covariance};
use crate::geometry::plane;
use crate::recipes::{Method, MethodError};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Vector3};
use trunnion_core::statistics::COVERAGE_95;

/// Steps after which the least squares does not converge any more; from places known to some millimetres it takes four or five.
const MOST_STEPS: usize = 50;
const MOST_HALVINGS: i32 = 30;
/// A step below this has arrived, mm: a thousandth of what interferometers resolve.
const ARRIVED_MM: f64 = 1e-9;
/// Relative rounding of a sum of squares.
const ROUNDING: f64 = 1e-13;
/// Rigid motions.
const RIGID: usize = 6;
/// Eigenvalues of the reduced normal matrix below this share of the largest are rounding: singular values below 10⁻⁶, next to the floor of
/// a Gram form (docs/design/numerics.md §1.2).
const FLOOR: f64 = 1e-12;
/// Stations nearer to a plane than this share of their distances are entered in it.
const FLAT: f64 = 1e-6;

/// What was found of one group, table axes.
pub(super) struct Solved {
    pub stations: Vec<FoundStation>,
    /// Δ of each target and its u, mm.
    pub targets: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Standard deviation of one reading by the residuals, mm.
    pub noise_mm: f64,
}

/// One station.
pub(super) struct FoundStation {
    pub at_mm: Vector3<f64>,
    pub u_mm: Vector3<f64>,
    pub dead_path_mm: f64,
    pub dead_path_u_mm: f64,
}

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

/// Solves one group.
///
/// # Errors
/// Stations or targets that leave unknowns undetermined; no convergence.
pub(super) fn solved(method: &Method, group: &Group) -> Result<Solved, MethodError> {
    let lacks = |found: String, next: &str| Err(method.lacks(found, next));
    let flat = "Put one station higher or lower than the others.";
    let in_plane = |of: &[Vector3<f64>]| match plane(of) {
        Ok(plane) => {
            plane.rms_mm <= FLAT * of.iter().map(|at| (at - plane.through_mm).norm()).fold(0.0, f64::max)
        }
        Err(_) => true,
    };
    let mut at = start(group);
    if in_plane(&at.stations) {
        return lacks(format!("the {} stations lie in one plane", at.stations.len()), flat);
    }
    let undetermined = || format!("the {} targets do not determine the stations", group.targets.len());
    let spread = "Spread the targets over the volume.";
    let Some(mut normal) = normal(group, &at).filter(Normal::determined) else {
        return lacks(undetermined(), spread);
    };
    let mut squares = sum_of_squares(group, &at);
    let mut arrived = false;
    for _ in 0..MOST_STEPS {
        let Some(step) = normal.step() else { return lacks(undetermined(), spread) };
        let taken = (0..MOST_HALVINGS).find_map(|halvings: i32| {
            let tried = at.moved(&step, 0.5f64.powi(halvings));
            let of_tried = sum_of_squares(group, &tried);
            (of_tried <= squares * (1.0 + ROUNDING)).then_some((tried, of_tried))
        });
        let Some((better, of_better)) = taken else { break };
        (at, squares) = (better, of_better);
        arrived = step.largest_mm() < ARRIVED_MM;
        let Some(next) = self::normal(group, &at) else { return lacks(undetermined(), spread) };
        normal = next;
        if arrived {
            break;
        }
    }
    let nominal_mm: Vec<Vector3<f64>> = group.targets.iter().map(|target| target.nominal_mm).collect();
    at.fit_to(&nominal_mm);
    let noise_mm = (squares / group.freedom() as f64).sqrt();
    let Some(covariance) = self::normal(group, &at).and_then(|normal| covariance(&normal, &at)) else {
        return lacks(undetermined(), spread);
    };
    // Also where the least squares wanders: in one plane it has no single solution.
    if let Ok(plane) = plane(&at.stations) {
        let off_mm = DVector::from_vec(plane.deviation_mm);
        let u_mm = noise_mm * covariance.off_plane(&off_mm, &plane.normal);
        if off_mm.norm() <= COVERAGE_95 * u_mm {
            let found = format!(
                "the {} stations lie in one plane within u of their places ({:.1} mm off it, u {u_mm:.1} mm)",
                at.stations.len(),
                off_mm.norm()
            );
            return lacks(found, flat);
        }
    }
    if !arrived {
        return lacks(
            "the least squares does not converge".into(),
            "Check the places of the stations (ball_in_table_mm), and that every reading is of its target.",
        );
    }
    Ok(report(group, &at, noise_mm, &covariance))
}

fn report(group: &Group, at: &Places, noise_mm: f64, covariance: &Covariance) -> Solved {
    let station = |k: usize| FoundStation {
        at_mm: at.stations[k],
        u_mm: covariance.stations[k].diagonal().map(f64::sqrt) * noise_mm,
        dead_path_mm: at.dead_paths[k],
        dead_path_u_mm: covariance.dead_paths[k].sqrt() * noise_mm,
    };
    let target = |k: usize| {
        let off_mm = at.targets[k] - group.targets[k].nominal_mm;
        (off_mm, covariance.targets[k].diagonal().map(f64::sqrt) * noise_mm)
    };
    Solved {
        stations: (0..at.stations.len()).map(station).collect(),
        targets: (0..at.targets.len()).map(target).collect(),
        noise_mm,
    }
}

/// Nominal places, and dead paths as they follow from them.
fn start(group: &Group) -> Places {
    let stations: Vec<Vector3<f64>> = group.stations.iter().map(|station| station.nominal_mm).collect();
    let targets: Vec<Vector3<f64>> = group.targets.iter().map(|target| target.nominal_mm).collect();
    let dead_path = |k: usize| {
        let own = group.distances.iter().filter(|distance| distance.station == k);
        let beyond: Vec<f64> = own.map(|d| (targets[d.target] - stations[k]).norm() - d.length_mm).collect();
        beyond.iter().sum::<f64>() / beyond.len().max(1) as f64
    };
    let dead_paths = (0..stations.len()).map(dead_path).collect();
    Places { stations, dead_paths, targets }
}

fn sum_of_squares(group: &Group, at: &Places) -> f64 {
    group.distances.iter().map(|d| at.residual_mm(d.station, d.target, d.length_mm).powi(2)).sum()
}

/// `None` when a target is seen from directions in one plane.
fn normal(group: &Group, at: &Places) -> Option<Normal> {
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
struct Step {
    stations: DVector<f64>,
    targets: Vec<Vector3<f64>>,
}

impl Step {
    fn largest_mm(&self) -> f64 {
        self.targets.iter().map(Vector3::amax).fold(self.stations.amax(), f64::max)
    }
}

impl Normal {
    /// True when nothing but the rigid motions was undetermined.
    fn determined(&self) -> bool {
        let eigen = self.reduced.clone().symmetric_eigenvalues();
        eigen.min() > FLOOR * eigen.max()
    }

    fn step(&self) -> Option<Step> {
        let stations = self.reduced.clone().cholesky()?.solve(&self.of_stations);
        let target = |i: usize| self.own_inverse[i] * (self.of_targets[i] - &self.mixed[i] * &stations);
        let targets = (0..self.of_targets.len()).map(target).collect();
        Some(Step { stations, targets })
    }
}

impl Places {
    fn residual_mm(&self, station: usize, target: usize, length_mm: f64) -> f64 {
        let distance_mm = (self.targets[target] - self.stations[station]).norm();
        length_mm - (distance_mm - self.dead_paths[station])
    }

    fn moved(&self, step: &Step, share: f64) -> Self {
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
    fn fit_to(&mut self, nominal_mm: &[Vector3<f64>]) {
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
