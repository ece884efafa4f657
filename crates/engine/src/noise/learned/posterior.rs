//! What the readings say of the variance of every kernel, once the noise is learned.
//!
//! A kernel that is seen in n equal directions, of each of which it makes up the share f at the mode v̂, has, with r = v/v̂ and
//! w = 1 + f (r − 1),
//!
//! ln p(y | r) = −½ n ln w − ½ b (1/w − 1),   n f = v̂ tr PK,   b f = v̂ yᵀPKPy,   f² b = v̂² yᵀPKPKPy
//!
//! times the prior of ln ρ; the other kernels at the mode. Unlike the curvature at the mode this knows that a small part may be much
//! smaller but not much larger. The same holds of all kernels of one part together, whose common factor is r: a machine has the part or
//! has it not, one to one, and the readings say which. Without "has it not", parts too small to be seen would widen every interval of a
//! machine that lacks them. Limits: kernels are taken as independent; those that resemble each other are not.

use super::kernels::{Kernel, Kernels, Part};
use super::mode::{Mode, Seen};

/// Values of ln ρ: ± 48 twelfths of the standard deviation of its prior about the mode. What lies beyond four weighs nothing.
const STEPS: i32 = 48;
const STEP: f64 = 1.0 / 12.0;
/// A kernel makes up at least this share of what it is seen in: none is seen by rounding alone.
const LEAST_SHARE: f64 = 1e-6;

/// Prior probability that a machine has a part.
const HAS_IT: f64 = 0.5;
/// A part is never all of what it is seen in: the readings have a white share.
const MOST_SHARE: f64 = 0.999;

/// Variance of one kernel, in units of the square of those of the readings.
pub(crate) struct Size {
    pub part: Part,
    /// Where the machine has the part: ascending, with the probability of no more.
    levels: Vec<(f64, f64)>,
    /// Probability that it has not.
    absent: f64,
    pub mean: f64,
}

/// Of every kernel.
pub(crate) fn sizes(mode: &Mode, kernels: &Kernels) -> Vec<Size> {
    let absent = Part::ALL.map(|part| absent(mode, kernels, part));
    let of_kernel = |((k, kernel), seen): ((usize, &Kernel), &Seen)| {
        let densities = Densities::new(seen, mode.x()[1 + k] - kernel.mean_ln, kernel.precision());
        let at = Part::ALL.iter().position(|part| *part == kernel.part).unwrap_or(0);
        Size::new(kernel.part, at_mode(mode, k), &densities, absent[at])
    };
    kernels.list.iter().enumerate().zip(&mode.seen).map(of_kernel).collect()
}

/// v̂.
fn at_mode(mode: &Mode, k: usize) -> f64 {
    (2.0 * (mode.x()[0] + mode.x()[1 + k])).exp()
}

/// Probability that the machine has not a part.
fn absent(mode: &Mode, kernels: &Kernels, part: Part) -> f64 {
    let own: Vec<usize> = (0..kernels.list.len()).filter(|&k| kernels.list[k].part == part).collect();
    let Some(first) = own.first().map(|&k| &kernels.list[k]) else { return 1.0 };
    let sum = |of: &dyn Fn(usize) -> f64| own.iter().map(|&k| of(k)).sum::<f64>();
    let prior = sum(&|k| kernels.list[k].precision());
    let all = sum(&|k| own.iter().map(|&l| mode.information[(1 + k, 1 + l)]).sum::<f64>()) - prior;
    let seen = Seen {
        trace: sum(&|k| mode.seen[k].trace),
        square: sum(&|k| mode.seen[k].square),
        information: all.max(0.0),
    };
    let expected = sum(&|k| (2.0 * (mode.x()[0] + kernels.list[k].mean_ln)).exp());
    let off = 0.5 * (sum(&|k| at_mode(mode, k)) / expected).ln();
    let densities = Densities::new(&seen, off, first.precision());
    let without = (1.0 - HAS_IT) * densities.of_none;
    without / (without + HAS_IT * densities.mean_likelihood)
}

/// p(y | r) p(r) for r from small to large, but for a constant: the largest likelihood is 1, for those of many readings are beyond any number.
struct Densities {
    of_ratio: Vec<(f64, f64)>,
    /// p(y | r = 0) and the mean of p(y | r) over the prior.
    of_none: f64,
    mean_likelihood: f64,
}

impl Densities {
    /// `off`: ln ρ̂ − mean of its prior.
    fn new(seen: &Seen, off: f64, precision: f64) -> Self {
        let share = 0.5 * seen.information / seen.square.max(f64::MIN_POSITIVE);
        let share = share.clamp(LEAST_SHARE, MOST_SHARE);
        let (n, b) = (seen.trace / share, seen.square / share);
        let ln_likelihood = |ratio: f64| {
            let w = 1.0 + share * (ratio - 1.0);
            -0.5 * (n * w.ln() + b * (w.recip() - 1.0))
        };
        let spread = precision.sqrt().recip();
        let ln_ratio = |step: i32| f64::from(step) * spread * STEP;
        let ratios = (-STEPS..=STEPS).map(|step| (2.0 * ln_ratio(step)).exp());
        let largest = ratios.map(ln_likelihood).fold(ln_likelihood(0.0), f64::max);
        let likelihood = |ratio: f64| (ln_likelihood(ratio) - largest).exp();
        let (mut of_prior, mut sum) = (0.0, 0.0);
        let of_ratio = (-STEPS..=STEPS).map(|step| {
            let ln = ln_ratio(step);
            let (ratio, prior) = ((2.0 * ln).exp(), (-0.5 * precision * (off + ln).powi(2)).exp());
            let density = prior * likelihood(ratio);
            (of_prior, sum) = (of_prior + prior, sum + density);
            (ratio, density)
        });
        let of_ratio = of_ratio.collect();
        // The prior has the integral σ √(2π), in steps of σ · STEP.
        let whole = (2.0 * std::f64::consts::PI).sqrt() / STEP;
        Self { of_ratio, of_none: likelihood(0.0), mean_likelihood: sum / whole.max(of_prior) }
    }
}

impl Size {
    fn new(part: Part, at_mode: f64, densities: &Densities, absent: f64) -> Self {
        let total: f64 = densities.of_ratio.iter().map(|(_, density)| density).sum();
        let mean = densities.of_ratio.iter().map(|(ratio, density)| ratio * density).sum::<f64>() / total;
        let mut below = 0.0;
        let level = |(ratio, density): &(f64, f64)| {
            below += density / total;
            (at_mode * ratio, below)
        };
        let levels = densities.of_ratio.iter().map(level).collect();
        Self { part, levels, absent, mean: at_mode * mean * (1.0 - absent) }
    }

    /// The variance that is not exceeded with this probability where the machine has the part.
    pub fn quantile(&self, probability: f64) -> f64 {
        let at = self.levels.partition_point(|(_, below)| *below < probability);
        self.levels[at.min(self.levels.len() - 1)].0
    }

    /// Whether the machine has the part, at a place between 0 and 1 that all kernels of the part share.
    pub fn is_there(&self, place: f64) -> bool {
        place >= self.absent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Many directions of which it makes up nearly all: the chi-square law speaks, E[v] = q/(n − 2) for ln v flat, and the prior is wide.
    #[test]
    fn a_kernel_that_is_well_seen_has_the_mean_of_its_likelihood() {
        let n = 60.0;
        let seen = Seen { trace: n, square: n, information: 2.0 * n };
        let size = Size::new(Part::Drift, 2.0, &Densities::new(&seen, 0.0, 0.7), 0.0);
        assert!((size.mean / 2.0 - n / (n - 2.0)).abs() < 1e-2, "{}", size.mean);
        assert!(size.quantile(0.02) < size.mean && size.mean < size.quantile(0.98));
    }

    /// The prior holds a kernel up that the readings do not show in many directions: e^2000 is no number, the size is one all the same.
    #[test]
    fn a_size_is_a_number_however_many_readings_speak() {
        let seen = Seen { trace: 1199.0, square: 0.6, information: 1.2 };
        let densities = Densities::new(&seen, 0.0, 0.3);
        let size = Size::new(Part::Drift, 1.0, &densities, 0.0);
        assert!(size.mean > 0.0 && size.mean < 1.0, "{}", size.mean);
        assert!((densities.of_none / densities.mean_likelihood).is_finite());
    }

    /// Nothing seen: the prior alone, E[v] = v̂ exp(2 σ²), and no word about whether the machine has the part.
    #[test]
    fn a_kernel_that_is_not_seen_has_the_mean_of_its_prior() {
        let sigma: f64 = 0.5;
        // A share of 1e-4 in each of four directions.
        let seen = Seen { trace: 4e-4, square: 4e-4, information: 8e-8 };
        let densities = Densities::new(&seen, 0.0, sigma.powi(-2));
        let size = Size::new(Part::Drift, 1.0, &densities, 0.0);
        assert!((size.mean / (2.0 * sigma * sigma).exp() - 1.0).abs() < 1e-2, "{}", size.mean);
        assert!((densities.of_none / densities.mean_likelihood - 1.0).abs() < 1e-2);
    }
}
