//! What a fit leaves, laid out so that the noise can be learned from it: the one place where fits and diagnoses get their noise.

use super::Real;
use super::display::Display;
use super::kernel::Kernel;
use super::kernels::Kernels;
use super::mode::{Effort, Mode, Readings};
use super::sigma::NOTHING;
use super::tails;
use crate::Experiment;
use crate::evidence::{joined, orthonormal};
use crate::problem::rows::Rows;
use crate::written::vector;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::{Arc, OnceLock};
use trunnion_core::statistics::{MEDIAN_OF_NORMAL, upper_median};

/// Of the robust size of the residual, what is white to begin with.
const WHITE_FIRST: f64 = 0.7;
/// Readings are never trusted below this, mm: ten times under the resolution of any probe.
const FINEST_MM: f64 = 1e-6;
/// Readings from which a first idea of the noise is learned: a covariance of that size takes a fortieth of the largest.
const FEW_ROWS: usize = 350;
/// Standard deviations below what is expected at which channels are alike.
const QUIET: f64 = 3.0;
/// Rounds of learning the weights of points.
const WEIGHINGS: usize = 2;

/// A fit, as far as its noise needs it. Rows are those of the experiment.
pub(crate) struct Fitted<'a> {
    pub row_weights: &'a DVector<f64>,
    /// Without weights.
    pub residual_mm: &'a DVector<f64>,
    pub predicted_mm: &'a DVector<f64>,
    pub used: &'a [bool],
    /// The noise that this fit has learned.
    pub own: Option<&'a Learned>,
    /// That of another fit of the same points.
    pub other: Option<&'a Learned>,
}

/// What a fit leaves.
pub(crate) struct Remainder<'a> {
    /// The rows that are looked at.
    pub rows: Rows<'a>,
    /// Root of the weight of each row: base, readings and every column are multiplied by it.
    pub root: DVector<f64>,
    /// Columns of the model, weighted.
    pub base: DMatrix<f64>,
    /// Orthonormal ones that span them.
    pub basis: DMatrix<Real>,
    /// What the fit leaves, weighted, in units of `unit_mm`: exact, so that nothing of second order is taken for noise or effect.
    pub y: DVector<Real>,
    pub unit_mm: f64,
    /// The display of the readings where its step is coarser than the residual.
    pub coarse_display: Option<Display>,
    pub kernels: Arc<Kernels>,
    shared: SharedKernels,
    /// ln of the least white standard deviation.
    least_ln: f64,
    /// Nodes of which every point took part in the fit.
    used: Vec<bool>,
}

type SharedKernels = Arc<OnceLock<Arc<Kernels>>>;

/// The noise of one fit.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Learned {
    /// s, mm, and ln ρ of every kernel.
    s_mm: f64,
    rho_ln: Vec<f64>,
    /// Multiple of the white variance of every row.
    #[serde(with = "vector")]
    pub white: DVector<f64>,
    /// Shared by all fits of the same points with the same weights: they depend on nothing else. A noise that was written and read back has
    /// none until somebody needs them.
    #[serde(skip)]
    kernels: SharedKernels,
    #[serde(with = "vector")]
    root: DVector<f64>,
}

impl<'a> Remainder<'a> {
    /// `columns`: those of the model on the rows that are looked at, weighted, from the rows and their roots.
    pub fn new<E>(
        experiment: &'a Experiment,
        fitted: &Fitted<'_>,
        columns: impl FnOnce(&Rows<'a>, &DVector<f64>) -> Result<DMatrix<f64>, E>,
    ) -> Result<Self, E> {
        let rows = Rows::new(experiment);
        let root = rows.of_vector(fitted.row_weights.clone());
        let mut base = columns(&rows, &root)?;
        let mut residual_mm = fitted.residual_mm.clone();
        // However wild a reading is that the fit left out, it says nothing: its point counts for nothing, not for little.
        experiment.unused_rows(fitted.used).for_each(|row| residual_mm[row] = 0.0);
        let residual = rows.of_vector(residual_mm).component_mul(&root);
        let sizes: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
        let unit_mm = (upper_median(&sizes).unwrap_or(0.0) / MEDIAN_OF_NORMAL).max(FINEST_MM);
        let display = Display::of(experiment);
        let least_mm = display.as_ref().map_or(0.0, |display| display.hidden_mm()).max(FINEST_MM);
        let coarse_display = display.filter(|display| display.step_mm > unit_mm);
        if let Some(display) = &coarse_display {
            let mut saw = rows.of(display.saw(experiment, fitted.predicted_mm));
            saw.column_iter_mut().for_each(|mut column| column.component_mul_assign(&root));
            base = joined(&base, &saw);
        }
        let nodes = 0..rows.points.points.len();
        let used = nodes.map(|node| rows.points_of(node).iter().all(|&point| fitted.used[point])).collect();
        let other = fitted.own.or(fitted.other).filter(|other| other.root == root);
        let shared = other.map_or_else(SharedKernels::default, |other| other.kernels.clone());
        let of_rows = || Arc::new(Kernels::new(&rows.points, &root, rows.readings_of_one().sqrt()));
        let kernels = shared.get_or_init(of_rows).clone();
        let (y, basis) = ((residual / unit_mm).cast::<Real>(), orthonormal(&base).cast::<Real>());
        let least_ln = (least_mm / unit_mm).ln();
        Ok(Self { rows, root, base, basis, y, unit_mm, coarse_display, kernels, shared, least_ln, used })
    }

    /// The noise with the columns of the model, with the weights of points that it asks for; near the mode, as sizes need it.
    pub fn learn(&self) -> Option<(Learned, Mode)> {
        let of_point = |i: &usize| if self.used[*i] { 1.0 } else { NOTHING };
        let kernels = &self.kernels;
        let mut white = DVector::from_iterator(self.y.len(), kernels.point_of_row.iter().map(of_point));
        // What some points say may have no covariance of all: white noise that is nothing next to the rest.
        let begun = self.mode(&white, &self.start(&white), Effort::SIZES);
        let begun = begun.or_else(|| self.mode(&white, &self.first(), Effort::SIZES))?;
        let mut mode = self.without_a_loud_channel(&white, &begun).unwrap_or(begun);
        let poses = self.rows.points.poses();
        for _ in 0..WEIGHINGS {
            let weights = tails::weights(&mode, kernels, &poses, &white, &self.used);
            let Some(weights) = weights else { break };
            let Some(next) = self.mode(&weights, mode.x(), Effort::SIZES) else { break };
            (white, mode) = (weights, next);
        }
        let s_mm = mode.s() * self.unit_mm;
        let (kernels, root) = (self.shared.clone(), self.root.clone());
        Some((Learned { s_mm, rho_ln: mode.x()[1..].to_vec(), white, kernels, root }, mode))
    }

    /// A mode that holds more than one in which a channel is several times as loud as the others: a few large errors of it that come back are
    /// near to being its noise.
    fn without_a_loud_channel(&self, white: &DVector<f64>, mode: &Mode) -> Option<Mode> {
        let kernels = self.kernels.list.iter();
        let is_loud = |(kernel, ln): (&Kernel, &f64)| kernel.is_white() && *ln > 0.0;
        if !kernels.clone().zip(&mode.x()[1..]).any(is_loud) {
            return None;
        }
        let size_ln =
            |kernel: &Kernel| kernel.mean_ln - if kernel.is_white() { QUIET * kernel.spread_ln } else { 0.0 };
        let quiet: Vec<f64> = std::iter::once(mode.x()[0]).chain(kernels.map(size_ln)).collect();
        self.mode(white, &quiet, Effort::FULL).filter(|other| other.posterior > mode.posterior)
    }

    /// The mode from the noise that was learned for sizes alone.
    pub fn mode_from(&self, learned: &Learned) -> Option<Mode> {
        let found = self.mode(&learned.white, &self.sizes(learned), Effort::FULL);
        found.or_else(|| self.mode(&learned.white, &self.first(), Effort::FULL))
    }

    /// The noise that a fit of these points with these columns has learned, and the mode there; learned where it has none.
    pub fn learned(&self, learned: Option<&Learned>) -> Option<(Learned, Mode)> {
        let known = learned.and_then(|learned| {
            Some((learned.clone(), self.mode(&learned.white, &self.sizes(learned), Effort::SIZES)?))
        });
        known.or_else(|| self.learn())
    }

    /// Sizes that were learned, in logarithms: s in units of this fit.
    fn sizes(&self, learned: &Learned) -> Vec<f64> {
        let s_ln = (learned.s_mm / self.unit_mm).ln();
        std::iter::once(s_ln).chain(learned.rho_ln.iter().copied()).collect()
    }

    /// The means of the prior.
    fn first(&self) -> Vec<f64> {
        std::iter::once(WHITE_FIRST.ln()).chain(self.kernels.means()).collect()
    }

    /// Where to begin: what some of the points say, as many as cost nothing, from the means of the prior.
    fn start(&self, white: &DVector<f64>) -> Vec<f64> {
        let kernels = &self.kernels;
        let x = self.first();
        let chosen: Vec<usize> = (0..kernels.points).step_by(self.y.len().div_ceil(FEW_ROWS)).collect();
        let rows: Vec<usize> = chosen.iter().flat_map(|&i| kernels.rows_of_point[i].clone()).collect();
        let basis = orthonormal(&self.base.select_rows(&rows)).cast::<Real>();
        if chosen.len() == kernels.points || rows.len() < 2 * basis.ncols() {
            return x;
        }
        let some = kernels.on(&chosen);
        let (y, white) = (self.y.select_rows(&rows), white.select_rows(&rows));
        let readings = Readings { kernels: &some, y: &y, white: &white, least_ln: self.least_ln };
        let mode = readings.sigma(&x).and_then(|start| readings.learn(&basis, &[start], Effort::FULL));
        mode.map_or(x, |mode| mode.x().to_vec())
    }

    /// The readings with these multiples of the white variance.
    pub fn readings<'r>(&'r self, white: &'r DVector<f64>) -> Readings<'r> {
        Readings { kernels: &self.kernels, y: &self.y, white, least_ln: self.least_ln }
    }

    fn mode(&self, white: &DVector<f64>, x: &[f64], effort: Effort) -> Option<Mode> {
        let readings = self.readings(white);
        readings.learn(&self.basis, &[readings.sigma(x)?], effort)
    }
}

/// The kernels follow from the rest.
impl PartialEq for Learned {
    fn eq(&self, other: &Self) -> bool {
        let Self { s_mm, rho_ln, white, kernels: _, root } = self;
        (s_mm, rho_ln, white, root) == (&other.s_mm, &other.rho_ln, &other.white, &other.root)
    }
}

impl fmt::Debug for Learned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Learned").field("s_mm", &self.s_mm).field("rho_ln", &self.rho_ln).finish()
    }
}

/// Columns (rows × columns) multiplied by the roots of the weights.
pub(crate) fn weighted(mut columns: DMatrix<f64>, root: &DVector<f64>) -> DMatrix<f64> {
    columns.column_iter_mut().for_each(|mut column| column.component_mul_assign(root));
    columns
}
