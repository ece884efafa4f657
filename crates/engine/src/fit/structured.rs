//! Covariance of the parameters under the noise that the run itself shows.
//!
//! The estimate was x̂ = H r, H = (AᵀA + P)⁻¹ Aᵀ with weighted rows A and the priors P of the model. Whatever Σ is, its covariance is
//! the sandwich H Σ Hᵀ:
//!
//! C = N (Σ_i s²W_i q_i a_i a_iᵀ + Σ_k v_k AᵀK_kA + Π) N + δδᵀ,   N = (AᵀA + P)⁻¹,   q_i = (Py)_i²/P_ii
//!
//! A: the columns of the determined parameters, and of the shape numbers that the fit found ([`crate::fit::sensitivity`]).
//! s, W, K_k: the noise that a diagnosis learns (`noise::learned`, docs/design/statistics.md §1); v_k: posterior means of s²ρ_k²; Π:
//! the u² of the priors. a_i: rows of A. q_i: the square of the white part of a reading over what is expected of it, 1 on average; it holds
//! whatever the size of the white noise depends on [White 1980]. δ: from the estimate to the one that weights the readings by Σ⁻¹. Σ says
//! that the estimate errs by −δ; a correction that is known and not made is a part of the uncertainty [GUM F.2.4.5]. Where neighbours are averaged for learning, those of one mean share what is not white, and the
//! white variance of one is that of the mean times their number.
//! Limits: with few readings there is no saying what is noise. The sizes of the parts are learned for all runs together: where runs on
//! the fly are fitted with others of another instrument or at rest, what one of them shows would widen what another knows. There the
//! clusters of [`crate::fit::uncertainty`] serve.

use crate::Experiment;
use crate::fit::gauss_newton::Converged;
use crate::fit::identification::NoisePart;
use crate::fit::mixture::half_width;
use crate::fit::sensitivity::Sensitivity;
use crate::noise::learned::Real;
use crate::noise::learned::display::Display;
use crate::noise::learned::kernel::Part;
use crate::noise::learned::mode::Mode;
use crate::noise::learned::posterior::{Draw, draws};
use crate::noise::learned::remainder::{Fitted, Learned, Remainder};
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

/// What the learned noise says of a fit.
pub(crate) struct Structured {
    /// Of the determined parameters and the shape numbers that the fit found.
    pub covariance: DMatrix<f64>,
    pub parts: Vec<NoisePart>,
    pub noise: Learned,
}

/// `None` outside the limits. `other`: the noise of another fit of the same points.
pub(crate) fn structured(
    known: &Sensitivity<'_, '_>,
    fit: &Converged,
    used: &[bool],
    other: Option<&Learned>,
) -> Option<Structured> {
    let design = known.design;
    if fit.degrees_of_freedom() < FEWEST_DEGREES_OF_FREEDOM
        || known.width() == 0
        || is_mixed(design.experiment)
    {
        return None;
    }
    let fitted = Fitted {
        row_weights: &design.weights.root,
        residual_mm: &fit.residual_mm,
        predicted_mm: &fit.predicted_mm,
        used,
        other,
    };
    let means = |rows: &Rows<'_>, _: &_| Ok::<_, Infallible>(means(known, rows));
    let Ok(remainder) = Remainder::new(design.experiment, &fitted, means);
    if remainder.y.len() < 2 * remainder.basis.ncols() {
        return None;
    }
    let (noise, mode) = remainder.learn()?;
    let (kernels, unit_mm) = (&remainder.kernels, remainder.unit_mm);
    let precision = mode.here.precision();
    let draws = draws(&mode, &precision, kernels, &remainder.y);
    let s_mm = mode.s() * unit_mm;
    let white = noise.white.component_mul(&squares(&mode, &precision));
    let (of_nodes, of_white) = sums(known, &remainder.rows, used, &white);
    let cofactor = &known.cofactor;
    let constant = cofactor * (of_white * s_mm.powi(2) + prior_scores(known, fit)) * cofactor;
    let influence = of_nodes * cofactor;
    let constant = constant + of_display(&remainder, &influence, &fit.predicted_mm);
    let influence = influence * unit_mm;
    let not_corrected = correction(&remainder, &mode, &influence);
    let of_kernels = kernels.through(&influence.cast());
    let covariance = covariance(&constant, &of_kernels, &draws) + &not_corrected * not_corrected.transpose();
    let sigma_mm = |part: Part| {
        let own = (0..kernels.list.len()).filter(|&k| kernels.list[k].part == part);
        unit_mm * own.map(|k| mean_of(&draws, k)).sum::<f64>().sqrt()
    };
    let white = NoisePart { name: "white", sigma_mm: mode.white() * unit_mm };
    let parts = PARTS.map(|(part, name)| NoisePart { name, sigma_mm: sigma_mm(part) });
    let parts = std::iter::once(white).chain(parts.into_iter().filter(|part| part.sigma_mm > 0.0)).collect();
    Some(Structured { covariance, parts, noise })
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

/// δ: what weighting the readings by the learned noise would add to each parameter; `influence`: Hᵀ summed for each node.
fn correction(remainder: &Remainder<'_>, mode: &Mode, influence: &DMatrix<f64>) -> DVector<f64> {
    let here = &mode.here;
    let on_basis = &here.cofactor * here.weighted.tr_mul(&remainder.y).cast::<f64>();
    influence.tr_mul(&(remainder.basis.map(f64::from) * on_basis))
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
fn covariance(constant: &DMatrix<f64>, of_kernels: &[DMatrix<f64>], draws: &[Draw]) -> DMatrix<f64> {
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

/// The columns on the rows that are looked at, weighted.
fn means(known: &Sensitivity<'_, '_>, rows: &Rows<'_>) -> DMatrix<f64> {
    let mut shares = vec![0.0; known.design.experiment.points.len()];
    for node in 0..rows.points.points.len() {
        let points = rows.points_of(node);
        points.iter().for_each(|&point| shares[point] = 1.0 / points.len() as f64);
    }
    on_nodes(known, rows, |point| shares[point])
}

/// The columns of the points summed for each node, each point with its share.
fn on_nodes(known: &Sensitivity<'_, '_>, rows: &Rows<'_>, share: impl Fn(usize) -> f64) -> DMatrix<f64> {
    let node_of_point = rows.node_of_points();
    let mut summed = DMatrix::zeros(rows.points.rows(), known.width());
    known.blocks(&mut |points, of_points, columns| {
        for point in points.filter(|&point| share(point) > 0.0) {
            let of_node = rows.points.rows_of(node_of_point[point]);
            for (to, from) in of_node.zip(known.design.experiment.rows_of(point)) {
                for k in 0..known.width() {
                    summed[(to, k)] += share(point) * columns[(from - of_points.start, k)];
                }
            }
        }
    });
    summed
}

/// Sums of the used rows of A for each node, and Σ W_i q_i a_i a_iᵀ over all used rows in units of the white variance of a node.
/// `white`: W_i q_i of the rows that are looked at.
fn sums(
    known: &Sensitivity<'_, '_>,
    rows: &Rows<'_>,
    used: &[bool],
    white: &DVector<f64>,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let experiment = known.design.experiment;
    let of_nodes = on_nodes(known, rows, |point| f64::from(u8::from(used[point])));
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
    let mut of_white = DMatrix::zeros(known.width(), known.width());
    known.blocks(&mut |_, rows, columns| {
        let mut chosen = columns.into_owned();
        for (k, row) in rows.enumerate() {
            chosen.row_mut(k).scale_mut(root[row]);
        }
        of_white.gemm_tr(1.0, &chosen, &chosen, 1.0);
    });
    (of_nodes, of_white)
}

/// What a coarse display adds, which errs alike at like readings: the saw of its step d has the amplitude d/πn in its harmonic n.
/// Learning takes it off (docs/design/statistics.md §1.1), the fit does not.
fn of_display(
    remainder: &Remainder<'_>,
    influence: &DMatrix<f64>,
    predicted_mm: &DVector<f64>,
) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(influence.ncols(), influence.ncols());
    let Some(display) = &remainder.coarse_display else { return sum };
    let mut weighted = influence.clone();
    weighted.column_iter_mut().for_each(|mut column| column.component_mul_assign(&remainder.root));
    let saw = remainder.rows.of(display.saw(remainder.rows.whole(), predicted_mm));
    let seen = weighted.transpose() * saw;
    for (k, column) in seen.column_iter().enumerate() {
        let amplitude_mm = display.step_mm / (std::f64::consts::PI * Display::harmonic(k));
        sum += column * column.transpose() * (0.5 * amplitude_mm.powi(2));
    }
    sum
}

/// Π: a prior enters as a reading w x = w x₀ that errs by w u.
fn prior_scores(known: &Sensitivity<'_, '_>, fit: &Converged) -> DMatrix<f64> {
    let determined = &fit.datum.determined;
    let of_model = known.design.joint.priors.iter().zip(&fit.prior_weights);
    let of_model = of_model.filter_map(|(prior, weight)| {
        Some((determined.iter().position(|j| *j == prior.parameter)?, *weight, prior.u))
    });
    let of_numbers = known.numbers.iter().enumerate();
    let of_numbers = of_numbers.map(|(k, number)| (determined.len() + k, number.weight, number.u_beforehand));
    let mut scores = DMatrix::zeros(known.width(), known.width());
    for (k, weight, u) in of_model.chain(of_numbers) {
        scores[(k, k)] += (weight * weight * u).powi(2);
    }
    scores
}
