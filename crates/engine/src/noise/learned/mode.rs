//! Posterior mode of the sizes of the noise (restricted maximum likelihood with a prior), by Newton steps with the average information.
//!
//! L(x) = −½ (ln|Σ| + ln|XᵀΣ⁻¹X| + yᵀPy) + ln p(ρ),   x = (ln s, ln ρ_k)
//! ∂L/∂ln ρ_k = s²ρ_k² (yᵀP K_k P y − tr P K_k) + prior,   ∂L/∂ln s = yᵀPy − ν
//! H_kl = ½ w_kᵀ P w_l + precision of the prior,   w_k = 2 s²ρ_k² K_k P y,   w_s = 2y
//! ln p(y | model) = L(x̂) − ½ ln|H(x̂)| + const                              [Gilmour 1995]

use super::Real;
use super::frame::Frame;
use super::kernel::Over;
use super::kernels::Kernels;
use super::sigma::{Projected, Sigma};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Longest step in any logarithm: a factor of 4.5 in size.
pub(super) const LONGEST_STEP: f64 = 1.5;
/// What a step that does not raise the posterior is multiplied by.
pub(super) const SHORTER: f64 = 0.35;
/// A step that loses less than this is accepted: rounding of the posterior in single precision.
const ROUNDING_LN: f64 = 1e-2;
/// Added to the information: ln s alone has no prior.
const RIDGE: f64 = 1e-6;

/// Readings and what is known of them.
pub(crate) struct Readings<'a> {
    pub kernels: &'a Kernels,
    pub y: &'a DVector<Real>,
    /// Multiple of the white variance of every row.
    pub white: &'a DVector<f64>,
    /// ln of the least white standard deviation: what the display of the readings can show.
    pub least_ln: f64,
}

/// How long to look.
#[derive(Clone, Copy)]
pub(crate) struct Effort {
    pub steps: usize,
    /// Expected gain of a step below which it is not made, ln.
    pub gain_ln: f64,
}

impl Effort {
    /// From the prior's mean.
    pub const FULL: Self = Self { steps: 12, gain_ln: 0.1 };
    /// From what some of the points say, for sizes alone: a tenth in a size is less than their own uncertainty.
    pub const SIZES: Self = Self { steps: 3, gain_ln: 0.5 };
    /// From a mode nearby. As many steps as from afar: without an effect in the model its share of the noise has far to go, and odds against a
    /// noise that stopped half way are too large.
    pub const AGAIN: Self = Self { steps: 12, gain_ln: 0.25 };
}

/// The mode for one set of columns.
#[derive(Clone)]
pub(crate) struct Mode {
    pub here: Projected,
    /// L(x̂).
    pub posterior: f64,
    /// ln|H(x̂)|.
    pub log_information: f64,
    /// s²ρ_k² tr PK_k of every kernel there.
    pub traces: Vec<f64>,
}

impl Mode {
    /// ln p(y | columns), but for a constant.
    pub fn evidence(&self) -> f64 {
        self.posterior - 0.5 * self.log_information
    }

    pub fn x(&self) -> &[f64] {
        &self.here.sigma.x
    }

    /// Of every kernel.
    pub fn rho_squared(&self) -> Vec<f64> {
        self.x()[1..].iter().map(|ln| (2.0 * ln).exp()).collect()
    }

    /// s.
    pub fn s(&self) -> f64 {
        self.x()[0].exp()
    }

    /// Root mean square of the white standard deviations of all rows.
    pub fn white(&self) -> f64 {
        self.here.sigma.white
    }
}

impl Readings<'_> {
    pub fn sigma(&self, x: &[f64]) -> Option<Arc<Sigma>> {
        Sigma::new(self.kernels, x, self.white).map(Arc::new)
    }

    /// L of columns at a Σ.
    pub fn posterior(&self, here: &Projected) -> f64 {
        let prior = self.kernels.list.iter().zip(&here.sigma.x[1..]);
        let off: f64 = prior.map(|(kernel, x)| kernel.precision() * (x - kernel.mean_ln).powi(2)).sum();
        here.likelihood - 0.5 * off
    }

    /// Climbs to the mode from the best of `starts`; `basis`: orthonormal columns X. `None` where no Σ can be formed.
    pub fn learn(&self, basis: &DMatrix<Real>, starts: &[Arc<Sigma>], effort: Effort) -> Option<Mode> {
        let projected = |start: &Arc<Sigma>| {
            let is_shown = start.x[0] >= self.least_ln;
            let start = if is_shown { start.clone() } else { self.sigma(&self.shown(start.x.clone()))? };
            let here = Projected::new(start, self.y, basis)?;
            Some((self.posterior(&here), here))
        };
        let starts = starts.iter().filter_map(projected);
        let (mut posterior, mut here) = starts.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (mut gradient, mut information, mut traces) = self.slope(&here, basis.ncols());
        for _ in 0..effort.steps {
            let Some(mut step) = self.newton_step(&here, &gradient, &information) else { break };
            if 0.5 * gradient.dot(&step) < effort.gain_ln {
                break;
            }
            step *= (LONGEST_STEP / step.amax()).min(1.0);
            let promised_ln = gradient.dot(&step);
            let climbed = self.climb(&here, posterior, basis, step, promised_ln / effort.gain_ln);
            let Some((next, reached)) = climbed else { break };
            (here, posterior) = (next, reached);
            (gradient, information, traces) = self.slope(&here, basis.ncols());
        }
        let log_information = information.cholesky().map_or(f64::INFINITY, |factor| factor.ln_determinant());
        Some(Mode { here, posterior, log_information, traces })
    }

    /// Newton's step; without ln s where that is at its least and would fall.
    fn newton_step(
        &self,
        here: &Projected,
        gradient: &DVector<f64>,
        information: &DMatrix<f64>,
    ) -> Option<DVector<f64>> {
        if here.sigma.x[0] > self.least_ln || gradient[0] >= 0.0 {
            return Some(information.clone().cholesky()?.solve(gradient));
        }
        let (gradient, information) = (gradient.clone().remove_row(0), information.clone());
        let factor = information.remove_row(0).remove_column(0).cholesky()?;
        Some(factor.solve(&gradient).insert_row(0, 0.0))
    }

    /// Sizes with a white part that the display can show.
    fn shown(&self, mut x: Vec<f64>) -> Vec<f64> {
        x[0] = x[0].max(self.least_ln);
        x
    }

    /// `promised`: what the slope promises of the step, as a multiple of what a step must gain. A shorter one that cannot gain as much
    /// is not worth a covariance.
    fn climb(
        &self,
        here: &Projected,
        posterior: f64,
        basis: &DMatrix<Real>,
        mut step: DVector<f64>,
        mut promised: f64,
    ) -> Option<(Projected, f64)> {
        loop {
            let x: Vec<f64> = here.sigma.x.iter().zip(step.iter()).map(|(x, s)| x + s).collect();
            let next = self.sigma(&self.shown(x)).and_then(|sigma| Projected::new(sigma, self.y, basis));
            if let Some(next) = next {
                let reached = self.posterior(&next);
                if reached > posterior - ROUNDING_LN {
                    return Some((next, reached));
                }
            }
            step *= SHORTER;
            promised *= SHORTER;
            if promised < 1.0 {
                return None;
            }
        }
    }

    /// Gradient and average information at one place, and the traces of the kernels.
    fn slope(&self, here: &Projected, columns: usize) -> (DVector<f64>, DMatrix<f64>, Vec<f64>) {
        let (kernels, x) = (self.kernels, &here.sigma.x);
        let precision = here.precision();
        let rows = self.y.len();
        let contracted =
            |(k, frame): (usize, &Frame)| kernels.has_pairs(k).then(|| kernels.contracted(frame, &precision));
        let contracted: Vec<Option<DMatrix<Real>>> =
            kernels.frames.iter().enumerate().map(contracted).collect();
        let folded: Vec<DMatrix<Real>> = kernels.frames.iter().map(|frame| frame.folded(&here.py)).collect();
        let mut gradient = DVector::zeros(x.len());
        gradient[0] = here.quadratic - here.sigma.rows as f64 + columns as f64;
        let mut directions: DMatrix<Real> = DMatrix::zeros(rows, x.len());
        directions.set_column(0, &(self.y * 2.0));
        let mut traces = Vec::with_capacity(kernels.list.len());
        for (k, kernel) in kernels.list.iter().enumerate() {
            let frame: &Frame = &kernels.frames[kernel.frame];
            let variance = (2.0 * (x[0] + x[1 + k])).exp();
            let (seen, trace) = match &kernel.over {
                Over::Own => {
                    let own = kernels.contracted_own(frame, &precision);
                    let trace = own.iter().map(|t| f64::from(*t)).sum::<f64>();
                    (frame.unfolded(&folded[kernel.frame]), trace)
                }
                Over::Pairs(pairs) => {
                    let seen = frame.unfolded(&(pairs * &folded[kernel.frame]));
                    let trace = contracted[kernel.frame].as_ref().map_or(0.0, |c| f64::from(pairs.dot(c)));
                    (seen, trace)
                }
            };
            let square: f64 =
                seen.iter().zip(here.py.iter()).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
            gradient[1 + k] = variance * (square - trace) - kernel.precision() * (x[1 + k] - kernel.mean_ln);
            traces.push(variance * trace);
            directions.set_column(1 + k, &(seen * (2.0 * variance) as Real));
        }
        let mut along = &precision * &directions;
        // Σ P y stands as y where P follows.
        along.set_column(0, &(&here.py * 2.0));
        let products = directions.transpose() * along;
        let mut information = products.cast::<f64>() * 0.5;
        information = (&information + information.transpose()) * 0.5;
        information[(0, 0)] += RIDGE;
        for (k, kernel) in kernels.list.iter().enumerate() {
            information[(1 + k, 1 + k)] += kernel.precision() + RIDGE;
        }
        (gradient, information, traces)
    }
}
