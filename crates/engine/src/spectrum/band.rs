//! Which waves a set of positions can show.

use std::f64::consts::{PI, TAU};
use trunnion_core::statistics::upper_median;

/// Positions closer than this share of their span are one position.
const SAME: f64 = 1e-6;
/// Share of its height that the spectral window must keep at 2π/step for positions to count as a regular grid.
const REGULAR: f64 = 0.98;

/// Angular frequencies (rad per unit of position) that positions can show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Band {
    /// From the first to the last position.
    pub span: f64,
    /// Median distance of neighbours.
    pub step: f64,
    /// True when waves of ω and 2π/step − ω give the same readings.
    pub regular: bool,
}

impl Band {
    /// `None` for fewer than [`FEWEST`] distinct positions.
    pub fn of(positions: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = positions.filter(|x| x.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let span = sorted.last()? - sorted.first()?;
        sorted.dedup_by(|next, before| *next - *before <= SAME * span);
        if span <= 0.0 || sorted.len() < FEWEST {
            return None;
        }
        let steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let median = upper_median(&steps)?;
        // Few large gaps leave the median step; a grid is what the spectral window says.
        let window = |omega: f64| {
            let (cos, sin) = sorted
                .iter()
                .fold((0.0, 0.0), |(cos, sin), x| (cos + (omega * x).cos(), sin + (omega * x).sin()));
            f64::hypot(cos, sin) / sorted.len() as f64
        };
        Some(Self { span, step: median, regular: window(TAU / median) > REGULAR })
    }

    /// Distance of independent frequencies.
    pub fn resolution(&self) -> f64 {
        TAU / self.span
    }

    /// The lowest: two waves in the span. Slower ones are trends, as drift is.
    pub fn low(&self) -> f64 {
        2.0 * self.resolution()
    }

    /// The highest: the Nyquist frequency π/step of a grid; twice that where positions are uneven and tell the two apart.
    pub fn high(&self) -> f64 {
        if self.regular { PI / self.step } else { TAU / self.step }
    }

    /// How many independent frequencies it holds.
    pub fn independent(&self) -> f64 {
        ((self.high() - self.low()) / self.resolution()).max(1.0)
    }

    /// The next faster wave that gives the same readings on these positions.
    pub fn alias(&self, omega: f64) -> Option<f64> {
        self.regular.then(|| TAU / self.step - omega)
    }
}

/// Fewer positions show no wave: offset, slope, and a wave with its frequency are five numbers, and three are left to deny it.
const FEWEST: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_its_nyquist_limit_and_uneven_positions_do_not() {
        let grid = Band::of((0..180).map(|i| 0.9 + 0.06 * f64::from(i))).unwrap();
        assert!(grid.regular);
        // 0.25 mm and 0.0789 mm on steps of 0.06 mm: 1/0.06 − 1/0.25 = 12.667 waves a mm.
        let alias = TAU / grid.alias(TAU / 0.25).unwrap();
        assert!((alias - 0.078_947).abs() < 1e-5, "{alias}");
        let uneven =
            Band::of((0..180).map(|i| 0.06 * (f64::from(i) + 0.4 * (f64::from(i) * 2.4).sin()))).unwrap();
        assert!(!uneven.regular && uneven.alias(1.0).is_none());
        assert!(Band::of([1.0, 2.0, 3.0].into_iter()).is_none(), "three positions show no wave");
    }
}
