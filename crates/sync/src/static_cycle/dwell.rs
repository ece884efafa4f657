//! One dwell: since when the axes stand, and what the probes read meanwhile.

use super::StaticRules;
use crate::align::AxisState;
use crate::interval::Interval;
use crate::nest::NestCalibration;
use std::collections::VecDeque;
use trunnion_core::statistics::{MEDIAN_OF_NORMAL, median};
use trunnion_core::{AxisValues, Joint};

/// A stationary machine this long (at most half a window) dwells, s.
const ARRIVAL_S: f64 = 0.2;
/// Rounding of times.
const TIME_SLACK_S: f64 = 1e-9;

/// What a point is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Summary {
    /// Middle of the samples, s.
    pub time_s: f64,
    pub reading_mm: [f64; 3],
    pub spread_mm: [f64; 3],
    pub samples: u32,
}

/// The channels at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reading {
    time_s: f64,
    channels_mm: [f64; 3],
}

/// Axes and probes since the machine last moved.
#[derive(Clone, Debug)]
pub(super) struct Dwell {
    rules: StaticRules,
    arrival_s: f64,
    /// How often the probes are read.
    interval: Interval,
    /// Axis states of the last window.
    axes: VecDeque<AxisState>,
    /// Samples of the last window.
    samples: VecDeque<Reading>,
    /// Since when no axis moved more than the standstill limits.
    still_since_s: f64,
    /// When this dwell began; unlike `still_since_s` it is not moved by creeping axes.
    began_s: f64,
    read_until_s: f64,
}

impl Dwell {
    pub(super) fn new(rules: &StaticRules) -> Self {
        Self {
            rules: *rules,
            arrival_s: ARRIVAL_S.min(rules.settle.window_s / 2.0),
            interval: Interval::default(),
            axes: VecDeque::new(),
            samples: VecDeque::new(),
            still_since_s: f64::INFINITY,
            began_s: f64::INFINITY,
            read_until_s: f64::NEG_INFINITY,
        }
    }

    /// The next dwell, of the same probes.
    pub(super) fn next(&self) -> Self {
        Self { interval: self.interval, ..Self::new(&self.rules) }
    }

    fn window_s(&self) -> f64 {
        self.rules.window_s(self.interval.usual_s())
    }

    fn fewest_samples(&self) -> usize {
        self.rules.fewest_samples.max(2)
    }

    /// How long a dwell may settle, s: longer by what its window is longer.
    pub(super) fn timeout_s(&self) -> f64 {
        self.rules.settle.timeout_s + self.window_s() - self.rules.settle.window_s
    }

    /// Keeps a sample; it counts once axis states on both sides show that the machine stood.
    pub(super) fn push_sample(&mut self, time_s: f64, channels_mm: [f64; 3]) {
        self.interval.push(time_s);
        self.samples.push_back(Reading { time_s, channels_mm });
        let from_s = self.now_s().unwrap_or(time_s) - self.window_s() - TIME_SLACK_S;
        while self.samples.front().is_some_and(|old| old.time_s < from_s) {
            self.samples.pop_front();
        }
    }

    /// True when this state ends the dwell.
    pub(super) fn is_left_by(&self, state: &AxisState, letters: &[Joint]) -> bool {
        self.is_stationary() && state.time_s - self.still_since_with(state, letters) < self.arrival_s
    }

    pub(super) fn push_axes(&mut self, state: &AxisState, letters: &[Joint]) {
        let was_standing = self.is_stationary();
        self.still_since_s = self.still_since_with(state, letters);
        self.axes.push_back(*state);
        let from_s = state.time_s - self.window_s();
        while self.axes.get(1).is_some_and(|second| second.time_s <= from_s) {
            self.axes.pop_front();
        }
        if !was_standing {
            self.began_s = self.still_since_s;
        }
    }

    /// Since when the axes stand, this state included.
    fn still_since_with(&self, state: &AxisState, letters: &[Joint]) -> f64 {
        let (mut lowest, mut highest) = (state.position, state.position);
        let mut since_s = state.time_s;
        for old in self.axes.iter().rev() {
            for &letter in letters {
                lowest[letter] = lowest[letter].min(old.position[letter]);
                highest[letter] = highest[letter].max(old.position[letter]);
                if highest[letter] - lowest[letter] > self.limit(letter) {
                    return since_s;
                }
            }
            since_s = old.time_s;
        }
        since_s.min(self.still_since_s)
    }

    fn limit(&self, letter: Joint) -> f64 {
        if letter.is_rotary() { self.rules.settle.standstill_rad } else { self.rules.settle.standstill_mm }
    }

    pub(super) fn is_stationary(&self) -> bool {
        self.now_s().is_some_and(|now_s| now_s - self.still_since_s >= self.arrival_s - TIME_SLACK_S)
    }

    pub(super) fn began_s(&self) -> f64 {
        self.began_s
    }

    /// Where the machine stands; `None` before the first axis state.
    pub(super) fn latest(&self) -> Option<&AxisState> {
        self.axes.back()
    }

    fn now_s(&self) -> Option<f64> {
        Some(self.axes.back()?.time_s)
    }

    /// A point was read from what came so far; the next needs a window of its own.
    pub(super) fn mark_read(&mut self) {
        self.read_until_s = self.now_s().unwrap_or(f64::NEG_INFINITY);
    }

    /// Samples of the window that ends now and lies in this dwell, behind what was read.
    fn window(&self) -> impl Iterator<Item = &Reading> + Clone {
        let now_s = self.now_s().unwrap_or(f64::NEG_INFINITY);
        let from_s = (now_s - self.window_s()).max(self.still_since_s).max(self.read_until_s);
        let inside = move |time_s: f64| (from_s - TIME_SLACK_S..=now_s + TIME_SLACK_S).contains(&time_s);
        self.samples.iter().filter(move |sample| inside(sample.time_s))
    }

    /// True when a full window stood, is complete, and lies within the limits of drift and noise.
    pub(super) fn is_settled(&self) -> bool {
        let Some(now_s) = self.now_s() else { return false };
        let from_s = now_s - self.window_s();
        if from_s < self.still_since_s.max(self.read_until_s) - TIME_SLACK_S {
            return false;
        }
        let samples: Vec<&Reading> = self.window().collect();
        let times = std::iter::once(from_s)
            .chain(samples.iter().map(|sample| sample.time_s))
            .chain(std::iter::once(now_s));
        let longest_s = self.interval.longest_gap_s(self.rules.sample_gap_s);
        let complete = times.clone().zip(times.skip(1)).all(|(a, b)| b - a <= longest_s);
        let finite = samples.iter().all(|sample| sample.channels_mm.iter().all(|mm| mm.is_finite()));
        if samples.len() < self.fewest_samples() || !complete || !finite {
            return false;
        }
        let half_s = now_s - self.window_s() / 2.0;
        let half = samples.partition_point(|sample| sample.time_s < half_s);
        (0..3).all(|k| {
            let values: Vec<f64> = samples.iter().map(|sample| sample.channels_mm[k]).collect();
            let (_, spread) = median_and_spread(&values);
            let (first, _) = median_and_spread(&values[..half]);
            let (second, _) = median_and_spread(&values[half..]);
            (second - first).abs() <= self.rules.settle.drift_mm && spread <= self.rules.settle.noise_mm
        })
    }

    /// The reading of the window, settled or not; `None` with too few complete samples.
    pub(super) fn summary(&self, calibration: &NestCalibration) -> Option<Summary> {
        let readings: Vec<(f64, [f64; 3])> = self
            .window()
            .map(|sample| (sample.time_s, calibration.reading_mm(sample.channels_mm).into()))
            .filter(|(_, reading): &(f64, [f64; 3])| reading.iter().all(|mm| mm.is_finite()))
            .collect();
        if readings.len() < self.fewest_samples() {
            return None;
        }
        let component = |k: usize| {
            let values: Vec<f64> = readings.iter().map(|(_, reading)| reading[k]).collect();
            median_and_spread(&values)
        };
        let components = [component(0), component(1), component(2)];
        Some(Summary {
            time_s: (readings[0].0 + readings[readings.len() - 1].0) / 2.0,
            reading_mm: components.map(|(median, _)| median),
            spread_mm: components.map(|(_, spread)| spread),
            samples: readings.len() as u32,
        })
    }

    /// Direction of approach and travel since the last reversal of each axis.
    pub(super) fn approach(&self) -> (AxisValues<f64>, AxisValues<f64>) {
        self.latest().map_or_else(Default::default, |state| (state.direction, state.since_reversal))
    }
}

/// Median, and the standard deviation of a normal law from the median absolute deviation; NaN of nothing.
fn median_and_spread(values: &[f64]) -> (f64, f64) {
    let Some(middle) = median(values) else { return (f64::NAN, f64::NAN) };
    let deviations: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
    (middle, median(&deviations).unwrap_or(f64::NAN) / MEDIAN_OF_NORMAL)
}
