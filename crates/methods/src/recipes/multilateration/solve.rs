//! The least squares of one group: start, steps that lower the sum of squares, what is left undetermined.

use super::normal::{Normal, Places, normal};
use super::observed::Group;
use super::uncertainty::{Covariance, covariance};
use crate::geometry::plane;
use crate::recipes::{Method, MethodError};
use nalgebra::{DVector, Vector3};
use trunnion_core::statistics::COVERAGE_95;

/// Steps after which the least squares does not converge any more; from places known to some millimetres it takes four or five.
const MOST_STEPS: usize = 50;
const MOST_HALVINGS: i32 = 30;
/// A step below this has arrived, mm: a thousandth of what interferometers resolve.
const ARRIVED_MM: f64 = 1e-9;
/// So has one that moves every unknown, and every combination of them, by less than this part of its u: what is left is the rounding of
/// normal equations where the stations hardly determine it.
const ARRIVED_U: f64 = 1e-3;
/// Relative rounding of a sum of squares.
const ROUNDING: f64 = 1e-13;
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
        let of_noise = ARRIVED_U.powi(2) * squares / group.freedom() as f64;
        arrived = step.largest_mm() < ARRIVED_MM || normal.falls_by(&step) <= of_noise;
        let taken = (0..MOST_HALVINGS).find_map(|halvings: i32| {
            let tried = at.moved(&step, 0.5f64.powi(halvings));
            let of_tried = sum_of_squares(group, &tried);
            (of_tried <= squares * (1.0 + ROUNDING)).then_some((tried, of_tried))
        });
        let Some((better, of_better)) = taken else { break };
        (at, squares) = (better, of_better);
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
