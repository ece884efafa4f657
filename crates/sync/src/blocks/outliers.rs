//! Single samples far from their neighbours, found as they come.
//!
//! Four values are what the neighbours of a sample x₀ lead to expect: (x₋₁ + x₁)/2 between them; 2x₋₁ − x₋₂ and 2x₁ − x₂ on from either side; the
//! median of the seven around it. It is an outlier when a component is further than nine times the noise from all four. So a peak, a
//! corner, a step, a slope and three alike in a row are none. Two alike in a row are outliers from eighteen times the noise on: (x₋₁ + x₁)/2 is half way.
//!
//! The noise is learned from the distances |x₀ − (x₋₁ + x₁)/2|, by stochastic approximation of their median: s ← s·(1 ± η). Smooth motion
//! hardly adds to them, and no sample is further from all four values than from this one: whatever a stationary
//! Gaussian process adds to the readings, an outlier is 9/√1.5 = 7.3 standard deviations of that distance.
//! A reading that is exactly half way says that a coarse display has not moved, not that there is no noise: nothing is learned from it.
//!
//! Limits: not judged beside a pause; the first 64 samples of a setup that show a noise only set the scale; the last three are not judged. A spike
//! that loses half of its height within a sample loses its first sample too, where the noise is that small.

use super::Sample;
use std::collections::VecDeque;

/// Samples on each side.
const SIDE: usize = 3;
const SIGMAS: f64 = 9.0;
/// Median of |x₀ − (x₋₁ + x₁)/2| of white noise in standard deviations: Φ⁻¹(¾)·√1.5.
const MEDIAN_DISTANCE: f64 = 0.826;
const LEARNING: u32 = 64;
const RATE_LEARNING: f64 = 0.2;
const RATE: f64 = 0.02;
/// Noise is never taken below this, mm.
const FINEST_MM: f64 = 1e-5;
/// Readings are half way within rounding, mm.
const ROUNDING_MM: f64 = 1e-9;

/// The window over one stream of samples.
#[derive(Default)]
pub(super) struct Outliers {
    waiting: VecDeque<Sample>,
    around: VecDeque<Neighbour>,
    noise: [Noise; 3],
}

/// What is kept of a sample in the window.
struct Neighbour {
    time_s: Option<f64>,
    departure_mm: [f64; 3],
    reading_mm: [f64; 3],
}

/// A sample with its verdict.
pub(super) struct Judged {
    pub sample: Sample,
    pub outlier: bool,
}

impl Outliers {
    /// Takes a sample; hands out the one three before it.
    pub fn push(&mut self, sample: Sample, pause_s: f64) -> Option<Judged> {
        self.around.push_back(Neighbour {
            time_s: sample.point.state.time_s,
            departure_mm: sample.departure_mm,
            reading_mm: sample.point.reading_mm,
        });
        if self.around.len() > 2 * SIDE + 1 {
            self.around.pop_front();
        }
        self.waiting.push_back(sample);
        if self.waiting.len() <= SIDE {
            return None;
        }
        let sample = self.waiting.pop_front()?;
        let outlier = self.around.len() > 2 * SIDE && !self.pauses(pause_s) && self.is_outlier();
        Some(Judged { sample, outlier })
    }

    /// Hands out what is left, in order, without judging it.
    pub fn drain(&mut self) -> Option<Judged> {
        self.waiting.pop_front().map(|sample| Judged { sample, outlier: false })
    }

    /// True when the samples around do not all go on from each other.
    fn pauses(&self, pause_s: f64) -> bool {
        let times = self.around.iter().map(|neighbour| neighbour.time_s);
        let apart = |(a, b): (Option<f64>, Option<f64>)| {
            a.zip(b).is_some_and(|(a, b)| !(0.0..=pause_s).contains(&(b - a)))
        };
        times.clone().zip(times.skip(1)).any(apart)
    }

    /// Whether the sample in the middle is one.
    fn is_outlier(&mut self) -> bool {
        let mut outlier = false;
        for k in 0..3 {
            let departures_mm = std::array::from_fn(|i| self.around[i].departure_mm[k]);
            let readings_mm = std::array::from_fn(|i| self.around[i].reading_mm[k]);
            let noise = &mut self.noise[k];
            outlier |= noise.limit_mm().is_some_and(|limit_mm| distance(departures_mm) > limit_mm);
            if from_half_way(readings_mm) > ROUNDING_MM {
                noise.learn(from_half_way(departures_mm));
            }
        }
        outlier
    }
}

/// Distance of the value in the middle from the nearest of those that its neighbours lead to expect.
fn distance(values: [f64; 2 * SIDE + 1]) -> f64 {
    let [_, a, b, here, c, d, _] = values;
    let mut sorted = values;
    sorted.sort_by(f64::total_cmp);
    [2.0 * b - a, 2.0 * c - d, sorted[SIDE]]
        .into_iter()
        .fold(from_half_way(values), |least, expected| least.min((here - expected).abs()))
}

fn from_half_way([_, _, before, here, after, _, _]: [f64; 2 * SIDE + 1]) -> f64 {
    (here - 0.5 * (before + after)).abs()
}

/// The noise of one component.
#[derive(Clone, Copy, Default)]
struct Noise {
    sigma_mm: f64,
    learned: u32,
}

impl Noise {
    /// Distance from which on a sample is an outlier; `None` while too little is known.
    fn limit_mm(&self) -> Option<f64> {
        (self.learned >= LEARNING).then_some(SIGMAS * self.sigma_mm)
    }

    fn learn(&mut self, distance_mm: f64) {
        let sigma_mm = distance_mm / MEDIAN_DISTANCE;
        let rate = if self.learned < LEARNING { RATE_LEARNING } else { RATE };
        let next_mm = match self.learned {
            0 => sigma_mm,
            _ if sigma_mm > self.sigma_mm => self.sigma_mm * (1.0 + rate),
            _ => self.sigma_mm * (1.0 - rate),
        };
        self.sigma_mm = next_mm.max(FINEST_MM);
        self.learned = self.learned.saturating_add(1);
    }
}
