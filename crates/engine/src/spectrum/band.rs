//! Which waves a set of positions can show.

use super::transform::heights;
use std::f64::consts::{PI, TAU};
use trunnion_core::statistics::upper_median;

/// Frequencies looked at for each independent one: a peak between two of them keeps 90 % of its height [sinc²(1/6)].
pub(crate) const OVERSAMPLING: f64 = 3.0;
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
        let step = upper_median(&steps)?;
        // Few large gaps leave the median step; a grid is what the spectral window says.
        let window = |step: f64| {
            let phases = sorted.iter().map(|x| (TAU * x / step).sin_cos());
            let (sin, cos) = phases.fold((0.0, 0.0), |sum, (sin, cos)| (sum.0 + sin, sum.1 + cos));
            f64::hypot(cos, sin) / sorted.len() as f64
        };
        if window(step) > REGULAR {
            return Some(Self { span, step, regular: true });
        }
        let grid =
            grids(&steps, step, span).map(|step| (step, window(step))).max_by(|a, b| a.1.total_cmp(&b.1));
        Some(match grid {
            Some((step, height)) if height > REGULAR => Self { span, step, regular: true },
            _ => Self { span, step, regular: false },
        })
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
        if self.regular { self.nyquist() } else { TAU / self.step }
    }

    /// The Nyquist frequency of positions that are one step apart.
    pub fn nyquist(&self) -> f64 {
        PI / self.step
    }

    /// Frequencies ω_L at which uneven positions still repeat, lowest first: a share of every wave ω comes back at ω_L ± ω, and of what is
    /// slower than the band at ω_L itself. Passes each at even steps have them, where all positions together are uneven. None on a grid.
    ///
    /// The spectral window of n random positions exceeds w at one of M frequencies with a probability of M e^(−n w²) at most: 1 in 20
    /// here. That of positions without gaps falls as 1/(π m), m resolutions away [sinc]; gaps are granted three times as much.
    pub fn lobes(&self, positions: &[f64]) -> Vec<f64> {
        let mut sorted: Vec<f64> = positions.iter().copied().filter(|x| x.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup_by(|next, before| *next - *before <= SAME * self.span);
        let (count, step) = (sorted.len() as f64, self.resolution() / OVERSAMPLING);
        let first = FEWEST as f64 * self.resolution();
        let steps = ((self.high() - first) / step).floor();
        if self.regular || steps < 1.0 {
            return Vec::new();
        }
        let chance = ((20.0 * self.independent()).ln() / count).sqrt();
        let window: Vec<f64> = heights(&sorted, first, step, steps as usize + 1)
            .into_iter()
            .map(|height| height / count)
            .collect();
        let resolutions = |k: usize| FEWEST as f64 + k as f64 / OVERSAMPLING;
        let stands_out = |k: &usize| window[*k] > chance.max(1.0 / resolutions(*k));
        let is_peak = |k: &usize| {
            let near = |k: Option<usize>| k.and_then(|k| window.get(k)).copied().unwrap_or(0.0);
            window[*k] >= near(k.checked_sub(1)) && window[*k] > near(Some(k + 1))
        };
        (0..window.len()).filter(stands_out).filter(is_peak).map(|k| first + step * k as f64).collect()
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

/// Steps that divide the span evenly and may be that of a grid of which the positions are written with few digits: of 0.039 22 mm only
/// 0.0392 and 0.0393 mm are seen, and the median step drifts off the grid along the way. Where a share f ≤ ½ of the steps has the other value,
/// q away, the mean lies f q from the median, and the standard deviation q √(f (1 − f)) is no less. None where the steps scatter more than
/// the window of a grid bears: e^(−½ σ²) at a phase of standard deviation σ, √2 times that between neighbours.
fn grids(steps: &[f64], median: f64, span: f64) -> impl Iterator<Item = f64> {
    let usual = || steps.iter().filter(|step| **step < 1.5 * median);
    let square = usual().map(|step| (step - median).powi(2)).sum::<f64>() / usual().count().max(1) as f64;
    let most = 2.0 * -2.0 * REGULAR.ln() * (median / TAU).powi(2);
    let scatter = square.sqrt();
    let (fewest, most) = match square < most {
        true => ((span / (median + scatter)).ceil() as usize, (span / (median - scatter)).floor() as usize),
        false => (1, 0),
    };
    (fewest..=most).map(move |count| span / count as f64)
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

    #[test]
    fn passes_at_even_steps_that_do_not_meet_have_the_lobes_of_one_pass() {
        // Two passes of a turn, each at 300 even steps, the second a third of a step on and with its speed not quite even.
        let step = TAU / 300.0;
        let there = (0..300).map(|i| step * f64::from(i));
        let back = (0..300).map(|i| step * (f64::from(i) + 0.33 + 0.05 * (f64::from(i) * 2.4).sin()));
        let positions: Vec<f64> = there.chain(back).collect();
        let band = Band::of(positions.iter().copied()).unwrap();
        assert!(!band.regular && band.nyquist() > 300.0, "{band:?}");
        let lobes = band.lobes(&positions);
        assert!((lobes[0] - 300.0).abs() < 1.0, "{lobes:?}");
        // Golden section of a turn, stretched: no step comes back.
        let uneven: Vec<f64> = (0..600).map(|i| (f64::from(i) * 0.618_034).fract().powf(1.3) * TAU).collect();
        let band = Band::of(uneven.iter().copied()).unwrap();
        assert_eq!((band.regular, band.lobes(&uneven)), (false, Vec::new()));
    }

    #[test]
    fn a_grid_written_with_few_digits_is_a_grid() {
        // 26 mm in 663 steps of 0.039 215 mm, to 0.1 µm: its median step, 0.0392 mm, is a third of a step off at the end.
        let (first, last, count) = (-101.7, -75.7004, 663);
        let at = |i: usize| first + (last - first) * i as f64 / count as f64;
        let rounded = |x: f64| (x * 1e4).round() * 1e-4;
        let grid = Band::of((0..=count).map(|i| rounded(at(i)))).unwrap();
        assert!(grid.regular);
        let alias = TAU / grid.alias(TAU / 5.94).unwrap();
        assert!((alias - 0.039_476).abs() < 1e-6, "{alias}");
        assert!(TAU / grid.high() > 0.0784, "waves shorter than two steps are those of longer ones");
    }
}
