//! What the readings say of the sizes of all kernels together, once the noise is learned.
//!
//! A machine has a part of the noise or has it not, one to one, and the readings say which: without "has it not", parts too small to be
//! seen would widen every interval of a machine that lacks them. For every choice c of parts that it has, x̂_c the mode of ln ρ of their
//! kernels and H_c = average information + precision of the prior there,
//!
//! p(z | c) ≈ p(z | x̂_c) p(x̂_c) |R_c|^½ Π_k I_k,   R_c: correlations of H_c⁻¹,   I_k: integral of the density of one size ([`super::size`])
//!
//! Draws: c by p(z | c); x by normal deviates ζ of correlation R_c, each carried over to the density of its size; weight p(z | x) p(x)/q(x).
//! Where few draws count, more are made from proposals fitted to those that there are ([`super::proposal`]). Sizes are drawn together because
//! parts resemble each other: drift over a pass looks like the offset of a pass, and with the others held where they are most probable
//! either would be known far too well. z: the readings, compressed ([`super::compressed`]).

use super::Real;
use super::choice::Choice;
use super::compressed::{Compressed, Here, variances};
use super::kernel::{Kernel, Part};
use super::kernels::Kernels;
use super::mode::{LONGEST_STEP, Mode, SHORTER};
use super::proposal::{Place, Proposal, count};
use super::size::{Density, OfOne};
use crate::solve::logarithms::{log_mean_exp, shares_of};
use nalgebra::{DMatrix, DVector};

const STEPS: usize = 8;
/// Expected gain of a step below which it is not made, ln.
const GAIN_LN: f64 = 0.05;
/// A step that gains nothing at this share of its length is not made.
const SHORTEST: f64 = 0.04;

/// At most so many rounds of draws, and none more once so many of them count: sums of their sizes are then good to 5 %, as 1/√500.
const ROUNDS: usize = 3;
const ENOUGH: f64 = 500.0;

/// Draws that weigh less than this share of the mean are left out: all of them together weigh less than this share of all.
const NEGLIGIBLE: f64 = 1e-4;

/// One choice of sizes.
pub(crate) struct Draw {
    /// Those of all draws add up to 1.
    pub weight: f64,
    /// Of the kernels, in units of the square of those of the readings.
    pub variances: Vec<f64>,
}

/// A place drawn, and what it is.
struct Drawn {
    place: Place,
    /// ln p(z | x) p(x) as a density of ζ.
    ln_density: f64,
    variances: Vec<f64>,
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
    let choices = posterior.choices();
    let drawn = |place: Place| {
        let choice = &choices[place.choice];
        let (x, ln_volume) = choice.at(&place.deviates);
        let ln_density = posterior.at(&choice.kernels, &x)?.ln_density + ln_volume;
        let mut variances = white.clone();
        choice.kernels.iter().zip(x.iter()).for_each(|(&k, x)| variances[k] = at_mode[k] * (2.0 * x).exp());
        Some(Drawn { place, ln_density, variances })
    };
    let first = Proposal::first(&choices);
    let mut all: Vec<Drawn> = first.draws(&choices, at_mode.len(), 0).filter_map(drawn).collect();
    let mut proposals = vec![first];
    let mut ln_weights = of_mixture(&choices, &proposals, &all);
    while proposals.len() < ROUNDS && !all.is_empty() && count(&truncated(&ln_weights)) < ENOUGH {
        let first = &proposals[0];
        let over_first = |drawn: &Drawn| drawn.ln_density - first.ln_density(&choices, &drawn.place);
        let over_first: Vec<(&Place, f64)> =
            all.iter().map(|drawn| (&drawn.place, over_first(drawn))).collect();
        let nearer = first.nearer(&choices, &over_first, &ln_weights);
        all.extend(nearer.draws(&choices, at_mode.len(), proposals.len()).filter_map(drawn));
        proposals.push(nearer);
        ln_weights = of_mixture(&choices, &proposals, &all);
    }
    if all.is_empty() {
        // Rounding leaves no covariance but that of the mode.
        return vec![Draw { weight: 1.0, variances: at_mode }];
    }
    let weights = truncated(&ln_weights);
    let least = NEGLIGIBLE / all.len() as f64;
    all.into_iter()
        .zip(weights)
        .filter(|(_, weight)| *weight > least)
        .map(|(drawn, weight)| Draw { weight, variances: drawn.variances })
        .collect()
}

/// ln of the posterior over the mean density of all proposals [Veach 1995].
fn of_mixture(choices: &[Choice], proposals: &[Proposal], all: &[Drawn]) -> Vec<f64> {
    let of_draw = |drawn: &Drawn| {
        let ln: Vec<f64> =
            proposals.iter().map(|proposal| proposal.ln_density(choices, &drawn.place)).collect();
        drawn.ln_density - log_mean_exp(&ln)
    };
    all.iter().map(of_draw).collect()
}

/// Weights that add up to 1, none larger than √n times the mean [Ionides 2008].
fn truncated(ln_weights: &[f64]) -> Vec<f64> {
    let largest = (ln_weights.len() as f64).sqrt().recip();
    let mut weights = shares_of(ln_weights.iter().copied());
    weights.iter_mut().for_each(|weight| *weight = weight.min(largest));
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
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
