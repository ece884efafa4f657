//! Single samples far from their neighbours, found as they come.
//!
//! A sample is an outlier when a component is further from the median of the seven samples around it than nine times the noise. The
//! noise follows the median distance by stochastic approximation: s ← s·(1 ± η). Three or more alike in a row
//! move the median itself and are kept: a step or a spike of the machine is no outlier.
//! Limits: not judged beside a pause; the first 64 samples of a setup only set the scale; the last three are not judged.

use super::Sample;
use std::collections::VecDeque;

/// Samples on each side.
const SIDE: usize = 3;
const SIGMAS: f64 = 9.0;
/// Median distance of a sample of white noise from the median of seven with itself among them, in standard deviations
/// (by simulation).
const MEDIAN_DISTANCE: f64 = 0.55;
const LEARNING: u32 = 64;
const RATE_LEARNING: f64 = 0.2;
const RATE: f64 = 0.02;
/// Noise is never taken below this, mm.
const FINEST_MM: f64 = 1e-5;

/// The window over one stream of samples.
#[derive(Default)]
pub(super) struct Hampel {
    waiting: VecDeque<Sample>,
    around: VecDeque<(Option<f64>, [f64; 3])>,
    distance_mm: [f64; 3],
    seen: u32,
}

/// A sample with its verdict.
pub(super) struct Judged {
    pub sample: Sample,
    pub outlier: bool,
}

impl Hampel {
    /// Takes a sample; hands out the one three before it.
    pub fn push(&mut self, sample: Sample, pause_s: f64) -> Option<Judged> {
        self.around.push_back((sample.point.state.time_s, sample.departure_mm));
        if self.around.len() > 2 * SIDE + 1 {
            self.around.pop_front();
        }
        self.waiting.push_back(sample);
        if self.waiting.len() <= SIDE {
            return None;
        }
        let sample = self.waiting.pop_front()?;
        let outlier =
            self.around.len() > 2 * SIDE && !self.pauses(pause_s) && self.is_outlier(&sample.departure_mm);
        Some(Judged { sample, outlier })
    }

    /// Hands out what is left, in order, without judging it.
    pub fn drain(&mut self) -> Option<Judged> {
        self.waiting.pop_front().map(|sample| Judged { sample, outlier: false })
    }

    /// True when the samples around do not all go on from each other.
    fn pauses(&self, pause_s: f64) -> bool {
        let times = self.around.iter().map(|(time_s, _)| *time_s);
        let apart = |(a, b): (Option<f64>, Option<f64>)| {
            a.zip(b).is_some_and(|(a, b)| !(0.0..=pause_s).contains(&(b - a)))
        };
        times.clone().zip(times.skip(1)).any(apart)
    }

    fn is_outlier(&mut self, departure_mm: &[f64; 3]) -> bool {
        let learning = self.seen < LEARNING;
        self.seen = self.seen.saturating_add(1);
        let rate = if learning { RATE_LEARNING } else { RATE };
        let mut outlier = false;
        for k in 0..3 {
            let mut around = [0.0; 2 * SIDE + 1];
            around.iter_mut().zip(&self.around).for_each(|(slot, (_, departure))| *slot = departure[k]);
            around.sort_by(f64::total_cmp);
            let distance = (departure_mm[k] - around[SIDE]).abs();
            let usual = &mut self.distance_mm[k];
            outlier |= !learning && distance > SIGMAS * (*usual / MEDIAN_DISTANCE).max(FINEST_MM);
            if *usual == 0.0 {
                *usual = distance;
            } else {
                *usual *= if distance > *usual { 1.0 + rate } else { 1.0 - rate };
            }
        }
        outlier
    }
}
