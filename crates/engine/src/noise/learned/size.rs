//! The density of ln ρ of one kernel next to others.
//!
//! A kernel that is seen in n equal directions, of each of which it makes up the share f at the mode v̂, has, with r = v/v̂ and
//! w = 1 + f (r − 1), the others at the mode,
//!
//! ln p(y | r) = −½ n ln w − ½ b (1/w − 1),   n f = v̂ tr PK,   b f = v̂ yᵀPKPy,   f² b = v̂² yᵀPKPKPy
//!
//! times the prior of ln ρ. Unlike the curvature at the mode this knows that a small part may be much smaller but not much larger. Not held
//! at the mode, the others make it wider: it is stretched about the mode by √(H_kk (H⁻¹)_kk).

use std::f64::consts::PI;

/// Nodes: ± 48 twelfths of the standard deviation of the prior about the mode. What lies beyond four weighs nothing.
const STEPS: i32 = 48;
const STEP: f64 = 1.0 / 12.0;
/// A kernel makes up at least this share of what it is seen in: none is seen by rounding alone.
const LEAST_SHARE: f64 = 1e-6;
/// It is never all of it: the readings have a white share.
const MOST_SHARE: f64 = 0.999;
/// Densities that differ by less are equal.
const LEVEL: f64 = 1e-9;

/// What the readings say of one kernel at the mode.
pub(super) struct OfOne {
    /// v̂ tr PK.
    pub trace: f64,
    /// v̂ yᵀPKPy.
    pub square: f64,
    /// 2v̂² yᵀPKPKPy.
    pub information: f64,
}

pub(super) struct Density {
    step: f64,
    /// At every node: density and probability of no more. Between them the density is a line.
    nodes: Vec<(f64, f64)>,
    /// ln of the integral over that of a normal deviate, of what is 1 at the mode.
    pub ln_integral: f64,
}

impl Density {
    /// `off`: ln ρ̂ − mean of its prior; `stretch`: of the distance from the mode.
    pub fn new(seen: &OfOne, off: f64, precision: f64, stretch: f64) -> Self {
        let share = 0.5 * seen.information / seen.square.max(f64::MIN_POSITIVE);
        let share = share.clamp(LEAST_SHARE, MOST_SHARE);
        let (n, b) = (seen.trace / share, seen.square / share);
        let step = STEP / precision.sqrt();
        let ln_density = |x: f64| {
            let w = 1.0 + share * (2.0 * x).exp_m1();
            let likelihood = n * w.ln() + b * (w.recip() - 1.0);
            -0.5 * (likelihood + precision * ((off + x).powi(2) - off.powi(2)))
        };
        let of_steps: Vec<f64> = (-STEPS..=STEPS).map(|at| ln_density(f64::from(at) * step)).collect();
        // The largest is at the mode but for rounding of that.
        let largest = of_steps.iter().copied().fold(0.0, f64::max);
        let step = step * stretch;
        let (mut below, mut last) = (0.0, 0.0);
        let mut nodes: Vec<(f64, f64)> = of_steps
            .iter()
            .map(|ln| {
                let density = (ln - largest).exp();
                below += 0.5 * (last + density) * step;
                last = density;
                (density, below)
            })
            .collect();
        nodes.iter_mut().for_each(|(density, probability)| {
            *density /= below;
            *probability /= below;
        });
        Self { step, nodes, ln_integral: (below / (2.0 * PI).sqrt()).ln() + largest }
    }

    /// ln ρ − ln ρ̂ that is not exceeded with this probability, and the density there.
    pub fn quantile(&self, probability: f64) -> (f64, f64) {
        let after =
            self.nodes.partition_point(|(_, below)| *below < probability).clamp(1, self.nodes.len() - 1);
        let ((from, below), (to, _)) = (self.nodes[after - 1], self.nodes[after]);
        let missing = ((probability - below) / self.step).max(0.0);
        let rise = to - from;
        let share = match rise.abs() > LEVEL * (from + to) {
            true => ((from.powi(2) + 2.0 * rise * missing).max(0.0).sqrt() - from) / rise,
            false => missing / from.max(f64::MIN_POSITIVE),
        };
        let share = share.clamp(0.0, 1.0);
        let at = f64::from(after as u32) - 1.0 + share - f64::from(STEPS);
        (at * self.step, (from + share * rise).max(f64::MIN_POSITIVE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of v/v̂ over evenly spread probabilities.
    fn mean_ratio(density: &Density) -> f64 {
        let places = (0..4000).map(|k| (f64::from(k) + 0.5) / 4000.0);
        places.map(|place| (2.0 * density.quantile(place).0).exp()).sum::<f64>() / 4000.0
    }

    /// Many directions of which it makes up nearly all: the chi-square law speaks, E[v] = q/(n − 2) for ln v flat, and the prior is wide.
    #[test]
    fn a_kernel_that_is_well_seen_has_the_mean_of_its_likelihood() {
        let n = 60.0;
        let density = Density::new(&OfOne { trace: n, square: n, information: 2.0 * n }, 0.0, 0.7, 1.0);
        assert!((mean_ratio(&density) - n / (n - 2.0)).abs() < 1e-2, "{}", mean_ratio(&density));
        assert!(density.quantile(0.02).0 < 0.0 && density.quantile(0.98).0 > 0.0);
    }

    /// The prior holds a kernel up that the readings do not show in many directions: e^2000 is no number, the size is one all the same.
    #[test]
    fn a_size_is_a_number_however_many_readings_speak() {
        let seen = OfOne { trace: 1199.0, square: 0.6, information: 1.2 };
        let density = Density::new(&seen, 0.0, 0.3, 1.0);
        assert!(mean_ratio(&density) > 0.0 && mean_ratio(&density) < 1.0, "{}", mean_ratio(&density));
        assert!(density.ln_integral.is_finite());
    }

    /// Nothing seen: the prior alone, E[v] = v̂ exp(2σ²), and as likely as with its integral 1.
    #[test]
    fn a_kernel_that_is_not_seen_has_its_prior() {
        let sigma: f64 = 0.5;
        // A share of 1e-4 in each of four directions.
        let seen = OfOne { trace: 4e-4, square: 4e-4, information: 8e-8 };
        let density = Density::new(&seen, 0.0, sigma.powi(-2), 1.0);
        let expected = (2.0 * sigma * sigma).exp();
        assert!((mean_ratio(&density) / expected - 1.0).abs() < 2e-2, "{}", mean_ratio(&density));
        assert!((density.ln_integral - sigma.ln()).abs() < 1e-2, "{}", density.ln_integral);
    }

    /// The density is the slope of the probability, stretched or not.
    #[test]
    fn a_quantile_has_the_density_that_its_neighbours_show() {
        let seen = OfOne { trace: 5.0, square: 4.0, information: 3.0 };
        for stretch in [1.0, 1.7] {
            let density = Density::new(&seen, 0.3, 0.7, stretch);
            for place in [0.03, 0.2, 0.5, 0.8, 0.97] {
                let [before, after] = [place - 1e-5, place + 1e-5].map(|place| density.quantile(place).0);
                let slope = 2e-5 / (after - before);
                let (_, stated) = density.quantile(place);
                assert!((stated / slope - 1.0).abs() < 0.02, "{place}: {stated} instead of {slope}");
            }
        }
    }
}
