//! What the learned noise makes of numbers that are linear in the readings: parameters of a fit, or what a recipe makes of its readings.
//!
//! x = Σ_i h_i r_i whatever Σ is, so its covariance is the sandwich
//!
//! C = Σ_i s²W_i q_i h_i h_iᵀ + Σ_k v_k HᵀK_kH + δδᵀ
//!
//! s, W, K_k: the noise that a diagnosis learns (`noise::learned`, docs/design/statistics.md §1); v_k: draws of s²ρ_k². q_i = (Py)_i²/P_ii: the
//! square of the white part of a reading over what is expected of it, 1 on average; it holds
//! whatever the size of the white noise depends on [White 1980]. δ: from the estimate to the one that weights the readings by Σ⁻¹. Σ says
//! that the estimate errs by −δ; a correction that is known and not made is a part of the uncertainty [GUM F.2.4.5]. Where neighbours are
//! averaged for learning, those of one mean share what is not white, and the white variance of one is that of the mean times their number.
//! Limits: with few readings there is no saying what is noise. The sizes of the parts are learned for all runs together: where runs on
//! the fly are fitted with others of another instrument or at rest, what one of them shows would widen what another knows.

use crate::Experiment;
use crate::fit::identification::NoisePart;
use crate::fit::mixture::half_width;
use crate::noise::learned::Real;
use crate::noise::learned::display::Display;
use crate::noise::learned::kernel::Part;
use crate::noise::learned::mode::Mode;
use crate::noise::learned::posterior::{Draw, draws};
use crate::noise::learned::remainder::{Fitted, Learned, Remainder};
use crate::problem::design::Visit;
use crate::problem::rows::Rows;
use nalgebra::{DMatrix, DVector};
use std::convert::Infallible;
use trunnion_core::statistics::COVERAGE_95;
use trunnion_cycles::RunKind;

const FEWEST_DEGREES_OF_FREEDOM: usize = 20;
/// A row of which the model leaves less than this share says nothing of its own noise: rounding of single precision.
const MOST_FITTED: Real = 1e-3;
/// Parts as a person tells them apart.
const PARTS: [(Part, &str); 4] = [
    (Part::Pass, "offsets of passes"),
    (Part::Station, "positioning"),
    (Part::Drift, "drift"),
    (Part::Pattern, "pattern over the poses"),
];

/// The noise of the readings next to one fit of them.
pub struct ReadingNoise<'e> {
    experiment: &'e Experiment,
    remainder: Remainder<'e>,
    mode: Mode,
    draws: Vec<Draw>,
    /// W q of the rows that are looked at.
    white: DVector<f64>,
    pub(crate) learned: Learned,
    /// Of the fit: the points that took part, roots of the weights of the rows, what it predicts.
    used: Vec<bool>,
    row_weights: DVector<f64>,
    predicted_mm: DVector<f64>,
    degrees_of_freedom: usize,
}

/// What numbers describe beyond the model of the fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BeyondModel {
    /// Whether a pattern that comes back counts as noise of them.
    pub patterns: Patterns,
    /// How many numbers more than those of the model were taken off the readings before the fit. So much less of the white noise is left; what
    /// moves passes as a whole is.
    pub taken_off: usize,
}

impl BeyondModel {
    /// They are numbers of the model.
    pub const NOTHING: Self = Self { patterns: Patterns::Noise, taken_off: 0 };
}

/// Rows of columns, visited block by block.
pub(crate) struct Columns<'c> {
    pub width: usize,
    pub blocks: &'c dyn Fn(Visit<'_>),
}

/// Whether a pattern over the poses that comes back counts as noise of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patterns {
    /// What it makes of the number is an error of it.
    Noise,
    /// It is a part of what the number describes: the mean of an error motion belongs to the average line of the axis [ISO 230-7].
    Described,
}

impl<'e> ReadingNoise<'e> {
    /// `None` outside the limits. `columns`: those of the model on the rows that are looked at, weighted.
    pub(crate) fn learn<E>(
        experiment: &'e Experiment,
        fitted: &Fitted<'_>,
        degrees_of_freedom: usize,
        columns: impl FnOnce(&Rows<'e>, &DVector<f64>) -> Result<DMatrix<f64>, E>,
    ) -> Result<Option<Self>, E> {
        if degrees_of_freedom < FEWEST_DEGREES_OF_FREEDOM || is_mixed(experiment) {
            return Ok(None);
        }
        let remainder = Remainder::new(experiment, fitted, columns)?;
        if remainder.y.len() < 2 * remainder.basis.ncols() {
            return Ok(None);
        }
        let Some((learned, mode)) = remainder.learned(fitted.own) else { return Ok(None) };
        let precision = mode.here.precision();
        let draws = draws(&mode, &precision, &remainder.kernels, &remainder.y);
        let white = learned.white.component_mul(&squares(&mode, &precision));
        Ok(Some(Self {
            experiment,
            remainder,
            mode,
            draws,
            white,
            learned,
            used: fitted.used.to_vec(),
            row_weights: fitted.row_weights.clone(),
            predicted_mm: fitted.predicted_mm.clone(),
            degrees_of_freedom,
        }))
    }

    /// The noise of readings of which columns that somebody fitted, every reading alike, leave `left_mm`: rows as in the experiment. `used`: the
    /// points that took part. `None` outside the limits.
    pub fn next_to(
        experiment: &'e Experiment,
        columns: &DMatrix<f64>,
        left_mm: &DVector<f64>,
        used: &[bool],
    ) -> Option<Self> {
        let fitted = Fitted {
            row_weights: &DVector::repeat(experiment.rows(), 1.0),
            residual_mm: left_mm,
            predicted_mm: &(experiment.readings_mm() - left_mm),
            used,
            own: None,
            other: None,
        };
        let left_out = experiment.unused_rows(used).count();
        let degrees_of_freedom = experiment.rows().saturating_sub(left_out + columns.ncols());
        let on_rows = |rows: &Rows<'e>, _: &_| Ok::<_, Infallible>(rows.of(columns.clone()));
        let Ok(noise) = Self::learn(experiment, &fitted, degrees_of_freedom, on_rows);
        noise
    }

    /// Standard uncertainties of numbers, each the sum of all readings times a column of `shares`: rows as in the experiment, inside units per mm.
    pub fn u(&self, shares: &DMatrix<f64>, beyond: BeyondModel) -> DVector<f64> {
        let mut weighted = shares.clone();
        weighted.column_iter_mut().for_each(|mut column| column.component_div_assign(&self.row_weights));
        let everything = 0..self.experiment.points.len();
        let rows = 0..weighted.nrows();
        let blocks = |visit: Visit<'_>| visit(everything.clone(), rows.clone(), weighted.as_view());
        let columns = Columns { width: shares.ncols(), blocks: &blocks };
        let itself = DMatrix::identity(shares.ncols(), shares.ncols());
        let nothing = DMatrix::zeros(shares.ncols(), shares.ncols());
        let covariance = self.covariance(&columns, &itself, &nothing, beyond);
        covariance.diagonal().map(|variance| variance.max(0.0).sqrt())
    }

    /// Of x = T Σ_i a_i r_i, r the weighted readings, a_i the rows of `columns`, T = `turn`; `beforehand`: what priors add to Σ a_i r_i.
    pub(crate) fn covariance(
        &self,
        columns: &Columns<'_>,
        turn: &DMatrix<f64>,
        beforehand: &DMatrix<f64>,
        beyond: BeyondModel,
    ) -> DMatrix<f64> {
        let Self { remainder, mode, .. } = self;
        let (of_nodes, of_white) = self.sums(columns);
        let freedom = self.degrees_of_freedom as f64;
        let white_left = (freedom - beyond.taken_off as f64).max(1.0) / freedom;
        let s_squared_mm = (mode.s() * remainder.unit_mm).powi(2) / white_left;
        let constant = turn * (of_white * s_squared_mm + beforehand) * turn.transpose();
        let influence = of_nodes * turn.transpose();
        let constant = constant + self.of_display(&influence);
        let influence = influence * remainder.unit_mm;
        let not_corrected = self.correction(&influence);
        let mut of_kernels = remainder.kernels.through(&influence.cast());
        for (kernel, of_kernel) in remainder.kernels.list.iter().zip(&mut of_kernels) {
            if beyond.patterns == Patterns::Described && kernel.part == Part::Pattern {
                of_kernel.fill(0.0);
            }
        }
        mixed(&constant, &of_kernels, &self.draws) + &not_corrected * not_corrected.transpose()
    }

    /// Sizes of its parts.
    pub(crate) fn parts(&self) -> Vec<NoisePart> {
        let (kernels, unit_mm) = (&self.remainder.kernels, self.remainder.unit_mm);
        let sigma_mm = |part: Part| {
            let own = (0..kernels.list.len()).filter(|&k| kernels.list[k].part == part);
            unit_mm * own.map(|k| mean_of(&self.draws, k)).sum::<f64>().sqrt()
        };
        let white = NoisePart { name: "white", sigma_mm: self.mode.white() * unit_mm };
        let parts = PARTS.map(|(part, name)| NoisePart { name, sigma_mm: sigma_mm(part) });
        std::iter::once(white).chain(parts.into_iter().filter(|part| part.sigma_mm > 0.0)).collect()
    }

    /// δ: what weighting the readings by the learned noise would add to each number; `influence`: Hᵀ summed for each node.
    fn correction(&self, influence: &DMatrix<f64>) -> DVector<f64> {
        let (here, remainder) = (&self.mode.here, &self.remainder);
        let on_basis = &here.cofactor * here.weighted.tr_mul(&remainder.y).cast::<f64>();
        influence.tr_mul(&(remainder.basis.map(f64::from) * on_basis))
    }

    /// Sums of the used rows of A for each node, and Σ W_i q_i a_i a_iᵀ over all used rows in units of the white variance of a node.
    fn sums(&self, columns: &Columns<'_>) -> (DMatrix<f64>, DMatrix<f64>) {
        let Self { experiment, used, white, .. } = self;
        let rows = &self.remainder.rows;
        let of_nodes = on_nodes(experiment, columns, rows, |point| f64::from(u8::from(used[point])));
        let node_of_point = rows.node_of_points();
        let averaged: Vec<f64> =
            (0..rows.points.points.len()).map(|node| (rows.points_of(node).len() as f64).sqrt()).collect();
        let mut root = vec![0.0; experiment.rows()];
        for (point, &node) in node_of_point.iter().enumerate() {
            for (row, of_node) in experiment.rows_of(point).zip(rows.points.rows_of(node)) {
                root[row] = averaged[node] * white[of_node].sqrt();
            }
        }
        experiment.unused_rows(used).for_each(|row| root[row] = 0.0);
        let mut of_white = DMatrix::zeros(columns.width, columns.width);
        (columns.blocks)(&mut |_, rows, columns| {
            let mut chosen = columns.into_owned();
            for (k, row) in rows.enumerate() {
                chosen.row_mut(k).scale_mut(root[row]);
            }
            of_white.gemm_tr(1.0, &chosen, &chosen, 1.0);
        });
        (of_nodes, of_white)
    }

    /// What a coarse display adds, which errs alike at like readings: the saw of its step d has the amplitude d/πn in its harmonic n.
    /// Learning takes it off (docs/design/statistics.md §1.1), the estimate does not.
    fn of_display(&self, influence: &DMatrix<f64>) -> DMatrix<f64> {
        let remainder = &self.remainder;
        let mut sum = DMatrix::zeros(influence.ncols(), influence.ncols());
        let Some(display) = &remainder.coarse_display else { return sum };
        let mut weighted = influence.clone();
        weighted.column_iter_mut().for_each(|mut column| column.component_mul_assign(&remainder.root));
        let saw = remainder.rows.of(display.saw(remainder.rows.whole(), &self.predicted_mm));
        let seen = weighted.transpose() * saw;
        for (k, column) in seen.column_iter().enumerate() {
            let amplitude_mm = display.step_mm / (std::f64::consts::PI * Display::harmonic(k));
            sum += column * column.transpose() * (0.5 * amplitude_mm.powi(2));
        }
        sum
    }
}

/// The columns of the points summed for each node, each point with its share.
pub(crate) fn on_nodes(
    experiment: &Experiment,
    columns: &Columns<'_>,
    rows: &Rows<'_>,
    share: impl Fn(usize) -> f64,
) -> DMatrix<f64> {
    let (node_of_point, width) = (rows.node_of_points(), columns.width);
    let mut summed = DMatrix::zeros(rows.points.rows(), width);
    (columns.blocks)(&mut |points, of_points, columns| {
        for point in points.filter(|&point| share(point) > 0.0) {
            let of_node = rows.points.rows_of(node_of_point[point]);
            for (to, from) in of_node.zip(experiment.rows_of(point)) {
                for k in 0..width {
                    summed[(to, k)] += share(point) * columns[(from - of_points.start, k)];
                }
            }
        }
    });
    summed
}

/// q: the square of what the noise leaves as white in every row, over what is expected of it.
fn squares(mode: &Mode, precision: &DMatrix<Real>) -> DVector<f64> {
    let expected = precision.diagonal();
    let of_all = mode.here.sigma.inverse.diagonal();
    DVector::from_fn(expected.len(), |row, _| match expected[row] > MOST_FITTED * of_all[row] {
        true => f64::from(mode.here.py[row].powi(2) / expected[row]),
        false => 1.0,
    })
}

/// Whether a run on the fly is fitted with one that was measured in another way.
fn is_mixed(experiment: &Experiment) -> bool {
    let way = |i: usize| {
        let instrument = experiment.setups[experiment.points[i].state.setup].instrument;
        (experiment.kinds[experiment.run_of_point[i]], instrument)
    };
    experiment.kinds.contains(&RunKind::OnTheFly) && (1..experiment.points.len()).any(|i| way(i) != way(0))
}

/// Mean covariance of all sizes of the noise that the run allows, each parameter with the u of which ± 1.96 u holds 95 % of their
/// mixture: a few sizes that may be large widen the mean more than the interval.
fn mixed(constant: &DMatrix<f64>, of_kernels: &[DMatrix<f64>], draws: &[Draw]) -> DMatrix<f64> {
    let mut mean = constant.clone();
    for (k, of_kernel) in of_kernels.iter().enumerate() {
        mean += of_kernel * mean_of(draws, k);
    }
    let scale: Vec<f64> = (0..mean.nrows())
        .map(|j| {
            let of_draw = |draw: &Draw| {
                let of_kernels = draw
                    .variances
                    .iter()
                    .zip(of_kernels)
                    .map(|(variance, of_kernel)| variance * of_kernel[(j, j)]);
                ((constant[(j, j)] + of_kernels.sum::<f64>()).max(0.0).sqrt(), draw.weight)
            };
            let u: Vec<(f64, f64)> = draws.iter().map(of_draw).collect();
            if mean[(j, j)] > 0.0 { half_width(&u) / COVERAGE_95 / mean[(j, j)].sqrt() } else { 1.0 }
        })
        .collect();
    DMatrix::from_fn(mean.nrows(), mean.ncols(), |i, j| {
        0.5 * (mean[(i, j)] + mean[(j, i)]) * scale[i] * scale[j]
    })
}

/// Mean variance of kernel k.
fn mean_of(draws: &[Draw], k: usize) -> f64 {
    draws.iter().map(|draw| draw.weight * draw.variances[k]).sum()
}
