//! Against the posterior itself, summed over a grid of the sizes of two kernels that resemble each other.

use super::*;
use crate::noise::learned::mode::{Effort, Readings};
use crate::noise::learned::sigma::Projected;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const POINTS: usize = 160;
/// Offsets of four passes look like a drift that is as long as a pass or longer.
const PASSES: usize = 4;
const TAU_POINTS: f64 = 70.0;
/// ± 4.5 standard deviations of the prior in steps of a quarter.
const HALF: i32 = 18;
const STEP: f64 = 0.25;

fn pass(i: usize) -> usize {
    i * PASSES / POINTS
}

fn kernels() -> Kernels {
    let offsets = DMatrix::from_fn(POINTS, POINTS, |i, j| if pass(i) == pass(j) { 1.0 } else { 0.0 });
    let drift = DMatrix::from_fn(POINTS, POINTS, |i, j| (-(i.abs_diff(j) as f64) / TAU_POINTS).exp() as Real);
    Kernels::of_one_channel(vec![(Part::Pass, offsets, 0.25), (Part::Drift, drift, 0.15)])
}

/// White noise of 1, offsets of 0.4 and a drift of 0.6 of it.
fn readings(seed: u64) -> DVector<Real> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let offsets: Vec<f64> = (0..PASSES).map(|_| 0.4 * normal()).collect();
    let kept = (-1.0 / TAU_POINTS).exp();
    let mut drift = 0.6 * normal();
    DVector::from_fn(POINTS, |i, _| {
        drift = kept * drift + 0.6 * (1.0 - kept * kept).sqrt() * normal();
        (normal() + offsets[pass(i)] + drift) as Real
    })
}

/// What is asked of a posterior: the mean variances of both kernels, the variance of a mean of the first half against the second, and the
/// probability that there is no offset.
#[derive(Debug)]
struct Said {
    means: [f64; 2],
    step: f64,
    no_offset: f64,
}

/// wᵀ K w of both kernels, w: the mean of the first half less that of the second.
fn of_step(kernels: &Kernels) -> Vec<f64> {
    let w = DMatrix::from_fn(POINTS, 1, |i, _| (if i < POINTS / 2 { 2.0 } else { -2.0 }) / POINTS as Real);
    kernels.through(&w).iter().map(|seen| seen[(0, 0)]).collect()
}

fn said(kernels: &Kernels, draws: impl Iterator<Item = (f64, [f64; 2])>) -> Said {
    let of_step = of_step(kernels);
    let mut said = Said { means: [0.0; 2], step: 0.0, no_offset: 0.0 };
    for (weight, v) in draws {
        (0..2).for_each(|k| said.means[k] += weight * v[k]);
        said.step += weight * (of_step[0] * v[0] + of_step[1] * v[1]).sqrt();
        said.no_offset += if v[0] == 0.0 { weight } else { 0.0 };
    }
    said
}

/// Likelihoods and priors of all sizes on the grid, and of none.
fn exact(readings: &Readings<'_>, basis: &DMatrix<Real>, mode: &Mode) -> Said {
    let kernels = readings.kernels;
    let ln_s = mode.x()[0];
    let places: Vec<Option<i32>> = std::iter::once(None).chain((-HALF..=HALF).map(Some)).collect();
    let ln_rho = |k: usize, place: Option<i32>| {
        let kernel = &kernels.list[k];
        place.map_or(-12.0, |place| kernel.mean_ln + f64::from(place) * STEP / kernel.precision().sqrt())
    };
    let prior = |place: Option<i32>| {
        let density = |place: i32| {
            STEP * (-0.5 * (f64::from(place) * STEP).powi(2)).exp() / (2.0 * std::f64::consts::PI).sqrt()
        };
        place.map_or(1.0, density)
    };
    let mut found = Vec::new();
    for &first in &places {
        for &second in &places {
            let x = vec![ln_s, ln_rho(0, first), ln_rho(1, second)];
            let here = Projected::new(readings.sigma(&x).unwrap(), readings.y, basis).unwrap();
            let variance =
                |k: usize, place: Option<i32>| place.map_or(0.0, |_| (2.0 * (ln_s + x[1 + k])).exp());
            let variances = [variance(0, first), variance(1, second)];
            found.push((here.likelihood + (prior(first) * prior(second)).ln(), variances));
        }
    }
    let most = found.iter().map(|(ln, _)| *ln).fold(f64::NEG_INFINITY, f64::max);
    let whole: f64 = found.iter().map(|(ln, _)| (ln - most).exp()).sum();
    said(kernels, found.into_iter().map(|(ln, variances)| ((ln - most).exp() / whole, variances)))
}

/// Ten runs: each by itself near the sum over the grid, on the whole without a lean.
#[test]
fn sizes_of_kernels_that_resemble_each_other_are_drawn_as_they_are_distributed() {
    let (mut of_means, mut of_steps) = (0.0, 0.0);
    for seed in 0..10 {
        let (kernels, y) = (kernels(), readings(seed));
        let basis = DMatrix::from_element(POINTS, 1, (POINTS as Real).sqrt().recip());
        let white = DVector::from_element(POINTS, 1.0);
        let readings = Readings { kernels: &kernels, y: &y, white: &white, least_ln: -9.0 };
        let first: Vec<f64> = std::iter::once(0.0).chain(kernels.means()).collect();
        let mode = readings.learn(&basis, &[readings.sigma(&first).unwrap()], Effort::FULL).unwrap();
        let exact = exact(&readings, &basis, &mode);
        let draws = draws(&mode, &mode.here.precision(), &kernels, &y);
        let drawn =
            said(&kernels, draws.iter().map(|draw| (draw.weight, [draw.variances[0], draw.variances[1]])));
        assert!((drawn.no_offset - exact.no_offset).abs() < 0.12, "{seed}: {drawn:?} instead of {exact:?}");
        assert!((drawn.step / exact.step - 1.0).abs() < 0.12, "{seed}: {drawn:?} instead of {exact:?}");
        of_means += (0..2).map(|k| drawn.means[k] / exact.means[k] - 1.0).sum::<f64>() / 20.0;
        of_steps += (drawn.step / exact.step - 1.0) / 10.0;
    }
    assert!(of_means.abs() < 0.1 && of_steps.abs() < 0.04, "{of_means} {of_steps}");
}
