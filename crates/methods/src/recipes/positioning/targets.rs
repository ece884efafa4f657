//! Approaches of the targets of one axis, by direction.

use crate::common::{Mounted, Recognised};
use crate::recipes::{Method, MethodError};
use trunnion_core::{InstrumentKind, Joint, Point, Setup};
use trunnion_cycles::Run;
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Machine};

/// Axes that move less than this are at rest, mm or rad.
const STILL_MM: f64 = 0.05;
const STILL_RAD: f64 = 1e-4;
/// Positions nearer than this are one target, mm.
const ONE_TARGET_MM: f64 = 0.05;
/// An axis that moved less stood still: what cycles allow at a pose (`standstill_um`).
const UNMOVED_MM: f64 = 2e-3;
/// Rounding of positions and travels, mm.
const ROUNDING_MM: f64 = 1e-9;

/// What was measured.
pub(super) type Traces = Recognised<Trace>;

/// One axis in one setup.
pub(super) struct Trace {
    /// Name of the axis, with the setup's where several setups have this axis.
    pub name: String,
    pub targets: Vec<Target>,
    /// Readings whose direction of approach is not known.
    pub unknown: usize,
}

/// One target.
pub(super) struct Target {
    pub position_mm: f64,
    /// Approaches going up and going down.
    pub ways: [Option<Approaches>; 2],
}

/// Approaches of a target from one side, mm.
#[derive(Clone, Copy)]
pub(super) struct Approaches {
    pub count: usize,
    pub mean: f64,
    /// Standard deviation of one approach.
    pub s: f64,
}

impl Approaches {
    fn of(deviations: &[f64]) -> Option<Self> {
        let count = deviations.len();
        if count < 2 {
            return None;
        }
        let mean = deviations.iter().sum::<f64>() / count as f64;
        let squares: f64 = deviations.iter().map(|x| (x - mean).powi(2)).sum();
        Some(Self { count, mean, s: (squares / (count - 1) as f64).sqrt() })
    }

    /// Variance of the mean.
    pub fn mean_variance(&self) -> f64 {
        self.s.powi(2) / self.count as f64
    }

    /// Variance of the standard deviation.
    pub fn s_variance(&self) -> f64 {
        self.s.powi(2) / (2 * (self.count - 1)) as f64
    }
}

/// Every axis of the runs.
///
/// # Errors
/// No axis was measured alone, along the beam, more than once.
pub(super) fn recognised(method: &Method, runs: &[Run]) -> Result<Traces, MethodError> {
    let what = "no setup holds targets of one linear axis";
    let next = "Run a cycle such as config/cycles/linear-x.toml.";
    Traces::of(method, runs, (what, next), |Mounted { name, run, setup, points, .. }, others| {
        let trace = trace(&run.machine, setup, points)?;
        let taken = others.iter().any(|other| other.name == trace.name);
        let name = if taken { format!("{} {name}", trace.name) } else { trace.name };
        Ok(Trace { name, ..trace })
    })
}

fn trace(machine: &Machine, setup: &Setup, points: &[&Point]) -> Result<Trace, String> {
    if setup.instrument != InstrumentKind::Diagonal {
        return Err(format!(
            "read by {}, not by an interferometer (diagonal)",
            setup.instrument.with_article()
        ));
    }
    let moves = |letter: &Joint| {
        let positions = points.iter().map(|point| point.state.position[*letter]);
        let (low, high) =
            positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low > if letter.is_rotary() { STILL_RAD } else { STILL_MM }
    };
    let moving: Vec<Joint> = machine.joints().into_iter().filter(moves).collect();
    let [axis] = moving[..] else {
        let names: Vec<&str> = moving.iter().map(|letter| letter.as_str()).collect();
        return Err(format!(
            "{} move, not one linear axis alone",
            if names.is_empty() { "no axes".into() } else { names.join(", ") }
        ));
    };
    if axis.is_rotary() {
        return Err(format!("{axis} turns; the method is for linear axes"));
    }
    let nominal_mm: Vec<f64> =
        points.iter().map(|point| predict(machine, setup, &point.state, &Errors::default()).x).collect();
    let position = |i: usize| points[i].state.position[axis];
    let middle = (0..points.len()).map(position).sum::<f64>() / points.len() as f64;
    let sense = (0..points.len()).map(|i| (position(i) - middle) * nominal_mm[i]).sum::<f64>().signum();
    let ways = ways(axis, points);
    let unknown = ways.iter().filter(|way| way.is_none()).count();
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| position(a).total_cmp(&position(b)));
    let of_target = |chunk: &[usize]| {
        let deviations = |wanted: usize| -> Vec<f64> {
            let own = chunk.iter().filter(|&&i| ways[i] == Some(wanted));
            own.map(|&i| sense * (points[i].reading_mm[0] - nominal_mm[i])).collect()
        };
        let position_mm = chunk.iter().map(|&i| position(i)).sum::<f64>() / chunk.len() as f64;
        Target { position_mm, ways: [0, 1].map(|way| Approaches::of(&deviations(way))) }
    };
    let targets: Vec<Target> =
        order.chunk_by(|&a, &b| position(b) - position(a) < ONE_TARGET_MM).map(of_target).collect();
    let repeated = targets.iter().filter(|target| target.ways.iter().any(Option::is_some)).count();
    if repeated < 2 {
        let direction = match unknown {
            0 => String::new(),
            _ => format!(
                "; of {unknown} readings the direction is not known, state it (direction_{})",
                axis.lower()
            ),
        };
        return Err(format!(
            "{repeated} targets of {axis} were approached twice or more from one side; two or more are needed{direction}"
        ));
    }
    Ok(Trace { name: axis.to_string(), targets, unknown })
}

/// The way on which each point was approached: 0 up, 1 down. Where the axis had not moved since the point before, a direction that nobody stated is
/// that of the point before, and says nothing. It was stated where it changed without a move.
fn ways(axis: Joint, points: &[&Point]) -> Vec<Option<usize>> {
    let position = |i: usize| points[i].state.position[axis];
    let direction = |i: usize| points[i].state.direction[axis];
    let stands = |i: usize| i > 0 && (position(i) - position(i - 1)).abs() < UNMOVED_MM;
    let stated = (1..points.len()).any(|i| stands(i) && direction(i) * direction(i - 1) < 0.0);
    // The axis turns round at this place: the second reading there had an approach of its own only where it went beyond.
    let turns = |i: usize| {
        let away = |k: &usize| (position(*k) - position(i)).abs() >= UNMOVED_MM;
        let (before, after) = ((0..i).rev().find(away), (i..points.len()).find(away));
        before
            .zip(after)
            .is_some_and(|(b, a)| (position(b) - position(i)) * (position(a) - position(i)) > 0.0)
    };
    let unmoved = |i: usize| {
        let since = |k: usize| points[k].state.since_reversal[axis];
        stands(i) && direction(i) == direction(i - 1) && {
            let travel = (since(i) - since(i - 1)).abs();
            travel < ROUNDING_MM || travel < UNMOVED_MM && turns(i)
        }
    };
    let way = |i: usize| {
        let known = direction(i) != 0.0 && (stated || !unmoved(i));
        known.then(|| usize::from(direction(i) < 0.0))
    };
    (0..points.len()).map(way).collect()
}
