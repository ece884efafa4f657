//! The ideal motion: from the cycle, from commanded positions, or a smooth path.
//!
//! A cycle on the fly turns one axis at a constant feed while the linear axes follow the ball, or follows a curve at a constant
//! feed. Each pass is found in the measured positions; a straight line through the angle over time is its ideal motion, and the
//! cycle says where all axes should be then. What all axes have in common, a delay of the time stamps, is in that line and in
//! nobody's share. Run-in and run-out, where the feed is not reached yet or left, have no ideal motion.

use super::error::AttributionError;
use super::motion::{Ideal, LeftOut, Motion};
use super::smooth;
use std::f64::consts::{PI, TAU};
use std::ops::{Range, RangeInclusive};
use trunnion_core::statistics::upper_median;
use trunnion_core::{AxisSample, AxisValues, Joint};
use trunnion_cycles::cycle::Sweep;
use trunnion_cycles::{Cycle, cycle};
use trunnion_machine::Machine;
use trunnion_sync::{SweepRules, at_feed};

/// Slower than this share of the slowest feed is not a pass.
const MOVING: f64 = 0.3;
/// A pass covers at least this share of the sweep.
const COVERED: f64 = 0.8;
/// The feed measured may differ from the commanded one by the override, up to this factor.
const OVERRIDE: f64 = 2.5;
/// Samples this many usual distances apart have a gap between them.
const GAP: f64 = 5.0;

/// Samples with their ideal positions.
pub(super) struct Found {
    pub ideal: Ideal,
    /// Indices of the samples that have an ideal position.
    pub samples: Vec<usize>,
    pub positions: Vec<AxisValues<f64>>,
    pub angle_rad: Vec<f64>,
    pub passes: Vec<Range<usize>>,
    pub left_out: LeftOut,
}

pub(super) fn find(motion: &Motion<'_>) -> Result<Found, AttributionError> {
    let why = match motion.cycle {
        None => String::new(),
        Some(cycle) => match of_cycle(motion, cycle)? {
            Ok(found) => return Ok(found),
            Err(why) => why,
        },
    };
    match motion.commanded {
        Some(commanded) => Ok(asked(motion, commanded, why)),
        None => smoothed(motion, why),
    }
}

/// Every sample where the control asked the axes to be then.
fn asked(motion: &Motion<'_>, commanded: &[AxisValues<f64>], why: String) -> Found {
    let times: Vec<f64> = motion.samples.iter().map(|sample| sample.time_s).collect();
    Found {
        samples: (0..times.len()).collect(),
        positions: commanded.to_vec(),
        passes: stretches(&times),
        ..Found::none_yet(Ideal::Commanded { why })
    }
}

impl Found {
    fn none_yet(ideal: Ideal) -> Self {
        Self {
            ideal,
            samples: Vec::new(),
            positions: Vec::new(),
            angle_rad: Vec::new(),
            passes: Vec::new(),
            left_out: LeftOut::default(),
        }
    }
}

/// The ideal motion by the cycle, or in words why the recording does not show it.
fn of_cycle(motion: &Motion<'_>, cycle: &Cycle) -> Result<Result<Found, String>, AttributionError> {
    let sweeps = cycle.sweeps();
    let Some((lead, rules)) = lead(motion, cycle).zip(SweepRules::of(cycle)) else {
        return Ok(Err(format!("cycle {} reads at rest", cycle.name)));
    };
    let slowest = sweeps.iter().map(|sweep| sweep.feed_rad_per_s.abs()).fold(f64::INFINITY, f64::min);
    let passes = passes(motion.samples, &lead, MOVING * slowest);
    if passes.len() != sweeps.len() {
        return Ok(Err(format!(
            "cycle {} has {} passes, the positions show {}",
            cycle.name,
            sweeps.len(),
            passes.len()
        )));
    }
    let mut found = Found::none_yet(Ideal::Cycle { name: cycle.name.clone(), turning: lead.turning });
    for (whole, sweep) in passes.into_iter().zip(&sweeps) {
        let (samples, angle_rad) = (&motion.samples[whole.clone()], &lead.angle_rad[whole.clone()]);
        let feed = usual_speed(samples, angle_rad);
        let ratio = feed / sweep.feed_rad_per_s;
        if !(OVERRIDE.recip()..=OVERRIDE).contains(&ratio) {
            return Ok(Err(format!("the passes are not those of cycle {}", cycle.name)));
        }
        let Some(proper) = at_feed(&rules, samples, angle_rad, feed) else {
            return Ok(Err(format!("a pass of cycle {} goes at no constant feed", cycle.name)));
        };
        found.left_out.run_in_and_out += whole.len() - proper.len();
        let line = line(&samples[proper.clone()], &angle_rad[proper.clone()]);
        let first = found.samples.len();
        for i in whole.start + proper.start..whole.start + proper.end {
            let angle = line.at(motion.samples[i].time_s);
            let near = &motion.samples[i].position;
            let commanded = commanded(motion.machine, cycle, sweep, angle, near);
            found.positions.push(commanded.ok_or_else(|| cannot_follow(motion, cycle, sweep))?);
            found.samples.push(i);
            found.angle_rad.push(angle);
        }
        found.passes.push(first..found.samples.len());
    }
    found.left_out.elsewhere = motion.samples.len() - found.samples.len() - found.left_out.run_in_and_out;
    Ok(Ok(found))
}

/// What leads the motion of a cycle on the fly: an axis that turns, or the angle on a curve.
struct Lead {
    turning: Option<Joint>,
    /// At every sample, rad, without jumps.
    angle_rad: Vec<f64>,
    /// Angles of the pass: smallest and largest; of a curve only their difference counts.
    range_rad: (f64, f64),
}

/// `None` for a cycle at rest.
fn lead(motion: &Motion<'_>, cycle: &Cycle) -> Option<Lead> {
    let ordered = |(from, to): (f64, f64)| (from.min(to), from.max(to));
    match &cycle.motion {
        cycle::Motion::Static { .. } | cycle::Motion::Line { .. } => None,
        cycle::Motion::OnTheFly { axis, from_to_rad, .. } => Some(Lead {
            turning: Some(*axis),
            angle_rad: motion.samples.iter().map(|sample| sample.position[*axis]).collect(),
            range_rad: ordered(*from_to_rad),
        }),
        cycle::Motion::Path { from_to_rad, .. } => {
            let mut last = 0.0;
            let mut angle_rad = Vec::with_capacity(motion.samples.len());
            for sample in motion.samples {
                let (place, _) = motion.machine.tool_in_table(&sample.position);
                let angle = cycle.curve_angle_rad(motion.machine, &place)?;
                last += (angle - last + PI).rem_euclid(TAU) - PI;
                angle_rad.push(last);
            }
            Some(Lead { turning: None, angle_rad, range_rad: ordered(*from_to_rad) })
        }
    }
}

fn commanded(
    machine: &Machine,
    cycle: &Cycle,
    sweep: &Sweep,
    angle: f64,
    near: &AxisValues<f64>,
) -> Option<AxisValues<f64>> {
    match cycle.rotary_at(angle) {
        Some(rotary) => cycle.position(machine, sweep.setup, &rotary),
        None => cycle.curve_position(machine, sweep.setup, angle, near),
    }
}

fn cannot_follow(motion: &Motion<'_>, cycle: &Cycle, sweep: &Sweep) -> AttributionError {
    let source = trunnion_cycles::VisitError::CannotFollow {
        machine: motion.machine.name.clone(),
        setup: cycle.setups[sweep.setup].name.clone(),
    };
    AttributionError::Cycle { run: motion.run.into(), source }
}

/// Runs of samples in which the lead goes through (most of) its range in one direction.
fn passes(samples: &[AxisSample], lead: &Lead, slowest: f64) -> Vec<Range<usize>> {
    let (low, high) = lead.range_rad;
    let angle = &lead.angle_rad;
    let inside = |i: usize| lead.turning.is_none() || (low..=high).contains(&angle[i]);
    let heading = |i: usize| -> f64 {
        let speed = (angle[i + 1] - angle[i]) / (samples[i + 1].time_s - samples[i].time_s);
        if inside(i) && inside(i + 1) && speed.abs() > slowest { speed.signum() } else { 0.0 }
    };
    let headings: Vec<f64> = (0..samples.len() - 1).map(heading).collect();
    let mut passes = Vec::new();
    let mut first = 0;
    for steps in headings.chunk_by(|a, b| a == b) {
        let range = first..first + steps.len() + 1;
        first += steps.len();
        let span = angle[range.end - 1] - angle[range.start];
        if steps[0] != 0.0 && span.abs() > COVERED * (high - low) {
            passes.push(range);
        }
    }
    passes
}

/// Speed of the lead over most of a pass, rad/s; not a number where time does not go on.
fn usual_speed(samples: &[AxisSample], angle_rad: &[f64]) -> f64 {
    let steps = samples.windows(2).zip(angle_rad.windows(2));
    let speeds: Vec<f64> = steps
        .map(|(samples, angle)| (angle[1] - angle[0]) / (samples[1].time_s - samples[0].time_s))
        .collect();
    upper_median(&speeds).unwrap_or(f64::NAN)
}

struct Line {
    middle_s: f64,
    middle: f64,
    feed: f64,
}

impl Line {
    fn at(&self, time_s: f64) -> f64 {
        self.middle + self.feed * (time_s - self.middle_s)
    }
}

/// Least-squares line of the lead over time.
fn line(samples: &[AxisSample], angle_rad: &[f64]) -> Line {
    let count = samples.len() as f64;
    let middle_s = samples.iter().map(|sample| sample.time_s).sum::<f64>() / count;
    let middle = angle_rad.iter().sum::<f64>() / count;
    let (mut products, mut squares) = (0.0, 0.0);
    for (sample, angle) in samples.iter().zip(angle_rad) {
        let time_s = sample.time_s - middle_s;
        products += time_s * (angle - middle);
        squares += time_s * time_s;
    }
    Line { middle_s, middle, feed: products / squares }
}

/// Every axis on a smooth path of its own, from one gap in the samples to the next.
fn smoothed(motion: &Motion<'_>, why: String) -> Result<Found, AttributionError> {
    with_knots(motion, why, motion.knot_s)
}

/// The same samples on a path with twice the knots, to hold the first one against.
pub(super) fn smoothed_twice_as_fine(motion: &Motion<'_>) -> Result<Found, AttributionError> {
    with_knots(motion, String::new(), motion.knot_s / 2.0)
}

fn with_knots(motion: &Motion<'_>, why: String, knot_s: f64) -> Result<Found, AttributionError> {
    let times: Vec<f64> = motion.samples.iter().map(|sample| sample.time_s).collect();
    let mut found = Found::none_yet(Ideal::Smooth { knot_s: motion.knot_s, why });
    let stretches = stretches(&times);
    for stretch in &stretches {
        let times = &times[stretch.clone()];
        if !possible(times).contains(&motion.knot_s) {
            continue;
        }
        let Some(path) = smooth::Path::over(times, knot_s) else { continue };
        let mut positions = vec![AxisValues::default(); times.len()];
        for axis in motion.machine.axes() {
            let measured: Vec<f64> =
                motion.samples[stretch.clone()].iter().map(|sample| sample.position[axis.letter]).collect();
            for (position, smooth) in positions.iter_mut().zip(path.through(&measured)) {
                position[axis.letter] = smooth;
            }
        }
        found.passes.push(found.samples.len()..found.samples.len() + times.len());
        found.samples.extend(stretch.clone());
        found.positions.extend(positions);
    }
    if found.samples.is_empty() {
        let longest = stretches.into_iter().max_by_key(ExactSizeIterator::len).unwrap_or_default();
        let possible = possible(&times[longest]);
        let (low, high) = (*possible.start(), *possible.end());
        return Err(AttributionError::Knots { knot_s: motion.knot_s, low, high });
    }
    found.left_out.elsewhere = motion.samples.len() - found.samples.len();
    Ok(found)
}

/// Distances of knots that give four samples for each and four of them in all.
fn possible(times_s: &[f64]) -> RangeInclusive<f64> {
    let duration_s = times_s.last().unwrap_or(&0.0) - times_s.first().unwrap_or(&0.0);
    4.0 * duration_s / times_s.len().max(1) as f64..=duration_s / 4.0
}

/// Ranges of samples without a gap between them.
fn stretches(times_s: &[f64]) -> Vec<Range<usize>> {
    let steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual_s = upper_median(&steps).unwrap_or(0.0);
    let mut first = 0;
    let mut found = Vec::new();
    for stretch in times_s.chunk_by(|a, b| (0.0..=GAP * usual_s).contains(&(b - a))) {
        found.push(first..first + stretch.len());
        first += stretch.len();
    }
    found
}
