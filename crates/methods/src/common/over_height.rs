//! Values at the heights of the ball as a straight line over the height.

use super::shares::Shares;

/// A straight line `at_zero + slope·h` with standard uncertainties.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub at_zero: f64,
    pub slope: f64,
    pub u_at_zero: f64,
    pub u_slope: f64,
}

/// Weights that turn values at the heights into a straight line.
pub(crate) struct Weights {
    slope: Vec<f64>,
    at_zero: Vec<f64>,
}

impl Weights {
    /// For these heights.
    pub fn of(heights_mm: &[f64]) -> Self {
        let middle = heights_mm.iter().sum::<f64>() / heights_mm.len() as f64;
        let spread: f64 = heights_mm.iter().map(|h| (h - middle).powi(2)).sum();
        let slope: Vec<f64> = heights_mm.iter().map(|h| (h - middle) / spread).collect();
        let at_zero = slope.iter().map(|w| 1.0 / heights_mm.len() as f64 - w * middle).collect();
        Self { slope, at_zero }
    }

    /// Degrees of freedom of the u of a line, at zero and of its slope, from u and degrees of freedom at the heights [GUM G.4.1, Welch-Satterthwaite].
    pub fn freedom(&self, u: &[f64], freedom: &[usize]) -> [usize; 2] {
        [&self.at_zero, &self.slope].map(|weights| {
            let variances = || weights.iter().zip(u).map(|(w, u)| (w * u).powi(2));
            let parts: f64 = variances().zip(freedom).map(|(v, freedom)| v * v / *freedom as f64).sum();
            let effective = variances().sum::<f64>().powi(2) / parts.max(f64::MIN_POSITIVE);
            // Truncated to the next lower integer, as the GUM does.
            (effective as usize).max(1)
        })
    }

    /// The same of a line in sums of readings: at zero, and its slope.
    pub fn shares(&self, values: &[&Shares]) -> [Shares; 2] {
        [&self.at_zero, &self.slope]
            .map(|weights| Shares::sum(weights.iter().copied().zip(values.iter().copied())))
    }

    /// The line through values at the heights, with their standard uncertainties.
    pub fn line(&self, values: &[f64], u: &[f64]) -> Line {
        let sum = |weights: &[f64]| weights.iter().zip(values).map(|(w, v)| w * v).sum();
        let root = |weights: &[f64]| weights.iter().zip(u).map(|(w, u)| (w * u).powi(2)).sum::<f64>().sqrt();
        Line {
            at_zero: sum(&self.at_zero),
            slope: sum(&self.slope),
            u_at_zero: root(&self.at_zero),
            u_slope: root(&self.slope),
        }
    }
}
