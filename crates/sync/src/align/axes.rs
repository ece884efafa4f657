//! The history of the axes: interpolation, reversals, modulo axes.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};
use trunnion_core::{AxisSample, AxisValues, Slot};

/// Smallest motion back that counts as a reversal: more than the overshoot of a servo coming to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReversalBand {
    /// Linear axes, mm.
    pub linear_mm: f64,
    /// Rotary axes, rad.
    pub rotary_rad: f64,
}

impl Default for ReversalBand {
    fn default() -> Self {
        Self { linear_mm: 0.005, rotary_rad: 1e-4 }
    }
}

impl ReversalBand {
    fn of(&self, letter: Slot) -> f64 {
        if letter.is_rotary() { self.rotary_rad } else { self.linear_mm }
    }
}

/// The axes at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisState {
    /// When, s since the run began.
    pub time_s: f64,
    /// Positions, mm and rad.
    pub position: AxisValues<f64>,
    /// Velocities, mm/s and rad/s.
    pub velocity: AxisValues<f64>,
    /// Accelerations, mm/s² and rad/s².
    pub acceleration: AxisValues<f64>,
    /// Direction of the last motion: −1, 0 (none seen yet), +1.
    pub direction: AxisValues<f64>,
    /// Travel since the last reversal, mm and rad.
    pub since_reversal: AxisValues<f64>,
}

/// An axis sample with what the samples before it show.
#[derive(Clone, Copy, Debug)]
struct Node {
    time_s: f64,
    position: AxisValues<f64>,
    tracks: AxisValues<Track>,
}

/// Where an axis last turned round.
#[derive(Clone, Copy, Debug, Default)]
struct Track {
    direction: f64,
    /// Position of the last reversal, or of the first sample.
    turned_at: f64,
    /// Farthest position since, in the direction of motion.
    farthest: f64,
}

/// Axis samples, a few seconds of them.
#[derive(Clone, Debug)]
pub(super) struct AxisHistory {
    longest_s: f64,
    band: ReversalBand,
    nodes: VecDeque<Node>,
    /// Index of the first node not yet given out.
    next: usize,
}

/// Nodes kept: 8 s at 500 Hz.
const MAX_NODES: usize = 4096;

impl AxisHistory {
    pub(super) fn new(longest_s: f64, band: ReversalBand) -> Self {
        Self { longest_s, band, nodes: VecDeque::new(), next: 0 }
    }

    /// False when the sample is not later than the last one or not finite.
    pub(super) fn push(&mut self, sample: &AxisSample) -> bool {
        let finite = sample.time_s.is_finite() && sample.position.0.iter().all(|p| p.is_finite());
        let last = self.nodes.back().copied();
        if !finite || last.is_some_and(|last| sample.time_s <= last.time_s) {
            return false;
        }
        let joined = last.filter(|last| sample.time_s - last.time_s <= self.longest_s);
        let position = AxisValues::from_fn(|letter| match joined {
            Some(last) if letter.is_rotary() => nearest_turn(sample.position[letter], last.position[letter]),
            _ => sample.position[letter],
        });
        let tracks = AxisValues::from_fn(|letter| {
            let start = Track { direction: 0.0, turned_at: position[letter], farthest: position[letter] };
            last.map_or(start, |last| last.tracks[letter].follow(position[letter], self.band.of(letter)))
        });
        self.nodes.push_back(Node { time_s: sample.time_s, position, tracks });
        if self.nodes.len() > MAX_NODES {
            self.nodes.pop_front();
            self.next = self.next.saturating_sub(1);
        }
        true
    }

    pub(super) fn next_time(&self) -> Option<f64> {
        self.nodes.get(self.next).map(|node| node.time_s)
    }

    /// The next node as a state; waits for its successor, which its velocity needs, unless `at_once`.
    pub(super) fn take_next(&mut self, at_once: bool) -> Option<AxisState> {
        if !at_once && self.next + 1 >= self.nodes.len() {
            return None;
        }
        let node = self.nodes.get(self.next)?;
        let state = state(
            node.time_s,
            node.position,
            self.slopes(self.next),
            self.curvatures(self.next),
            &node.tracks,
        );
        self.next += 1;
        // Two nodes behind the next one are enough to interpolate; instants come in order.
        while self.next > 4 {
            self.nodes.pop_front();
            self.next -= 1;
        }
        Some(state)
    }

    /// True when an answer for this instant will not change any more: two nodes lie at or behind it.
    pub(super) fn is_known_around(&self, time_s: f64) -> bool {
        self.nodes.iter().rev().take(2).filter(|node| node.time_s >= time_s).count() == 2
    }

    /// The axes at an instant between two nodes not farther apart than allowed.
    pub(super) fn at(&self, time_s: f64) -> Option<AxisState> {
        let after = self.nodes.partition_point(|node| node.time_s < time_s);
        let b = self.nodes.get(after)?;
        if b.time_s == time_s {
            return Some(state(time_s, b.position, self.slopes(after), self.curvatures(after), &b.tracks));
        }
        let before = after.checked_sub(1)?;
        let a = &self.nodes[before];
        let h = b.time_s - a.time_s;
        if h > self.longest_s {
            return None;
        }
        let s = (time_s - a.time_s) / h;
        let (slopes_a, slopes_b) = (self.slopes(before), self.slopes(after));
        let (curved_a, curved_b) = (self.curvatures(before), self.curvatures(after));
        let position =
            AxisValues::from_fn(|k| hermite(s, h, a.position[k], b.position[k], slopes_a[k], slopes_b[k]));
        let velocity = AxisValues::from_fn(|k| {
            hermite_slope(s, h, a.position[k], b.position[k], slopes_a[k], slopes_b[k])
        });
        let acceleration = AxisValues::from_fn(|k| curved_a[k] + s * (curved_b[k] - curved_a[k]));
        Some(state(time_s, position, velocity, acceleration, &b.tracks))
    }

    /// Velocity at a node: of the parabola through its neighbours, one-sided beside a gap or the end.
    fn slopes(&self, i: usize) -> AxisValues<f64> {
        let (left, right) = (self.secants(i.wrapping_sub(1)), self.secants(i));
        AxisValues::from_fn(|k| match (left, right) {
            (Some((hl, dl)), Some((hr, dr))) => (dl[k] * hr + dr[k] * hl) / (hl + hr),
            (Some((_, d)), None) | (None, Some((_, d))) => d[k],
            (None, None) => 0.0,
        })
    }

    fn curvatures(&self, i: usize) -> AxisValues<f64> {
        match (self.secants(i.wrapping_sub(1)), self.secants(i)) {
            (Some((hl, dl)), Some((hr, dr))) => AxisValues::from_fn(|k| 2.0 * (dr[k] - dl[k]) / (hl + hr)),
            _ => AxisValues::default(),
        }
    }

    /// Distance in time and mean velocity from node i to the next; none across a gap.
    fn secants(&self, i: usize) -> Option<(f64, AxisValues<f64>)> {
        let (a, b) = (self.nodes.get(i)?, self.nodes.get(i.checked_add(1)?)?);
        let h = b.time_s - a.time_s;
        (h <= self.longest_s).then(|| (h, AxisValues::from_fn(|k| (b.position[k] - a.position[k]) / h)))
    }
}

impl Track {
    fn follow(self, position: f64, band: f64) -> Self {
        let mut track = self;
        if track.direction == 0.0 {
            let moved = position - track.turned_at;
            if moved.abs() > band {
                track.direction = moved.signum();
                track.farthest = position;
            }
        } else if (position - track.farthest) * track.direction >= 0.0 {
            track.farthest = position;
        } else if (position - track.farthest).abs() > band {
            track = Self { direction: -track.direction, turned_at: track.farthest, farthest: position };
        }
        track
    }
}

fn state(
    time_s: f64,
    position: AxisValues<f64>,
    velocity: AxisValues<f64>,
    acceleration: AxisValues<f64>,
    tracks: &AxisValues<Track>,
) -> AxisState {
    AxisState {
        time_s,
        position,
        velocity,
        acceleration,
        direction: AxisValues::from_fn(|k| tracks[k].direction),
        since_reversal: AxisValues::from_fn(|k| (position[k] - tracks[k].turned_at).abs()),
    }
}

/// A controller that shows 0..360° jumps by a turn where the axis goes on; a true jump of half a turn between two
/// samples is beyond any axis.
fn nearest_turn(position: f64, last: f64) -> f64 {
    let turns = ((last - position) / TAU).round();
    if (position - last).abs() > PI { position + turns * TAU } else { position }
}

fn hermite(s: f64, h: f64, p0: f64, p1: f64, v0: f64, v1: f64) -> f64 {
    let (s2, s3) = (s * s, s * s * s);
    (2.0 * s3 - 3.0 * s2 + 1.0) * p0
        + (s3 - 2.0 * s2 + s) * h * v0
        + (3.0 * s2 - 2.0 * s3) * p1
        + (s3 - s2) * h * v1
}

fn hermite_slope(s: f64, h: f64, p0: f64, p1: f64, v0: f64, v1: f64) -> f64 {
    let s2 = s * s;
    (6.0 * s2 - 6.0 * s) / h * (p0 - p1) + (3.0 * s2 - 4.0 * s + 1.0) * v0 + (3.0 * s2 - 2.0 * s) * v1
}
