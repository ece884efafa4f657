//! Does every temperature go on, and without a jump that no machine makes?
//!
//! A sensor that stops reads one value in every digit to the end, ten times as long as ever before, while another goes on, value by value
//! ([`super::stretches`]). A sensor that settles slows down first: its second longest stretch is the one before the last.
//! A jump is one change from a reading to the next that stands out of how the other changes bend: each is compared with the mean of its
//! neighbours, so that a steady change, however fast, is none. A change that takes several readings bends those next to it as well, and
//! what happened to the machine (a pause, a door) shows in more than one sensor.
//! Limits: a single sensor that stops, one that was constant from the beginning, and all that stop together are not looked at; neither is a
//! jump at a pause, or of runs without times. A medium that changes in full between two readings, in one sensor alone, would be named.

use super::found::{Implausible, plain};
use super::readings::FEWEST_POINTS;
use super::stretches::{Stretch, stands_out, stretches};
use trunnion_core::number::signed;
use trunnion_core::{Point, statistics};
use trunnion_cycles::Run;

/// Temperatures closer than this are one value; displays show no finer step, K.
const SAME_K: f64 = 1e-6;
/// A jump below this is left to the fit, K: what it does to a coefficient of some µm/K is a few µm. A judgement.
const JUMP_K: f64 = 1.0;
/// A step between two readings that takes so many times the usual one is a pause.
const PAUSE: f64 = 3.0;

/// Temperatures of a run in the order of its times.
struct Sensors<'a> {
    run: &'a Run,
    /// Rows in the run, counted from 1.
    rows: Vec<usize>,
    /// Times, s; empty where some are missing.
    times_s: Vec<f64>,
    /// One for each channel that was read throughout.
    channels: Vec<(&'a str, Vec<f64>)>,
}

/// A sensor that stopped, or jumped.
pub(super) fn implausible(run: &Run) -> Option<Implausible> {
    let sensors = Sensors::of(run);
    sensors.stopped().or_else(|| sensors.jumped())
}

impl<'a> Sensors<'a> {
    fn of(run: &'a Run) -> Self {
        let mut points: Vec<_> = (1..).zip(&run.points).filter(|(_, point)| point.is_good()).collect();
        let times_s: Option<Vec<f64>> = points.iter().map(|(_, point)| point.state.time_s).collect();
        let mut times_s = times_s.unwrap_or_default();
        if !times_s.is_empty() {
            let time_s = |point: &Point| point.state.time_s.unwrap_or_default();
            points.sort_by(|(_, a), (_, b)| time_s(a).total_cmp(&time_s(b)));
            times_s.sort_by(f64::total_cmp);
        }
        let channel = |(channel, name): (usize, &'a String)| {
            let read = points.iter().map(|(_, point)| point.state.temperature_degc.get(channel).copied());
            let read: Vec<f64> = read.collect::<Option<_>>()?;
            read.iter().all(|degc| degc.is_finite()).then_some((name.as_str(), read))
        };
        let channels = run.channels.iter().enumerate().filter_map(channel).collect();
        Self { run, rows: points.iter().map(|(row, _)| *row).collect(), times_s, channels }
    }

    /// Stretches of one value from a reading on.
    fn stretches(&self, channel: usize, from: usize) -> Vec<Stretch> {
        let read = &self.channels[channel].1;
        stretches(from..=read.len() - 1, |a, b| (read[a] - read[b]).abs() < SAME_K, |_| true)
    }

    fn stopped(&self) -> Option<Implausible> {
        let too_long = |first: usize, second: usize| stands_out(first as f64, second as f64);
        (0..self.channels.len()).find_map(|channel| {
            let all = self.stretches(channel, 0);
            let (last, before) = all.split_last()?;
            let (next, earlier) = before.split_last()?;
            let longest = |of: &[Stretch]| of.iter().map(|stretch| stretch.length).max().unwrap_or(0);
            let settles = next.length > longest(earlier);
            let goes_on = |other: usize| self.stretches(other, last.first).len() > FEWEST_POINTS;
            let others = (0..self.channels.len()).filter(|other| *other != channel);
            let going_on: Vec<&str> =
                others.filter(|other| goes_on(*other)).map(|other| self.channels[other].0).collect();
            let is_stopped = before.len() >= FEWEST_POINTS
                && too_long(last.length, longest(before))
                && !settles
                && !going_on.is_empty();
            let (name, read) = &self.channels[channel];
            is_stopped.then(|| {
                plain(
                    format!(
                        "{}: from row {} to the end ({} readings) the temperature {name} is {:.2} °C in every digit, while others go on ({}).",
                        self.run.name, self.rows[last.first], last.length, read[last.first], going_on.join(", ")
                    ),
                    "Its sensor, its plug or its logger stopped there. Measure again with the sensor connected, or leave its column out.",
                )
            })
        })
    }

    fn jumped(&self) -> Option<Implausible> {
        let steps_s: Vec<f64> = self.times_s.windows(2).map(|two| two[1] - two[0]).collect();
        let usual_s = statistics::median(&steps_s)?;
        let changes = |channel: usize| Changes::of(&self.channels[channel].1);
        let bends_too =
            |other: usize, at: usize| changes(other).most_bent().is_some_and(|most| most.abs_diff(at) <= 1);
        (0..self.channels.len()).find_map(|channel| {
            let Jump { at, elsewhere_k } = changes(channel).jump()?;
            let is_pause = steps_s[at] > PAUSE * usual_s;
            let is_shared = (0..self.channels.len()).any(|other| other != channel && bends_too(other, at));
            let (name, read) = &self.channels[channel];
            let (from, to) = (read[at], read[at + 1]);
            (!is_pause && !is_shared).then(|| {
                plain(
                    format!(
                        "{}: from row {} to row {} the temperature {name} jumps by {} K, from {from:.2} to {to:.2} °C; elsewhere its changes follow \
                         one another within {elsewhere_k:.2} K.",
                        self.run.name,
                        self.rows[at],
                        self.rows[at + 1],
                        signed(to - from, 1),
                    ),
                    "No part of a machine warms so fast. The sensor came loose, was plugged in elsewhere or changed its zero. Measure again, \
                     leave its column out, or import the rows before and after as runs of their own.",
                )
            })
        })
    }
}

/// Changes from each reading to the next, K.
struct Changes(Vec<f64>);

/// A change that stands out.
struct Jump {
    /// The reading before it.
    at: usize,
    /// How far other changes are from the mean of those next to them, K.
    elsewhere_k: f64,
}

impl Changes {
    fn of(read: &[f64]) -> Self {
        Self(read.windows(2).map(|two| two[1] - two[0]).collect())
    }

    /// Mean of the changes before and after one; the first and the last have none.
    fn of_neighbours(&self, at: usize) -> f64 {
        0.5 * (self.0[at - 1] + self.0[at + 1])
    }

    fn bends(&self) -> impl Iterator<Item = (usize, f64)> {
        (1..self.0.len().saturating_sub(1)).map(|at| (at, (self.0[at] - self.of_neighbours(at)).abs()))
    }

    fn most_bent(&self) -> Option<usize> {
        let (at, bend) = self.bends().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (bend > SAME_K).then_some(at)
    }

    fn jump(self) -> Option<Jump> {
        let at = self.most_bent()?;
        let size_k = (self.0[at] - self.of_neighbours(at)).abs();
        let mut others = self;
        others.0[at] = others.of_neighbours(at);
        let is_near = |other: usize| other.abs_diff(at) <= 1;
        let largest = |near: bool| {
            others
                .bends()
                .filter(|(other, _)| is_near(*other) == near)
                .map(|(_, bend)| bend)
                .fold(0.0, f64::max)
        };
        let [near_k, far_k] = [largest(true), largest(false)];
        let takes_several = stands_out(near_k, far_k);
        let elsewhere_k = near_k.max(far_k);
        // A sensor that never moved elsewhere does not show the steps of its display.
        let is_one = elsewhere_k > SAME_K && size_k > JUMP_K && stands_out(size_k, elsewhere_k);
        (is_one && !takes_several).then_some(Jump { at, elsewhere_k })
    }
}
