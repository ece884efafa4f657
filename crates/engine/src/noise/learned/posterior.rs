//! What the readings say of the sizes of all kernels together, once the noise is learned.
//!
//! A machine has a part of the noise or has it not, one to one, and the readings say which: without "has it not", parts too small to be
//! seen would widen every interval of a machine that lacks them. For every choice c of parts that it has, x̂_c the mode of ln ρ of their
//! kernels and H_c = average information + precision of the prior there,
//!
//! p(z | c) ≈ p(z | x̂_c) p(x̂_c) |R_c|^½ Π_k I_k,   R_c: correlations of H_c⁻¹,   I_k: integral of the density of one size ([`super::size`])
//!
//! Draws: c by p(z | c); x by normal deviates of correlation R_c, each carried over to the density of its size; weight p(z | x) p(x)/q(x), at
//! most √n times the mean of all n [Ionides 2008]. Sizes are drawn together because parts resemble each other: drift over a pass looks like
//! the offset of a pass, and with the others held where they are most probable either would be known far too well. z: the readings,
//! compressed ([`super::compressed`]).

use super::Real;
use super::compressed::{Compressed, Here, variances};
use super::kernel::{Kernel, Part};
use super::kernels::Kernels;
use super::lattice::places;
use super::mode::{LONGEST_STEP, Mode, SHORTER};
use super::size::{Density, OfOne};
use crate::solve::normal::{below, deviate};
use nalgebra::{DMatrix, DVector};

const STEPS: usize = 8;
/// Expected gain of a step below which it is not made, ln.
const GAIN_LN: f64 = 0.05;
/// A step that gains nothing at this share of its length is not made.
const SHORTEST: f64 = 0.04;

/// One choice of sizes.
pub(crate) struct Draw {
    /// Those of all draws add up to 1.
    pub weight: f64,
    /// Of the kernels, in units of the square of those of the readings.
    pub variances: Vec<f64>,
}

/// `precision`: P at the mode.
pub(crate) fn draws(
    mode: &Mode,
    precision: &DMatrix<Real>,
    kernels: &Kernels,
    y: &DVector<Real>,
) -> Vec<Draw> {
    let at_mode = variances(mode);
    let of_white = |(kernel, at_mode): (&Kernel, &f64)| if kernel.is_white() { *at_mode } else { 0.0 };
    let white: Vec<f64> = kernels.list.iter().zip(&at_mode).map(of_white).collect();
    let compressed = Compressed::new(mode, precision, kernels, y);
    let posterior = Posterior { compressed, kernels, ln_rho: &mode.x()[1..] };
    let choices = Choices::new(posterior.choices());
    let of_place = |place: Vec<f64>| {
        let (first, others) = place.split_first()?;
        let (choice, ln_share) = choices.at(*first)?;
        let (x, ln_density) = choice.at(others);
        let ln = posterior.at(&choice.kernels, &x)?.ln_density - ln_density - ln_share;
        let mut variances = white.clone();
        choice.kernels.iter().zip(x.iter()).for_each(|(&k, x)| variances[k] = at_mode[k] * (2.0 * x).exp());
        Some((ln, variances))
    };
    let drawn: Vec<(f64, Vec<f64>)> = places(1 + at_mode.len()).filter_map(of_place).collect();
    if drawn.is_empty() {
        // Rounding leaves no covariance but that of the mode.
        return vec![Draw { weight: 1.0, variances: at_mode }];
    }
    let weights = weights(drawn.iter().map(|(ln, _)| *ln));
    drawn.into_iter().zip(weights).map(|((_, variances), weight)| Draw { weight, variances }).collect()
}

/// Weights that add up to 1 from their logarithms, none larger than √n times the mean.
fn weights(ln: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let most = ln.clone().fold(f64::NEG_INFINITY, f64::max);
    let mut weights: Vec<f64> = ln.map(|ln| (ln - most).exp()).collect();
    let largest = weights.iter().sum::<f64>() / (weights.len() as f64).sqrt();
    weights.iter_mut().for_each(|weight| *weight = weight.min(largest));
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
}

/// All choices of parts, with the probability of each.
struct Choices(Vec<(Choice, f64)>);

/// A choice of parts at its mode.
struct Choice {
    kernels: Vec<usize>,
    /// x̂: ln ρ of those less ln ρ̂ of all kernels together.
    x: DVector<f64>,
    densities: Vec<Density>,
    /// R = L Lᵀ: L, and ½ ln|R|.
    root: DMatrix<f64>,
    ln_root: f64,
    /// ln p(z | c), but for a constant.
    ln_evidence: f64,
}

/// The posterior at some sizes.
struct At {
    ratios: Vec<f64>,
    here: Here,
    /// ln p(z | x) p(x), without √2π to the number of kernels.
    ln_density: f64,
}

struct Posterior<'a> {
    compressed: Compressed,
    kernels: &'a Kernels,
    /// ln ρ̂.
    ln_rho: &'a [f64],
}

impl Choices {
    fn new(choices: Vec<Choice>) -> Self {
        let most = choices.iter().map(|choice| choice.ln_evidence).fold(f64::NEG_INFINITY, f64::max);
        let whole: f64 = choices.iter().map(|choice| (choice.ln_evidence - most).exp()).sum();
        let share = |choice: Choice| {
            let share = (choice.ln_evidence - most).exp() / whole;
            (choice, share)
        };
        Self(choices.into_iter().map(share).collect())
    }

    /// The choice at a place between 0 and 1, and ln of its probability.
    fn at(&self, mut place: f64) -> Option<(&Choice, f64)> {
        let is_it = |(_, share): &&(Choice, f64)| {
            place -= share;
            place < 0.0
        };
        let found = self.0.iter().find(is_it).or(self.0.last());
        found.map(|(choice, share)| (choice, share.ln()))
    }
}

impl Choice {
    /// Sizes at a place of the unit cube, and ln of their density without √2π to their number.
    fn at(&self, place: &[f64]) -> (DVector<f64>, f64) {
        let places = place.iter().take(self.x.len()).map(|place| deviate(*place));
        let z = DVector::from_iterator(self.x.len(), places);
        let together = &self.root * &z;
        // q(x) = N(ζ; 0, R)/Π N(ζ_k; 0, 1) · Π q_k(x_k),   ζ = L z
        let mut ln_density = 0.5 * (together.norm_squared() - z.norm_squared()) - self.ln_root;
        let x = DVector::from_fn(z.len(), |k, _| {
            let (off, density) = self.densities[k].quantile(below(together[k]));
            ln_density += density.ln() + 0.5 * (2.0 * std::f64::consts::PI).ln();
            self.x[k] + off
        });
        (x, ln_density)
    }
}

impl Posterior<'_> {
    /// Of the parts that there are kernels of; each begins at the mode of one that has a part more.
    fn choices(&self) -> Vec<Choice> {
        let has = |part: &Part| self.kernels.list.iter().any(|kernel| kernel.part == *part);
        let parts: Vec<Part> = Part::OPTIONAL.into_iter().filter(has).collect();
        let mut found: Vec<Option<Choice>> = Vec::new();
        for absent in 0..1_usize << parts.len() {
            let is_there = |kernel: &Kernel| {
                let at = parts.iter().position(|part| *part == kernel.part);
                at.is_some_and(|at| absent >> at & 1 == 0)
            };
            let kernels: Vec<usize> =
                (0..self.ln_rho.len()).filter(|&k| is_there(&self.kernels.list[k])).collect();
            // The lowest of its bits less: of those before.
            let more = found.get(absent & absent.wrapping_sub(1)).and_then(Option::as_ref);
            let start = |k: &usize| {
                let at =
                    |more: &Choice| more.kernels.iter().position(|other| other == k).map(|at| more.x[at]);
                more.and_then(at).unwrap_or(0.0)
            };
            let start = DVector::from_iterator(kernels.len(), kernels.iter().map(start));
            found.push(self.mode(kernels, start));
        }
        found.into_iter().flatten().collect()
    }

    /// r of all kernels where only some are there.
    fn ratios(&self, kernels: &[usize], x: &DVector<f64>) -> Vec<f64> {
        let mut ratios = vec![0.0; self.ln_rho.len()];
        kernels.iter().zip(x.iter()).for_each(|(&k, x)| ratios[k] = (2.0 * x).exp());
        ratios
    }

    /// ln ρ less the mean of its prior.
    fn off(&self, kernel: usize, x: f64) -> f64 {
        self.ln_rho[kernel] + x - self.kernels.list[kernel].mean_ln
    }

    /// `None` where rounding leaves no covariance.
    fn at(&self, kernels: &[usize], x: &DVector<f64>) -> Option<At> {
        let ratios = self.ratios(kernels, x);
        let here = self.compressed.at(&ratios)?;
        let of_prior = |(&k, x): (&usize, &f64)| {
            let precision = self.kernels.list[k].precision();
            0.5 * (precision.ln() - precision * self.off(k, *x).powi(2))
        };
        let ln_density = here.log_likelihood + kernels.iter().zip(x.iter()).map(of_prior).sum::<f64>();
        Some(At { ratios, here, ln_density })
    }

    /// Newton steps from `x`. `None` where rounding leaves no covariance.
    fn mode(&self, kernels: Vec<usize>, mut x: DVector<f64>) -> Option<Choice> {
        let precision = |k: usize| self.kernels.list[kernels[k]].precision();
        let mut at = self.at(&kernels, &x)?;
        let mut steps = 0..STEPS;
        loop {
            let seen = self.compressed.seen(&at.here, &at.ratios, &kernels);
            let mut information = seen.information.clone();
            let mut gradient = &seen.squares - &seen.traces;
            for k in 0..kernels.len() {
                gradient[k] -= precision(k) * self.off(kernels[k], x[k]);
                information[(k, k)] += precision(k);
            }
            let factor = information.clone().cholesky()?;
            let step = factor.solve(&gradient);
            let next = match 0.5 * gradient.dot(&step) > GAIN_LN && steps.next().is_some() {
                true => self.climb(&kernels, &x, at.ln_density, step),
                false => None,
            };
            if let Some(next) = next {
                (x, at) = next;
                continue;
            }
            let covariance = factor.inverse();
            let u = covariance.diagonal().map(f64::sqrt);
            let density = |k: usize| {
                let of_one = OfOne {
                    trace: seen.traces[k],
                    square: seen.squares[k],
                    information: seen.information[(k, k)],
                };
                let stretch = u[k] * information[(k, k)].sqrt();
                Density::new(&of_one, self.off(kernels[k], x[k]), precision(k), stretch)
            };
            let densities: Vec<Density> = (0..kernels.len()).map(density).collect();
            let correlation =
                DMatrix::from_fn(kernels.len(), kernels.len(), |i, j| covariance[(i, j)] / (u[i] * u[j]));
            let correlation = correlation.cholesky()?;
            let ln_root = 0.5 * correlation.ln_determinant();
            let of_sizes: f64 = densities.iter().map(|density| density.ln_integral).sum();
            let ln_evidence = at.ln_density + ln_root + of_sizes;
            return Some(Choice { kernels, x, densities, root: correlation.unpack(), ln_root, ln_evidence });
        }
    }

    /// The longest share of a step that gains.
    fn climb(
        &self,
        kernels: &[usize],
        x: &DVector<f64>,
        ln_density: f64,
        mut step: DVector<f64>,
    ) -> Option<(DVector<f64>, At)> {
        step *= (LONGEST_STEP / step.amax()).min(1.0);
        let mut share = 1.0;
        while share > SHORTEST {
            let next = x + &step * share;
            if let Some(gained) = self.at(kernels, &next).filter(|gained| gained.ln_density > ln_density) {
                return Some((next, gained));
            }
            share *= SHORTER;
        }
        None
    }
}

#[cfg(test)]
mod tests;
