//! One noise of a machine, and the points in the order they were taken with what it needs to know of each.

use crate::Experiment;
use crate::problem::sequence::{clocks_and_times, in_order_taken};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::ops::Range;
use trunnion_core::{AxisValues, Joint, Twist};
use trunnion_instruments::Projector;
use trunnion_machine::{Machine, Side, Site};

/// One noise: variances relative to the white noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// a: re-positioning of the slow rotary axis.
    pub pass: f64,
    /// c: angular scatter of the fast rotary axis.
    pub axis: f64,
    /// w: drift.
    pub drift: f64,
    /// τ: correlation time of the drift, in units of time of the order of the points.
    pub tau: f64,
}

/// Points in the order they were taken, with what the noise needs to know of each.
#[derive(Clone, Debug)]
pub struct Order {
    pub(crate) visits: Vec<Visit>,
    /// Correlation time of drift: a quarter of a run.
    pub tau: f64,
    /// The axis that moves least often, if the machine has rotary axes that move.
    pub slow: Option<Joint>,
    /// The rotary axis that moves most often.
    pub fast: Option<Joint>,
}

/// One point, as the noise sees it.
#[derive(Clone, Debug)]
pub(crate) struct Visit {
    pub point: usize,
    pub rows: Range<usize>,
    /// Since the point before of the same run, in units of time of the order; 0 at the start of a run.
    pub since_last: f64,
    pub new_run: bool,
    pub new_station: bool,
    /// Reading for a unit of drift along X, Y, Z.
    pub drift: Matrix3<f64>,
    pub slow_lever: Vector3<f64>,
    pub fast_lever: Vector3<f64>,
}

impl Order {
    /// Orders the points of an experiment by run and time; without time the order of the points is the time.
    pub fn new(experiment: &Experiment) -> Self {
        let clocks_and_times = clocks_and_times(experiment);
        let key = |i: usize| clocks_and_times[i];
        let order = in_order_taken(experiment);
        let (slow, fast) = slow_and_fast(experiment, &order);
        let stand = slow.map(|joint| experiment.stands(&[joint]));
        let turned = |from: usize, to: usize| stand.as_ref().is_some_and(|stand| stand[from] != stand[to]);
        let mut visits = Vec::with_capacity(order.len());
        for (k, &i) in order.iter().enumerate() {
            let previous = (k > 0).then(|| order[k - 1]);
            visits.push(visit(experiment, i, previous, (slow, fast), &turned, key));
        }
        normalise(&mut visits, |visit| &mut visit.slow_lever);
        normalise(&mut visits, |visit| &mut visit.fast_lever);
        let duration: f64 = visits.iter().filter(|v| !v.new_run).map(|v| v.since_last).sum();
        let runs = visits.iter().filter(|v| v.new_run).count().max(1);
        Self { visits, tau: (duration / runs as f64 / 4.0).max(1e-9), slow, fast }
    }

    /// Sequence number of the positioning of the slow axis at each point (indexed by point).
    pub fn stations(&self) -> Vec<usize> {
        let mut station_of_point = vec![0; self.visits.len()];
        let mut station = 0;
        for (k, visit) in self.visits.iter().enumerate() {
            station += usize::from(k > 0 && visit.new_station);
            station_of_point[visit.point] = station;
        }
        station_of_point
    }
}

/// The rotary axis that moves least often and the one that moves most often.
fn slow_and_fast(experiment: &Experiment, order: &[usize]) -> (Option<Joint>, Option<Joint>) {
    let moves = |letter: Joint| {
        let stand = experiment.stands(&[letter]);
        order.windows(2).filter(|pair| stand[pair[0]] != stand[pair[1]]).count()
    };
    let mut moving: Vec<(usize, Joint)> =
        experiment.machine().rotary().iter().map(|axis| (moves(axis.letter), axis.letter)).collect();
    moving.retain(|(count, _)| *count > 0);
    moving.sort();
    let fast = moving.last().map(|(_, letter)| *letter);
    let slow = (moving.len() > 1).then(|| moving[0].1);
    (slow, fast)
}

fn visit(
    experiment: &Experiment,
    point: usize,
    previous: Option<usize>,
    (slow, fast): (Option<Joint>, Option<Joint>),
    turned: &dyn Fn(usize, usize) -> bool,
    key: impl Fn(usize) -> (usize, f64),
) -> Visit {
    let machine = experiment.machine();
    let state = &experiment.points[point].state;
    let projector = Projector::new(machine, &experiment.setups[state.setup], state);
    let new_run = previous.is_none_or(|p| key(p).0 != key(point).0);
    let station_changed = |p: usize| {
        let before = &experiment.points[p].state;
        let reversed = |letter: Joint| before.direction[letter] * state.direction[letter] < 0.0;
        before.setup != state.setup || turned(p, point) || slow.is_some_and(reversed)
    };
    let lever = |letter: Option<Joint>| -> Vector3<f64> {
        let axis = letter.and_then(|l| machine.axis(l));
        axis.map_or_else(Vector3::zeros, |a| projector.column(Site::Joint(a.letter), &a.positioning_twist()))
    };
    let (ground, into_ground) = ground_joint(machine, &state.position);
    let drift = |k: usize| projector.column(ground, &Twist::translation(into_ground * Vector3::ith(k, 1.0)));
    Visit {
        point,
        rows: experiment.rows_of(point),
        since_last: if new_run { 0.0 } else { previous.map_or(0.0, |p| key(point).1 - key(p).1) },
        new_run,
        new_station: new_run || previous.is_none_or(station_changed),
        drift: Matrix3::from_columns(&[drift(0), drift(1), drift(2)]),
        slow_lever: lever(slow),
        fast_lever: lever(fast),
    }
}

/// A site that moves the whole tool side (or, without one, the table), and its axes from machine axes.
pub fn ground_joint(machine: &Machine, position: &AxisValues<f64>) -> (Site, UnitQuaternion<f64>) {
    match machine.from_bed(Side::Table).first() {
        Some(axis) if machine.tool.is_empty() => (Site::Joint(axis.letter), UnitQuaternion::identity()),
        _ => machine.whole_tool_side(position),
    }
}

/// Scales levers to a mean square of 1 per reading.
fn normalise(visits: &mut [Visit], lever: impl Fn(&mut Visit) -> &mut Vector3<f64>) {
    let (mut sum, mut count) = (0.0, 0);
    for visit in visits.iter_mut() {
        count += visit.rows.len();
        sum += lever(visit).norm_squared();
    }
    let mean_square: f64 = sum / count.max(1) as f64;
    let scale = if mean_square > 1e-12 { 1.0 / mean_square.sqrt() } else { 0.0 };
    for visit in visits.iter_mut() {
        *lever(visit) *= scale;
    }
}
