//! How often a good display shows all channels alike by chance: two rows that read the same, or rows that read zero in every channel.
//!
//! With the noise σ a channel that the base model expects at m shows the value v of a step q with the chance
//! Φ((v + q/2 − m)/σ) − Φ((v − q/2 − m)/σ). How often every channel by itself does it is seen: where it is more often than that, for
//! readings that keep together or a model that misses something, the chance of each row is larger by as much. Channels do so independently of
//! each other: what is new of rows that were held, or were missing, is that all do it at once.
//! Limits: of one channel alone, rows that were held or missing are seen against the noise only.

use super::fitted::Fitted;
use super::looked::{thinned, with_points};
use super::shown::{SAME_MM, Shown, from_next_mm};
use crate::Experiment;
use crate::noise::learned::display::nominal_readings_mm;
use crate::solve::normal::below;
use std::f64::consts::PI;
use trunnion_core::Point;
use trunnion_cycles::Run;

/// Odds against so many by chance: no good run of a million.
const ODDS_LN: f64 = 13.8;
/// What a fit leaves is no finer than the rounding of the readings, q/√12 [GUM F.2.2.1], as a share of a step.
const OF_ROUNDING: f64 = 0.29;

/// How often something was seen, and how often it is by chance.
pub(super) struct Often {
    pub seen: usize,
    pub by_chance: f64,
}

impl Often {
    /// −ln of the chance of as many or more, λ − n + n·ln(n/λ) [Chernoff's bound of the Poisson distribution].
    pub fn is_no_chance(&self) -> bool {
        let (n, expected) = (self.seen as f64, self.by_chance);
        n > expected && expected - n + n * (n / expected).ln() > ODDS_LN
    }
}

/// The readings of a setup as its display shows them, and where the base model expects them.
pub(super) struct Displayed {
    /// The points of the setup in order, with their numbers among those that are looked at.
    points: Vec<(usize, Point)>,
    /// Of every channel.
    sigma_mm: Vec<f64>,
    expected_mm: Vec<Vec<f64>>,
    step_mm: f64,
}

impl Displayed {
    /// `None` without a base model, or where the setup shows one value only.
    pub fn of(run: &Run, setup: usize) -> Option<Self> {
        let experiment = Experiment::of_points(&[with_points(run, thinned(run))]).ok()?;
        let model = Fitted::new(&experiment)?;
        let left_mm = model.left_mm(&(experiment.readings_mm() - nominal_readings_mm(&experiment)));
        let own: Vec<usize> =
            (0..experiment.points.len()).filter(|&at| experiment.points[at].state.setup == setup).collect();
        let points: Vec<(usize, Point)> = own.iter().map(|&at| (at, experiment.points[at].clone())).collect();
        let shown = Shown::of(&run.setups[setup], points.iter().map(|(_, point)| point));
        let step_mm = Some(shown.step_mm).filter(|step_mm| step_mm.is_finite())?;
        let row = |at: usize, channel: usize| experiment.rows_of(at).start + channel;
        let channels = run.setups[setup].instrument.components().len();
        let sigma_mm = |channel: usize| {
            let is_own = |at: usize| experiment.points[at].state.setup == setup;
            let of_row = |at: usize, k: usize| (is_own(at) && k == channel).then(|| left_mm[row(at, k)]);
            let of_rounding_mm = OF_ROUNDING * step_mm;
            // Of a normal law the mean difference of two is 2σ/√π. The median would be zero where half of the rows were held.
            let apart_mm = from_next_mm(&experiment, of_row);
            let mean_mm = apart_mm.iter().sum::<f64>() / apart_mm.len().max(1) as f64;
            let squares = (0.5 * PI.sqrt() * mean_mm).powi(2) - of_rounding_mm.powi(2);
            squares.max(of_rounding_mm.powi(2)).sqrt()
        };
        let expected_of = |channel: usize| {
            own.iter()
                .map(|&at| experiment.points[at].reading_mm[channel] - left_mm[row(at, channel)])
                .collect()
        };
        let sigma_mm = (0..channels).map(sigma_mm).collect();
        let expected_mm = (0..channels).map(expected_of).collect();
        Some(Self { points, sigma_mm, expected_mm, step_mm })
    }

    /// Rows that read the same as the row before, where the axes had moved.
    pub fn held(&self) -> Often {
        let has_moved = |k: &usize| {
            let ((before, from), (at, to)) = (&self.points[k - 1], &self.points[*k]);
            before + 1 == *at && from.state.position != to.state.position
        };
        let moved: Vec<usize> = (1..self.points.len()).filter(has_moved).collect();
        let is_same = |k: usize, channel: usize| self.value_mm(k, channel) == self.value_mm(k - 1, channel);
        let chance = |k: usize, channel: usize| {
            let [before, now] = [k - 1, k].map(|k| self.expected_mm[channel][k]);
            let near = (before.min(now) - self.reach_mm(channel), before.max(now) + self.reach_mm(channel));
            let values = self.values_mm(self.value_mm(k, channel), near);
            values.map(|mm| self.chance(channel, mm, before) * self.chance(channel, mm, now)).sum()
        };
        self.often(&moved, is_same, chance)
    }

    /// Rows that read zero.
    pub fn zeros(&self) -> Often {
        let all: Vec<usize> = (0..self.points.len()).collect();
        let is_zero = |k: usize, channel: usize| self.value_mm(k, channel).abs() < SAME_MM;
        self.often(&all, is_zero, |k, channel| self.chance(channel, 0.0, self.expected_mm[channel][k]))
    }

    fn often(
        &self,
        rows: &[usize],
        is_so: impl Fn(usize, usize) -> bool,
        chance: impl Fn(usize, usize) -> f64,
    ) -> Often {
        let channels = 0..self.sigma_mm.len();
        let chances: Vec<Vec<f64>> =
            channels.clone().map(|channel| rows.iter().map(|&k| chance(k, channel)).collect()).collect();
        let more_often = |channel: usize| {
            let seen = rows.iter().filter(|&&k| is_so(k, channel)).count() as f64;
            let expected: f64 = chances[channel].iter().sum();
            // One channel by itself would explain itself.
            if chances.len() == 1 { 1.0 } else { (seen / expected.max(f64::MIN_POSITIVE)).max(1.0) }
        };
        let times: Vec<f64> = channels.clone().map(more_often).collect();
        let of_row = |at: usize| -> f64 {
            channels.clone().map(|channel| (times[channel] * chances[channel][at]).min(1.0)).product()
        };
        Often {
            seen: rows.iter().filter(|&&k| channels.clone().all(|channel| is_so(k, channel))).count(),
            by_chance: (0..rows.len()).map(of_row).sum(),
        }
    }

    fn value_mm(&self, k: usize, channel: usize) -> f64 {
        self.points[k].1.reading_mm[channel]
    }

    /// No reading is farther from what is expected.
    fn reach_mm(&self, channel: usize) -> f64 {
        4.0 * self.sigma_mm[channel] + self.step_mm
    }

    /// Values of the display between two others, of which one is known: no more than tell.
    fn values_mm(&self, known_mm: f64, (least_mm, most_mm): (f64, f64)) -> impl Iterator<Item = f64> {
        let (first, last) =
            (((least_mm - known_mm) / self.step_mm).floor(), ((most_mm - known_mm) / self.step_mm).ceil());
        let step_mm = self.step_mm;
        (first as i64..=last as i64).map(move |steps| known_mm + steps as f64 * step_mm)
    }

    /// That a channel shows a value where another is expected.
    fn chance(&self, channel: usize, value_mm: f64, expected_mm: f64) -> f64 {
        let off = (value_mm - expected_mm) / self.sigma_mm[channel];
        let half = 0.5 * self.step_mm / self.sigma_mm[channel];
        below(off + half) - below(off - half)
    }
}
