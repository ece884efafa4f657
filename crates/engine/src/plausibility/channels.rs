//! Is every channel alive, and one of its own? Asked of every instrument, setup by setup.
//!
//! A channel that reads one value in every digit while the axes move is stuck. A coarse display shows one value for a while by itself, so
//! the longest stretch is judged against the second longest of the same channel and against the other channels ([`super::stretches`]).
//! Limits: a channel that is stuck in two stretches of like length passes; one that is stuck at a resting machine is not looked at.

mod marked;
mod sorted;
mod zeros;

use super::found::{Implausible, plain};
use super::readings::FEWEST_POINTS;
use super::shown::{SAME_MM, Shown, would_move};
use super::stretches::{Stretch, stands_out, stretches};
use trunnion_core::Point;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::signed;
use trunnion_cycles::Run;

/// A channel reads one value in at least this share of the points, in whatever order: the others are single wrong values.
const DEAD_SHARE: f64 = 0.9;
/// Two channels read the same in at least this share of the points: of two probes only a coarse display makes some readings equal.
const TIED_SHARE: f64 = 0.9;
/// The largest value comes so many times as often as any value between the largest and the smallest. At the crest of a wave that a display
/// shows in steps it is 1/(√2 − 1) = 2.4 times the one below, by the arcsine law; twice that is no wave.
const CLIPPED_TIMES: usize = 5;
/// Fewer equal values are chance.
const FEWEST_CLIPPED: usize = 8;

const CHECK_PROBE: &str = "The probe is dead, stuck or not connected. Check it and measure again.";

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    runs.iter().filter(|run| run.good_points().count() >= FEWEST_POINTS).filter_map(of_run).collect()
}

fn of_run(run: &Run) -> Option<Implausible> {
    (0..run.setups.len()).find_map(|setup| {
        let channels = Channels::of(run, setup);
        channels
            .marked()
            .or_else(|| channels.stuck())
            .or_else(|| channels.dead())
            .or_else(|| channels.tied())
            .or_else(|| channels.zeros())
            .or_else(|| channels.clipped())
            .or_else(|| channels.sorted())
    })
}

/// The channels of one setup of a run.
struct Channels<'a> {
    run: &'a Run,
    setup: usize,
    points: Vec<&'a Point>,
    /// Rows in the run, counted from 1.
    rows: Vec<usize>,
}

impl<'a> Channels<'a> {
    fn of(run: &'a Run, setup: usize) -> Self {
        let own = |(_, point): &(usize, &Point)| point.state.setup == setup && point.is_good();
        let (rows, points) =
            run.points.iter().enumerate().filter(own).map(|(row, point)| (row + 1, point)).unzip();
        Self { run, setup, points, rows }
    }

    fn names(&self) -> Vec<String> {
        let instrument = self.run.setups[self.setup].instrument;
        let name = |(component, column): (&&str, &trunnion_core::ReadingColumn)| match instrument
            .deflects_probes()
        {
            true => format!("the probe d{component}"),
            false => format!("the channel {}", column.name()),
        };
        instrument.components().iter().zip(instrument.columns()).map(name).collect()
    }

    fn value_mm(&self, channel: usize, at: usize) -> f64 {
        self.points[at].reading_mm[channel]
    }

    fn is_same(&self, channel: usize, at: usize, other: usize) -> bool {
        (self.value_mm(channel, at) - self.value_mm(channel, other)).abs() < SAME_MM
    }

    fn shown(&self) -> Shown {
        Shown::of(&self.run.setups[self.setup], self.points.iter().copied())
    }

    /// Good channels would have shown more than one value at these points.
    fn would_move(&self, channels: &[usize], at: impl Iterator<Item = usize>) -> bool {
        let rows: Vec<usize> = at.map(|at| self.rows[at]).collect();
        would_move(self.run, self.setup, channels, &rows)
    }

    /// Stretches of one value between two points, the longest first. Points at the position of the one before do not count.
    fn stretches(&self, channel: usize, (from, to): (usize, usize)) -> Vec<Stretch> {
        let has_moved = |at: usize| self.points[at].state.position != self.points[at - 1].state.position;
        let mut found = stretches(from..=to, |at, other| self.is_same(channel, at, other), has_moved);
        found.sort_by_key(|stretch| std::cmp::Reverse(stretch.length));
        found
    }

    /// A stretch that is too long for the display.
    fn stuck(&self) -> Option<Implausible> {
        let whole = (0, self.points.len().checked_sub(1)?);
        let channels: Vec<usize> = (0..self.names().len()).collect();
        let too_long = |first: usize, second: usize| stands_out(first as f64, second as f64);
        let found = channels.iter().find_map(|&channel| {
            let stretches = self.stretches(channel, whole);
            let longest = stretches[0];
            let second = stretches.get(1).map_or(1, |stretch| stretch.length);
            // The others have the same display: where they rest as well, all are stuck, or it is too coarse for this machine.
            let of_others: Vec<usize> = channels
                .iter()
                .filter(|other| **other != channel)
                .map(|&other| self.stretches(other, (longest.first, longest.last))[0].length)
                .collect();
            let all_rest = of_others.iter().all(|length| *length == longest.length);
            let one_goes_on = of_others.iter().any(|length| too_long(longest.length, *length));
            (too_long(longest.length, second) && (all_rest || one_goes_on))
                .then_some((channel, longest, all_rest))
        });
        let (channel, stretch, all_rest) = found?;
        let asked = if all_rest { &channels[..] } else { &[channel] };
        if !self.would_move(asked, stretch.first..=stretch.last) {
            return None;
        }
        let names = self.names();
        let which = match &names[..] {
            [_, _, ..] if all_rest => format!("{} each read", names.join(" and ")),
            _ => format!("{} reads", names[channel]),
        };
        Some(plain(
            format!(
                "{}: in rows {} to {} {which} the same value in every digit, while the axes move.",
                self.run.name, self.rows[stretch.first], self.rows[stretch.last]
            ),
            CHECK_PROBE,
        ))
    }

    /// One value in nearly all points, in whatever order.
    fn dead(&self) -> Option<Implausible> {
        let count = self.points.len();
        let names = self.names();
        let sorted = |channel: usize| {
            let mut values: Vec<f64> = (0..count).map(|at| self.value_mm(channel, at)).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let shown = self.shown();
        if count < FEWEST_POINTS || !shown.is_alive() {
            return None;
        }
        names.iter().enumerate().find_map(|(channel, name)| {
            let values = sorted(channel);
            let span_mm = values.last().zip(values.first()).map_or(0.0, |(last, first)| last - first);
            let same = values.chunk_by(|a, b| (a - b).abs() < SAME_MM);
            let usual = same.max_by_key(|same| same.len())?;
            let most = usual.len();
            let at_usual = |at: &usize| (self.value_mm(channel, *at) - usual[0]).abs() < SAME_MM;
            let is_dead = most as f64 > DEAD_SHARE * count as f64
                && span_mm < shown.span_mm
                && self.would_move(&[channel], (0..count).filter(at_usual));
            is_dead.then(|| {
                plain(
                    format!(
                        "{}: {name} reads the same value in {most} of {count} points, while others move by {:.0} µm.",
                        self.run.name,
                        um_from_mm(shown.span_mm)
                    ),
                    CHECK_PROBE,
                )
            })
        })
    }

    /// Two channels with the same values.
    fn tied(&self) -> Option<Implausible> {
        let (count, names) = (self.points.len(), self.names());
        if count < FEWEST_POINTS || !self.shown().is_alive() {
            return None;
        }
        let pairs = (0..names.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let same = |a: usize, b: usize| {
            (0..count).filter(|&at| (self.value_mm(a, at) - self.value_mm(b, at)).abs() < SAME_MM).count()
        };
        let moves = |channel: usize| (1..count).any(|at| !self.is_same(channel, at, 0));
        let mut tied = pairs.map(|(a, b)| (a, b, same(a, b)));
        let (a, b, same) = tied.find(|&(a, _, same)| same as f64 > TIED_SHARE * count as f64 && moves(a))?;
        Some(plain(
            format!(
                "{}: {} and {} read the same value in {same} of {count} points.",
                self.run.name, names[a], names[b]
            ),
            "Two inputs read one probe, or a column was copied. Check the wiring and the file.",
        ))
    }

    /// A largest or smallest value that comes far too often: the end of a range.
    fn clipped(&self) -> Option<Implausible> {
        let names = self.names();
        names.iter().enumerate().find_map(|(channel, name)| {
            let mut values: Vec<f64> =
                (0..self.points.len()).map(|at| self.value_mm(channel, at)).collect();
            values.sort_by(f64::total_cmp);
            let counts: Vec<(f64, usize)> =
                values.chunk_by(|a, b| (a - b).abs() < SAME_MM).map(|same| (same[0], same.len())).collect();
            let [first, between @ .., last] = &counts[..] else { return None };
            let usual = between.iter().map(|(_, count)| *count).max()?;
            let most = usual.saturating_mul(CLIPPED_TIMES).max(FEWEST_CLIPPED);
            let (value_mm, count) = [first, last].into_iter().find(|(_, count)| *count > most)?;
            let at_end = |at: &usize| (self.value_mm(channel, *at) - value_mm).abs() < SAME_MM;
            let would_move = self.would_move(&[channel], (0..self.points.len()).filter(at_end));
            would_move.then(|| plain(
                format!(
                    "{}: {name} reads exactly {} µm in {count} of {} points, and never beyond.",
                    self.run.name,
                    signed(um_from_mm(*value_mm), 2),
                    values.len()
                ),
                "Its range ends there, so the machine moved farther than was read. Set the ball closer to the middle of the range and measure again.",
            ))
        })
    }
}
