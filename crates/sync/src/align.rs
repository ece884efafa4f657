//! Probes and axes brought to common instants.
//!
//! The instants are those of the first channel; the other channels are interpolated linearly, the axes by a cubic
//! through the samples around (Catmull-Rom with unequal steps; velocity is its derivative). Acceleration is the
//! change of velocity at the axis samples, linear between them. Nothing is extrapolated: an instant without axis samples
//! on both sides is left out and counted, a channel without samples on both sides is NaN.
//!
//! What comes out is in order of time. It depends only on the samples and their order, so give a recording back in
//! the order in which it was recorded.

mod axes;

pub use axes::{AxisState, ReversalBand};

use crate::interval::{Interval, USUAL_GAP_S};
use axes::AxisHistory;
use std::collections::VecDeque;
use trunnion_core::{AxisSample, ProbeSample};

/// Limits of the alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignLimits {
    /// Longest distance of two axis samples to interpolate between, s.
    pub axis_gap_s: f64,
    /// Longest distance of two samples of one channel to interpolate between, s; longer for a channel that is read more slowly.
    pub probe_gap_s: f64,
    /// Longest wait for a source that lags behind the others, s; longer for a channel that is read more slowly.
    pub wait_s: f64,
    /// Motion that counts as a reversal.
    pub reversal: ReversalBand,
}

impl Default for AlignLimits {
    fn default() -> Self {
        Self { axis_gap_s: 0.75, probe_gap_s: USUAL_GAP_S, wait_s: 1.0, reversal: ReversalBand::default() }
    }
}

/// What comes out, in order of time: all that is known of one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aligned {
    /// The axes, and when.
    pub state: AxisState,
    /// Channels of the instrument, mm; NaN where one has no value, 0 where the instrument has none. `None`: the axes
    /// alone, which come also while the probes are away.
    pub channels_mm: Option<[f64; 3]>,
}

/// What was given out and what was refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AlignCounts {
    /// Samples given out.
    pub samples: u64,
    /// Samples left out because the axes were not known around them.
    pub without_axes: u64,
    /// Samples with at least one channel without value.
    pub incomplete: u64,
    /// Samples that came out of order of time and were dropped.
    pub out_of_order: u64,
}

/// Aligns the channels of one instrument with the axes.
#[derive(Clone, Debug)]
pub struct Aligner {
    channels: Vec<u16>,
    limits: AlignLimits,
    axes: AxisHistory,
    probes: [Series; 3],
    newest_s: f64,
    given_s: f64,
    counts: AlignCounts,
}

impl Aligner {
    /// For one to three channels, see [`trunnion_core::channel::instrument_channels`]; the first gives the instants. More are
    /// not looked at.
    pub fn new(channels: &[u16], limits: AlignLimits) -> Self {
        Self {
            channels: channels.iter().copied().take(3).collect(),
            limits,
            axes: AxisHistory::new(limits.axis_gap_s, limits.reversal),
            probes: Default::default(),
            newest_s: f64::NEG_INFINITY,
            given_s: f64::NEG_INFINITY,
            counts: AlignCounts::default(),
        }
    }

    /// Takes a displacement; channels of other instruments are ignored. What is known now goes to the end of `out`.
    pub fn push_probe(&mut self, sample: &ProbeSample, out: &mut Vec<Aligned>) {
        let Some(k) = self.channels.iter().position(|&channel| channel == sample.channel) else { return };
        if !self.probes[k].push(sample.time_s, sample.value_mm) {
            self.counts.out_of_order += 1;
        }
        self.newest_s = self.newest_s.max(sample.time_s);
        self.give_out(false, out);
    }

    /// Takes axis positions. What is known now goes to the end of `out`.
    pub fn push_axes(&mut self, sample: &AxisSample, out: &mut Vec<Aligned>) {
        if !self.axes.push(sample) {
            self.counts.out_of_order += 1;
        }
        self.newest_s = self.newest_s.max(sample.time_s);
        self.give_out(false, out);
    }

    /// Gives out what was waiting for samples that will not come.
    pub fn finish(&mut self, out: &mut Vec<Aligned>) {
        self.give_out(true, out);
    }

    /// What was given out and refused so far.
    pub fn counts(&self) -> AlignCounts {
        self.counts
    }

    fn give_out(&mut self, at_end: bool, out: &mut Vec<Aligned>) {
        loop {
            let sample_s = self.probes[0].waiting.front().map(|&(time_s, _)| time_s);
            let axes_s = self.axes.next_time();
            match (sample_s, axes_s) {
                (None, None) => return,
                (Some(sample_s), axes_s) if axes_s.is_none_or(|axes_s| sample_s <= axes_s) => {
                    let overdue = at_end || self.newest_s - sample_s > self.wait_s();
                    if !overdue && !self.is_known_around(sample_s) {
                        return;
                    }
                    out.extend(self.take_sample());
                }
                (sample_s, Some(axes_s)) => {
                    // Without a later probe sample one may still come that belongs before these axes.
                    let overdue = at_end || self.newest_s - axes_s > self.wait_s();
                    if sample_s.is_none() && !overdue && self.probes[0].newest_s() < axes_s {
                        return;
                    }
                    let Some(state) = self.axes.take_next(overdue) else { return };
                    out.push(Aligned { state, channels_mm: None });
                }
                (Some(_), None) => unreachable!("the first arm takes every sample without axes"),
            }
        }
    }

    /// The samples of a channel come no sooner than it is read.
    fn wait_s(&self) -> f64 {
        let of = |wait_s: f64, series: &Series| series.interval.longest_gap_s(wait_s);
        self.probes.iter().fold(self.limits.wait_s, of)
    }

    fn is_known_around(&self, time_s: f64) -> bool {
        let others = self.probes.iter().take(self.channels.len()).skip(1);
        self.axes.is_known_around(time_s) && others.into_iter().all(|series| series.newest_s() >= time_s)
    }

    fn take_sample(&mut self) -> Option<Aligned> {
        let (time_s, first_mm) = self.probes[0].waiting.pop_front()?;
        let mut channels_mm = [first_mm, 0.0, 0.0];
        for k in 1..self.channels.len() {
            channels_mm[k] = self.probes[k].at(time_s, self.limits.probe_gap_s);
        }
        let Some(state) = self.axes.at(time_s) else {
            self.counts.without_axes += 1;
            return None;
        };
        if time_s < self.given_s {
            self.counts.out_of_order += 1;
            return None;
        }
        self.given_s = time_s;
        self.counts.samples += 1;
        self.counts.incomplete += u64::from(channels_mm.iter().any(|value| value.is_nan()));
        Some(Aligned { state, channels_mm: Some(channels_mm) })
    }
}

/// Samples of one channel that may still be needed. Bounded: the aligner never waits longer than `wait_s`, and
/// beyond [`MAX_WAITING`] the oldest are dropped.
#[derive(Clone, Debug, Default)]
struct Series {
    waiting: VecDeque<(f64, f64)>,
    newest_s: Option<f64>,
    interval: Interval,
}

/// 4 s at 4 kHz.
const MAX_WAITING: usize = 16_384;

impl Series {
    /// False when the sample is older than the last one.
    fn push(&mut self, time_s: f64, value_mm: f64) -> bool {
        if !time_s.is_finite() || self.newest_s.is_some_and(|newest| time_s < newest) {
            return false;
        }
        self.newest_s = Some(time_s);
        self.interval.push(time_s);
        self.waiting.push_back((time_s, value_mm));
        if self.waiting.len() > MAX_WAITING {
            self.waiting.pop_front();
        }
        true
    }

    fn newest_s(&self) -> f64 {
        self.newest_s.unwrap_or(f64::NEG_INFINITY)
    }

    /// Linear between the samples around; drops what is older.
    fn at(&mut self, time_s: f64, least_s: f64) -> f64 {
        let longest_s = self.interval.longest_gap_s(least_s);
        while self.waiting.get(1).is_some_and(|&(next_s, _)| next_s <= time_s) {
            self.waiting.pop_front();
        }
        match (self.waiting.front(), self.waiting.get(1)) {
            (Some(&(t0, p0)), _) if t0 == time_s => p0,
            (Some(&(t0, p0)), Some(&(t1, p1))) if t0 < time_s && t1 - t0 <= longest_s => {
                p0 + (p1 - p0) * (time_s - t0) / (t1 - t0)
            }
            _ => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests;
