//! What a machine adds to the white noise, as random columns.
//!
//! Σ = σ² (I + Σ_k θ_k Z_k Z_kᵀ + c L Lᵀ). Every kind has mean variance 1 per reading, so that θ_k and c are variances in units
//! of the white noise:
//! - a pass (a setup in one direction) is offset as a whole, in machine axes: three columns a pass;
//! - the slow rotary axis is positioned again with an angle of its own: one column a positioning;
//! - tool against table drifts in machine axes, Ornstein–Uhlenbeck with correlation time τ;
//! - every rotary axis has small repeatable error motions, harmonic n with amplitude ∝ 1/n;
//! - the fast rotary axis scatters at every point: L, a column a point, kept as levers.
//!
//! Drift in a few columns: sines over a window wider than the run, with the spectral density of the process as variances
//! [Solin, Särkkä: Hilbert space methods for reduced-rank Gaussian process regression, Stat. Comput. 30 (2020) 419].
//! Limits: drift faster than about a sixteenth of a run counts as white.

use crate::Experiment;
use crate::noise::machine_noise::{Order, Visit, motion_harmonic, repeatable_motions};
use crate::problem::passes::Passes;
use nalgebra::{DMatrix, DVector, Vector3};
use std::f64::consts::PI;
use std::ops::Range;

/// Sines of the drift for each run and direction.
const SINES: usize = 16;
/// Half width of the window of the sines, in half lengths of the run.
const WINDOW: f64 = 1.5;
/// Share of the largest eigenvalue below which a combination of motions is left out.
const NEGLIGIBLE: f64 = 1e-3;
/// Variance per reading that is rounding.
const ROUNDING: f64 = 1e-12;

/// Random columns of one kind, rows × columns.
pub(crate) struct Kind {
    pub name: &'static str,
    pub columns: DMatrix<f64>,
}

/// Every kind that these readings can show. Rows are multiplied by `root`, which is zero for readings not used.
pub(crate) fn kinds(
    experiment: &Experiment,
    order: &Order,
    passes: &Passes,
    root: &DVector<f64>,
) -> Vec<Kind> {
    let all = [
        ("offsets of passes", offsets(experiment, order, passes)),
        ("positioning of the slow axis", positionings(experiment, order)),
        ("drift", drift(experiment, order)),
        ("repeatable motions", motions(experiment)),
    ];
    let mut kinds = Vec::with_capacity(all.len());
    for (name, mut columns) in all {
        columns.column_iter_mut().for_each(|mut column| column.component_mul_assign(root));
        let variance = columns.norm_squared() / counted(root);
        if variance > ROUNDING {
            columns /= variance.sqrt();
            kinds.push(Kind { name, columns });
        }
    }
    kinds
}

/// How many readings are used.
fn counted(root: &DVector<f64>) -> f64 {
    root.iter().filter(|weight| **weight > 0.0).count().max(1) as f64
}

fn offsets(experiment: &Experiment, order: &Order, passes: &Passes) -> DMatrix<f64> {
    let mut columns = DMatrix::zeros(experiment.rows(), 3 * passes.passes);
    for visit in &order.visits {
        put(&mut columns, visit, 3 * passes.pass[visit.point], 1.0);
    }
    columns
}

/// A displacement of tool against table of `size` along X, Y, Z in three columns.
fn put(columns: &mut DMatrix<f64>, visit: &Visit, first_column: usize, size: f64) {
    for (k, row) in visit.rows.clone().enumerate() {
        for axis in 0..3 {
            columns[(row, first_column + axis)] = size * visit.drift[(k, axis)];
        }
    }
}

fn positionings(experiment: &Experiment, order: &Order) -> DMatrix<f64> {
    let stations = order.stations();
    let count = stations.iter().max().map_or(0, |last| last + 1);
    let mut columns = DMatrix::zeros(experiment.rows(), count);
    for visit in &order.visits {
        for (k, row) in visit.rows.clone().enumerate() {
            columns[(row, stations[visit.point])] = visit.slow_lever[k];
        }
    }
    columns
}

fn drift(experiment: &Experiment, order: &Order) -> DMatrix<f64> {
    let runs: Vec<&[Visit]> = order.visits.chunk_by(|_, next| !next.new_run).collect();
    let mut columns = DMatrix::zeros(experiment.rows(), 3 * SINES * runs.len());
    for (run, visits) in runs.into_iter().enumerate() {
        let half = 0.5 * visits.iter().map(|visit| visit.since_last).sum::<f64>();
        if half <= 0.0 {
            continue;
        }
        let tau = order.tau / half;
        let mut time = -1.0;
        for visit in visits {
            time += visit.since_last / half;
            for sine in 0..SINES {
                let omega = PI * (sine + 1) as f64 / (2.0 * WINDOW);
                let density = 2.0 * tau / (1.0 + (omega * tau).powi(2));
                let size = (density / WINDOW).sqrt() * (omega * (time + WINDOW)).sin();
                put(&mut columns, visit, 3 * (SINES * run + sine), size);
            }
        }
    }
    columns
}

fn motions(experiment: &Experiment) -> DMatrix<f64> {
    let mut columns = repeatable_motions(experiment).transpose();
    if columns.ncols() == 0 {
        return columns;
    }
    for (j, mut column) in columns.column_iter_mut().enumerate() {
        column /= motion_harmonic(j) as f64;
    }
    // Many coincide in a given set of poses: their principal combinations have the same covariance.
    let eigen = columns.tr_mul(&columns).symmetric_eigen();
    let least = eigen.eigenvalues.amax() * NEGLIGIBLE;
    let kept: Vec<usize> = (0..eigen.eigenvalues.len()).filter(|&j| eigen.eigenvalues[j] > least).collect();
    columns * eigen.eigenvectors.select_columns(&kept)
}

/// L: lever of the fast axis at every point.
pub(crate) struct Levers {
    points: Vec<(Range<usize>, Vector3<f64>)>,
}

impl Levers {
    pub const NAME: &'static str = "scatter of the fast axis";

    pub fn new(order: &Order, root: &DVector<f64>) -> Self {
        let weighted = |visit: &Visit| {
            let mut lever = visit.fast_lever;
            for (k, row) in visit.rows.clone().enumerate() {
                lever[k] *= root[row];
            }
            (visit.rows.clone(), lever)
        };
        let mut points: Vec<_> = order.visits.iter().map(weighted).collect();
        let variance = points.iter().map(|(_, lever)| lever.norm_squared()).sum::<f64>() / counted(root);
        points.retain(|(_, lever)| lever.norm_squared() > ROUNDING);
        points.iter_mut().for_each(|(_, lever)| *lever /= variance.sqrt());
        Self { points }
    }

    /// L has no column.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Diagonal of Lᵀ L.
    pub fn squares(&self) -> DVector<f64> {
        let squares = self.points.iter().map(|(_, lever)| lever.norm_squared());
        DVector::from_iterator(self.points.len(), squares)
    }

    /// Lᵀ X.
    pub fn seen_by(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut seen = DMatrix::zeros(self.points.len(), x.ncols());
        for (j, column) in x.column_iter().enumerate() {
            for (p, (rows, lever)) in self.points.iter().enumerate() {
                seen[(p, j)] = rows.clone().enumerate().map(|(k, row)| lever[k] * column[row]).sum::<f64>();
            }
        }
        seen
    }
}
