//! Does the clock go on evenly? A clock that is set in the middle of a run bends every drift.
//!
//! Pauses are no mistakes: a cycle may wait for hours, and begin again where its next setup or pass begins. Only what no pause gives is
//! said: a time that runs back and begins nowhere again, a step by whole hours, one time for all.

use super::found::{Implausible, plain};
use super::readings::FEWEST_POINTS;
use trunnion_core::{Point, statistics};
use trunnion_cycles::Run;

const HOUR_S: f64 = 3600.0;
/// A step is one of a clock where it is a whole number of hours, the usual time between two rows apart, within so many of those, and not
/// less than half of the shortest: a clock that was set leaves the way to the next pose in it. Rows every
/// 4 s come by chance so near with 2 · 2 · 4/3600 = 0.4 % of all pauses.
const NEAR_STEPS: f64 = 2.0;
/// Rows lie unevenly by no more than a tenth of an hour's step where it can be recognised.
const LONGEST_STEP_S: f64 = 180.0;
/// Hours by which a clock is set: summer time, or another time zone.
const MOST_HOURS: f64 = 14.0;
/// No cycle that goes from pose to pose waits so long at each and lasts so long: a minute and a half is more than a probe needs to settle, and a
/// day is longer than a shift. Poses of thermal runs come seldom too, but with temperatures, or in one place.
const SLOW_STEP_S: f64 = 90.0;
const SLOW_RUN_S: f64 = 86_400.0;

/// What to say of the times of a run that can be judged all the same.
#[derive(Clone, Debug, PartialEq)]
pub enum ClockDoubt {
    /// Every row has this time, s.
    OneTime(f64),
    /// Before this row, counted from 1, the clock went on by so many seconds.
    SetForward {
        /// The row behind the step.
        row: usize,
        /// How far, s.
        by_s: f64,
        /// The usual time between two rows, s.
        usual_s: f64,
    },
    /// The axes went from pose to pose for days.
    Slow {
        /// From the first row to the last, s.
        span_s: f64,
        /// The usual time between two rows, s.
        usual_s: f64,
    },
}

/// A pair of neighbouring rows of one setup with their times: the row behind, counted from 1, the time before and behind, s.
type Step = (usize, f64, f64);

/// Steps between rows as they were taken: blocks and means of a longer run stand in an order of their own.
fn steps(run: &Run) -> Vec<Step> {
    if run.points.iter().any(|point| point.samples > 1) {
        return Vec::new();
    }
    let step = |(row, pair): (usize, &[Point])| {
        let is_of_one = pair[0].state.setup == pair[1].state.setup;
        Some((row, pair[0].state.time_s?, pair[1].state.time_s?)).filter(|_| is_of_one)
    };
    (2..).zip(run.points.windows(2)).filter_map(step).collect()
}

/// The usual time from row to row, s.
fn usual_s(steps: &[Step]) -> Option<f64> {
    let forward: Vec<f64> = steps.iter().map(|(_, from, to)| to - from).filter(|step| *step > 0.0).collect();
    (forward.len() + 1 >= FEWEST_POINTS).then(|| statistics::median(&forward)).flatten()
}

/// Time that runs back where nothing begins again: asked of rows that are in order otherwise.
pub(super) fn set_back(run: &Run) -> Option<Implausible> {
    let steps = steps(run);
    let usual_s = usual_s(&steps)?;
    let beginning_s = |row: usize| {
        let setup = run.points[row - 1].state.setup;
        let first =
            |of: &dyn Fn(&&Point) -> bool| run.points.iter().find(of).and_then(|point| point.state.time_s);
        [first(&|_| true), first(&|point| point.state.setup == setup)]
    };
    let begins_again = |row: usize, to_s: f64| {
        beginning_s(row).into_iter().flatten().any(|begun_s| (to_s - begun_s).abs() <= NEAR_STEPS * usual_s)
    };
    let back: Vec<&Step> =
        steps.iter().filter(|(row, from, to)| from - to > usual_s && !begins_again(*row, *to)).collect();
    let (row, from, to) = back.first()?;
    let further = match back.len() - 1 {
        0 => String::new(),
        more => format!(" ({more} more such steps)"),
    };
    Some(plain(
        format!(
            "{}: from row {} to row {row} time runs back by {:.0} s, from {from:.1} to {to:.1} s{further}; elsewhere it goes on by {usual_s:.1} s from \
             row to row.",
            run.name,
            row - 1,
            from - to
        ),
        "The clock was set while the run was measured, or rows of another measurement follow. Put the times behind the step on one clock, or \
         import the two parts as runs of their own.",
    ))
}

/// How long a run lasts that is long, had no thermometer, and moved an axis in most of its steps, s.
fn slow_s(run: &Run, times: &[f64]) -> Option<f64> {
    let (first, last) =
        times.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
    let moved = run.points.windows(2).filter(|pair| pair[0].state.position != pair[1].state.position).count();
    let is_slow = last - first > SLOW_RUN_S && run.channels.is_empty() && 2 * moved > run.points.len();
    is_slow.then_some(last - first)
}

/// What to say of the times of a run, which is judged all the same.
pub fn clock_doubt(run: &Run) -> Option<ClockDoubt> {
    let times: Vec<f64> = run.points.iter().filter_map(|point| point.state.time_s).collect();
    let first = *times.first()?;
    if times.len() >= FEWEST_POINTS && times.iter().all(|time| *time == first) {
        return Some(ClockDoubt::OneTime(first));
    }
    let steps = steps(run);
    let usual_s = usual_s(&steps)?;
    if let Some(span_s) = slow_s(run, &times).filter(|_| usual_s > SLOW_STEP_S) {
        return Some(ClockDoubt::Slow { span_s, usual_s });
    }
    if usual_s >= LONGEST_STEP_S {
        return None;
    }
    // What is left of the step without the hours is the time from row to row, as short as one at least.
    let forward = steps.iter().map(|(_, from, to)| to - from).filter(|step_s| *step_s > 0.0);
    let shortest_s = forward.fold(f64::INFINITY, f64::min);
    steps.into_iter().find_map(|(row, from, to)| {
        let by_s = to - from;
        let hours = ((by_s - usual_s) / HOUR_S).round();
        let rest_s = by_s - hours * HOUR_S;
        let is_near = (rest_s - usual_s).abs() <= NEAR_STEPS * usual_s && rest_s >= 0.5 * shortest_s;
        ((1.0..=MOST_HOURS).contains(&hours) && is_near).then_some(ClockDoubt::SetForward {
            row,
            by_s,
            usual_s,
        })
    })
}
