//! What sizes of kernels are drawn from, and how it is brought nearer to the posterior by the draws that there are.
//!
//! q(c, ζ) = s_c N(ζ − μ_c; 0, R_c),   ζ: normal deviates of the sizes, each by its own density at the mode of choice c
//!
//! The first has the shares s_c of the evidence and μ = 0. What it misses is how ln p/q₁ rises with the sizes, fitted to all draws,
//!
//! ln p/q₁ ≈ a_c + Σ_k b_k ζ_k   ⇒   s_c ∝ s_c1 exp(a_c + ½ bᵀR_cb),   μ_c = R_c b
//!
//! with weights as near to those of p as leave [`COUNTED`] of the draws: efficient importance sampling [Richard 2007]. A proposal from draws is wider
//! by [`WIDER`], so that large sizes that no draw has met are met next, and keeps [`KEPT`] of the first shares.

use super::choice::Choice;
use super::lattice::places;
use crate::solve::logarithms::shares_of;
use crate::solve::normal::deviate;
use nalgebra::{DMatrix, DVector};

/// Of six runs with few draws that count, u by proposals of this width errs by 3 to 9 % and leans by −1 to +4 %, at 1.0 by 5 to 14 % and
/// −11 to +2 % (docs/measured/worlds.md).
const WIDER: f64 = 1.2;
const KEPT: f64 = 0.1;
/// Share of the draws that count in the fit: between a seventh and a half the figures are the same.
const COUNTED: f64 = 0.25;
const BISECTIONS: usize = 20;
/// Of a and b, in draws: holds those of choices and kernels that few draws have.
const RIDGE: f64 = 1.0;

/// A place of the sizes that was drawn.
pub(super) struct Place {
    pub choice: usize,
    /// ζ of the kernels of the choice.
    pub deviates: DVector<f64>,
}

pub(super) struct Proposal {
    /// s of every choice.
    shares: Vec<f64>,
    /// μ of every choice.
    means: Vec<DVector<f64>>,
    width: f64,
}

impl Proposal {
    pub fn first(choices: &[Choice]) -> Self {
        let shares = shares_of(choices.iter().map(|choice| choice.ln_evidence));
        let means = choices.iter().map(|choice| DVector::zeros(choice.kernels.len())).collect();
        Self { shares, means, width: 1.0 }
    }

    /// `drawn`: every place with ln p/q₁; `ln_weights`: ln of p over what they were drawn from.
    pub fn nearer(&self, choices: &[Choice], drawn: &[(&Place, f64)], ln_weights: &[f64]) -> Self {
        let (of_choices, slopes) = rise(choices, drawn, &tempered(ln_weights));
        // μ and ½ bᵀμ.
        let moved = |choice: &Choice| {
            let b = DVector::from_iterator(choice.kernels.len(), choice.kernels.iter().map(|&k| slopes[k]));
            let mean = &choice.root * choice.root.tr_mul(&b);
            let gain = 0.5 * b.dot(&mean);
            (mean, gain)
        };
        let (means, gains): (Vec<DVector<f64>>, Vec<f64>) = choices.iter().map(moved).unzip();
        let ln = self.shares.iter().zip(&of_choices).zip(&gains);
        let shares = shares_of(ln.map(|((share, a), gain)| share.ln() + a + gain));
        let kept = |(share, first): (f64, &f64)| (1.0 - KEPT) * share + KEPT * first;
        Self { shares: shares.into_iter().zip(&self.shares).map(kept).collect(), means, width: WIDER }
    }

    /// `round`: draws of one round are spread evenly, those of another differ.
    pub fn draws(&self, choices: &[Choice], kernels: usize, round: usize) -> impl Iterator<Item = Place> {
        places(1 + kernels, round).filter_map(|place| {
            let (choice, others) = place.split_first()?;
            let choice = self.choice(*choice)?;
            let z = others.iter().take(self.means[choice].len()).map(|place| deviate(*place));
            let z = DVector::from_iterator(self.means[choice].len(), z);
            let deviates = &self.means[choice] + &choices[choice].root * z * self.width;
            Some(Place { choice, deviates })
        })
    }

    /// `None` where there is no choice at all.
    fn choice(&self, mut place: f64) -> Option<usize> {
        let is_it = |share: &f64| {
            place -= share;
            place < 0.0
        };
        self.shares.iter().position(is_it).or(self.shares.len().checked_sub(1))
    }

    /// ln q of a place, without √2π to the number of its kernels.
    pub fn ln_density(&self, choices: &[Choice], at: &Place) -> f64 {
        let choice = &choices[at.choice];
        let off = &at.deviates - &self.means[at.choice];
        // L is regular: it is a root of Cholesky.
        let z = choice.root.solve_lower_triangular(&off).unwrap_or(off) / self.width;
        let of_width = z.len() as f64 * self.width.ln();
        self.shares[at.choice].ln() - 0.5 * z.norm_squared() - choice.ln_root - of_width
    }
}

/// How many draws of equal weight know as much [Kong 1994]; `weights` add up to 1.
pub(super) fn count(weights: &[f64]) -> f64 {
    weights.iter().map(|weight| weight.powi(2)).sum::<f64>().recip()
}

/// The largest power of the weights of which [`COUNTED`] count, with mean 1.
fn tempered(ln_weights: &[f64]) -> Vec<f64> {
    let at = |power: f64| shares_of(ln_weights.iter().map(move |ln| power * ln));
    let enough = COUNTED * ln_weights.len() as f64;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if count(&at(middle)) > enough { low = middle } else { high = middle }
    }
    at(high).into_iter().map(|share| share * ln_weights.len() as f64).collect()
}

/// a of every choice and b of every kernel.
fn rise(choices: &[Choice], drawn: &[(&Place, f64)], weights: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let kernels = choices.iter().flat_map(|choice| &choice.kernels).max().map_or(0, |last| last + 1);
    let width = choices.len() + kernels;
    let middle =
        drawn.iter().zip(weights).map(|((_, ln), weight)| ln * weight).sum::<f64>() / drawn.len() as f64;
    let mut columns = DMatrix::zeros(drawn.len(), width);
    let mut aims = DVector::zeros(drawn.len());
    for (row, ((place, ln), weight)) in drawn.iter().zip(weights).enumerate() {
        let root = weight.sqrt();
        columns[(row, place.choice)] = root;
        for (&k, deviate) in choices[place.choice].kernels.iter().zip(place.deviates.iter()) {
            columns[(row, choices.len() + k)] = root * deviate;
        }
        aims[row] = root * (ln - middle);
    }
    let normal = columns.tr_mul(&columns) + DMatrix::identity(width, width) * RIDGE;
    // The ridge keeps it positive.
    let solved = normal.cholesky().map(|factor| factor.solve(&columns.tr_mul(&aims)));
    let solved = solved.unwrap_or_else(|| DVector::zeros(width));
    let (of_choices, slopes) = solved.as_slice().split_at(choices.len());
    (of_choices.to_vec(), slopes.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(kernels: Vec<usize>, correlation: f64) -> Choice {
        let n = kernels.len();
        let correlations = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { correlation });
        let root = correlations.cholesky().unwrap();
        let ln_root = 0.5 * root.ln_determinant();
        Choice {
            x: DVector::zeros(n),
            densities: Vec::new(),
            root: root.unpack(),
            ln_root,
            ln_evidence: 0.0,
            kernels,
        }
    }

    /// p(c, ζ) ∝ e_c N(ζ − m_c; 0, R_c), m_c = R_c b: what is fitted has no error, and the proposal is p but for its width and what it keeps.
    #[test]
    fn a_proposal_is_brought_to_where_the_posterior_is() {
        let choices = [choice(vec![0, 1, 2], 0.4), choice(vec![0, 2], -0.3)];
        let (slopes, evidence) = ([0.8, -0.5, 0.3], [0.2, 0.8]);
        let first = Proposal::first(&choices);
        let means: Vec<DVector<f64>> = choices
            .iter()
            .map(|choice| {
                let b =
                    DVector::from_iterator(choice.kernels.len(), choice.kernels.iter().map(|&k| slopes[k]));
                &choice.root * choice.root.transpose() * b
            })
            .collect();
        let posterior = Proposal { shares: evidence.to_vec(), means: means.clone(), width: 1.0 };
        let places: Vec<Place> = first.draws(&choices, 3, 0).collect();
        let ln: Vec<f64> = places
            .iter()
            .map(|place| posterior.ln_density(&choices, place) - first.ln_density(&choices, place))
            .collect();
        let drawn: Vec<(&Place, f64)> = places.iter().zip(ln.iter().copied()).collect();
        let nearer = first.nearer(&choices, &drawn, &ln);
        for ((found, mean), (share, evidence)) in
            nearer.means.iter().zip(&means).zip(nearer.shares.iter().zip(evidence))
        {
            assert!((found - mean).amax() < 0.02, "{found} instead of {mean}");
            assert!((share - (0.9 * evidence + 0.05)).abs() < 0.01, "{share}");
        }
    }

    /// Rounding may leave no choice with a covariance: the draws are none then, not a panic.
    #[test]
    fn of_no_choice_nothing_is_drawn() {
        assert_eq!(Proposal::first(&[]).draws(&[], 3, 0).count(), 0);
    }

    /// ∫ q over the place of the second choice, on a grid: its share.
    #[test]
    fn a_proposal_is_a_density() {
        let choices = [choice(vec![0], 0.0), choice(vec![0, 1], 0.6)];
        let means = vec![DVector::zeros(1), DVector::from_vec(vec![0.7, -0.4])];
        let proposal = Proposal { shares: vec![0.3, 0.7], means, width: WIDER };
        let grid = || (-60..=60).map(|i| 0.1 * f64::from(i));
        let density = |a: f64, b: f64| {
            let place = Place { choice: 1, deviates: DVector::from_vec(vec![a, b]) };
            proposal.ln_density(&choices, &place).exp() / (2.0 * std::f64::consts::PI)
        };
        let sum: f64 = grid().flat_map(|a| grid().map(move |b| (a, b))).map(|(a, b)| density(a, b)).sum();
        assert!((0.01 * sum - 0.7).abs() < 1e-3, "{}", 0.01 * sum);
    }
}
