//! Sweeps: all readings of one run that were taken one way at one feed, all its setups together, and the base model fitted to each.

use super::read::Read;
use crate::common::feed::{by_feed, feed_of};
use crate::recipes::{Method, MethodError};
use nalgebra::Vector3;
use trunnion_core::statistics::upper_median;
use trunnion_core::{AxisValues, Joint, Point};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::catalogue::effect;
use trunnion_effects::{Model, Role, Unit};
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, FittedParameter, HeldOut, Identification, Uncertainties, identify};
use trunnion_machine::Machine;

/// A feed held over less than this share of the path is a ramp between feeds: 0.5 s of ramp at either end of 30 s are 1.7 % of the path.
/// A judgement, tuned on no data.
const RAMP: f64 = 0.03;
/// Fewer readings are no sweep: the base model has some ten unknowns. A judgement, tuned on no data.
const LEAST_READINGS: usize = 12;
/// Where more of the readings belong to no sweep, the feed is not constant. A judgement, tuned on no data.
const MOST_LEFT_OUT: f64 = 0.2;
/// Steps this many times as long as usual are a pause, so that another sweep begins; three lost readings in a row are none. A judgement, tuned on
/// no data.
const PAUSE: f64 = 4.0;
/// An axis that is slower stands, mm/s and rad/s.
const STANDS: f64 = 1e-9;

/// Sine of the angle between path and place, from the middle, below which a path is straight: 0.6°, where a circle has 90° and a straight line
/// that is read a few hundredths of a millimetre off its middle none. A judgement, tuned on no data.
const ROUND: f64 = 0.01;

/// What all sweeps gave.
pub(super) struct Sweeps {
    pub all: Vec<Sweep>,
    /// Unit of a feed.
    pub unit: Unit,
    /// What every sweep determines.
    pub errors: Vec<SplitError>,
    /// Settings may have changed between runs and are left out.
    pub several_runs: bool,
    /// Readings that belong to no sweep.
    pub left_out: usize,
}

/// An error, or a setting, that is split.
pub(super) struct SplitError {
    pub name: String,
    pub unit: Unit,
    /// What mounting left.
    pub is_setting: bool,
}

/// One sweep.
pub(super) struct Sweep {
    /// −1 or +1.
    pub way: f64,
    /// Speed, mm/s or rad/s.
    pub feed: f64,
    /// Of [`Sweeps::errors`], inside units.
    pub values: Vec<f64>,
    /// What the base model leaves, mm.
    pub rms_mm: f64,
    /// Its readings; `None` where the fit took means of them.
    pub read: Option<Read>,
}

/// Feeds as a control has them.
const MM_PER_MIN: Unit = Unit { symbol: "mm/min", per_inside: 60.0 };
const DEG_PER_MIN: Unit = Unit { symbol: "deg/min", per_inside: 60.0 * Unit::DEG.per_inside };

/// Finds the sweeps and fits each; `asked`: the axis that must turn.
pub(super) fn fitted(method: &Method, runs: &[Run], asked: Option<Joint>) -> Result<Sweeps, MethodError> {
    let machine = &runs[0].machine;
    let mut groups: Vec<Group> = Vec::new();
    let mut left_out = 0;
    let leading = Leading::of(machine, runs).ok_or_else(|| {
        method.lacks(
            "no axis moves while it is read",
            "Run a cycle on the fly, such as config/cycles/r-test-feeds-c.toml.",
        )
    })?;
    if let Some(asked) = asked.filter(|asked| leading.turns() != Some(*asked)) {
        let turns = leading.turns().map_or("linear axes move".into(), |joint| format!("axis {joint} turns"));
        let found = format!("axis {asked} is asked for, but {turns}");
        return Err(method.lacks(found, "Leave --axis out, or give runs of that axis."));
    }
    let mut total = 0;
    for (of_run, run) in runs.iter().enumerate() {
        let mut grouped = grouped((of_run, run), &leading);
        grouped.retain(|group| group.numbers.len() >= LEAST_READINGS);
        total += run.good_points().count();
        left_out +=
            run.good_points().count() - grouped.iter().map(|group| group.numbers.len()).sum::<usize>();
        groups.extend(grouped);
    }
    if left_out as f64 > MOST_LEFT_OUT * total as f64 {
        let found = format!("{left_out} of {total} readings are at no constant feed");
        return Err(
            method.lacks(found, "Turn one rotary axis, or run a circle of linear axes, at constant feeds.")
        );
    }
    let several_runs = runs.len() > 1;
    let mut all = Vec::new();
    let mut errors: Option<Vec<SplitError>> = None;
    for group in &groups {
        let options = Options {
            holdout: HeldOut::Skipped,
            uncertainties: Uncertainties::Clusters,
            ..Options::default()
        };
        let experiment = Experiment::new(&[group.taken_alone()])?;
        let fit = identify(&experiment, &Model::base(&machine.name), &options).map_err(|why| {
            let found =
                format!("one sweep of {} readings has no fit of its own ({why})", group.numbers.len());
            method.lacks(found, "Read more places in each sweep.")
        })?;
        let is_split = |parameter: &&FittedParameter| {
            parameter.u.is_some() && (!several_runs || parameter.effect == "location-errors")
        };
        let found: Vec<_> = fit.parameters.iter().filter(is_split).collect();
        let known = |name: &str| found.iter().any(|parameter| parameter.name == name);
        match &mut errors {
            None => {
                let split = |p: &&FittedParameter| SplitError {
                    name: p.name.clone(),
                    unit: p.unit,
                    is_setting: effect(&p.effect).is_some_and(|effect| effect.role == Role::Setting),
                };
                errors = Some(found.iter().map(split).collect());
            }
            Some(errors) => errors.retain(|error| known(&error.name)),
        }
        all.push((group, experiment, fit));
    }
    let errors = errors.filter(|errors| !errors.is_empty()).ok_or_else(|| {
        method
            .lacks("one sweep determines no error", "Choose a path that shows errors, such as a whole turn.")
    })?;
    let sweep = |(group, experiment, fit): (&Group<'_>, Experiment, Identification)| {
        let of = |error: &SplitError| fit.parameter(&error.name).and_then(|found| found.value);
        let values: Vec<f64> = errors.iter().map(|error| of(error).unwrap_or(f64::NAN)).collect();
        let names: Vec<&str> = errors.iter().map(|error| error.name.as_str()).collect();
        let read = Read::of(&experiment, &fit, &names, &values, (group.of_run, &group.numbers));
        Sweep { way: group.way, feed: group.feed, rms_mm: fit.rms_mm, read, values }
    };
    let all = all.into_iter().map(sweep).collect();
    let unit = if leading.turns().is_some() { DEG_PER_MIN } else { MM_PER_MIN };
    Ok(Sweeps { all, unit, errors, several_runs, left_out })
}

/// Points of a sweep.
struct Group<'a> {
    run: &'a Run,
    /// Number of the run.
    of_run: usize,
    way: f64,
    feed: f64,
    /// Numbers of its points among the good ones of the run.
    numbers: Vec<usize>,
}

impl Group<'_> {
    /// The run with the readings of this sweep alone.
    fn taken_alone(&self) -> Run {
        let good: Vec<&Point> = self.run.good_points().collect();
        Run { points: self.numbers.iter().map(|&number| good[number].clone()).collect(), ..self.run.clone() }
    }
}

/// What the feed is measured by: the rotary axis that turns most, else the linear axes together.
enum Leading {
    Rotary(Joint),
    Linear {
        /// Middle of the path, mm.
        middle: Vector3<f64>,
        /// Across the plane of the path.
        across: Vector3<f64>,
    },
}

impl Leading {
    fn of(machine: &Machine, runs: &[Run]) -> Option<Self> {
        let points = || runs.iter().filter(|run| run.kind == RunKind::OnTheFly).flat_map(Run::good_points);
        let fastest = |joint: Joint| points().map(|p| p.state.velocity[joint].abs()).fold(0.0, f64::max);
        let turning = machine.rotary_joints().into_iter().filter(|&joint| fastest(joint) > STANDS);
        if let Some(joint) = turning.max_by(|&a, &b| fastest(a).total_cmp(&fastest(b))) {
            return Some(Self::Rotary(joint));
        }
        if Joint::LINEAR.into_iter().all(|joint| fastest(joint) <= STANDS) {
            return None;
        }
        let count = points().count() as f64;
        let middle = points().map(|p| linear(&p.state.position)).sum::<Vector3<f64>>() / count;
        let turned = |p: &Point| (linear(&p.state.position) - middle).cross(&linear(&p.state.velocity));
        let swept = points().map(|p| turned(p).abs()).sum::<Vector3<f64>>();
        let across = Vector3::ith(swept.imax(), 1.0);
        Some(Self::Linear { middle, across })
    }

    /// The rotary axis.
    fn turns(&self) -> Option<Joint> {
        match self {
            Self::Rotary(joint) => Some(*joint),
            Self::Linear { .. } => None,
        }
    }

    /// Speed, with the direction as its sign.
    fn velocity(&self, point: &Point) -> f64 {
        match self {
            Self::Rotary(joint) => point.state.velocity[*joint],
            Self::Linear { middle, across } => {
                let velocity = linear(&point.state.velocity);
                let turned = (linear(&point.state.position) - middle).cross(&velocity).dot(across);
                // On a straight line the direction is that of the axes.
                let round = ROUND * (linear(&point.state.position) - middle).norm() * velocity.norm();
                let way = if turned.abs() < round { velocity.sum() } else { turned };
                velocity.norm() * way.signum()
            }
        }
    }
}

fn linear(values: &AxisValues<f64>) -> Vector3<f64> {
    Vector3::from_fn(|k, _| values[Joint::LINEAR[k]])
}

/// Readings of a run by way, feed, and how often that feed was run that way in each setup.
fn grouped<'a>((of_run, run): (usize, &'a Run), leading: &Leading) -> Vec<Group<'a>> {
    if run.kind != RunKind::OnTheFly {
        return Vec::new();
    }
    let points: Vec<(&Point, f64)> =
        run.good_points().map(|point| (point, leading.velocity(point))).collect();
    let feeds = held(points.iter().map(|(_, velocity)| velocity.abs()).collect());
    let steps: Vec<f64> = points.windows(2).filter_map(step_s).filter(|step| *step > 0.0).collect();
    let usual_s = upper_median(&steps).unwrap_or(f64::INFINITY);
    // (setup, way, feed) of the sweep under way, and how many of each kind there were.
    let mut groups: Vec<(Group<'a>, usize, usize)> = Vec::new();
    let mut begun: Vec<(usize, bool, usize)> = Vec::new();
    let mut last: Option<((usize, bool, usize), &Point)> = None;
    for (number, (point, velocity)) in points.into_iter().enumerate() {
        let Some(feed) = feed_of(&feeds, velocity.abs()) else { continue };
        let kind = (point.state.setup, velocity > 0.0, feed);
        let goes_on = last.is_some_and(|(before, from)| {
            before == kind && step_s(&[(from, 0.0), (point, 0.0)]).is_none_or(|step| step <= PAUSE * usual_s)
        });
        if !goes_on {
            begun.push(kind);
        }
        last = Some((kind, point));
        let turn = begun.iter().filter(|other| **other == kind).count();
        let way = velocity.signum();
        let same = |(group, of_feed, of_turn): &&mut (Group<'a>, usize, usize)| {
            group.way == way && (*of_feed, *of_turn) == (feed, turn)
        };
        match groups.iter_mut().find(same) {
            Some((group, ..)) => group.numbers.push(number),
            None => {
                let group = Group { run, of_run, way, feed: feeds[feed], numbers: vec![number] };
                groups.push((group, feed, turn));
            }
        }
    }
    groups.into_iter().map(|(group, ..)| group).collect()
}

/// Feeds that were held over enough of the path, slowest first. Readings follow one another in time, so each stands for a way that goes as its
/// speed.
fn held(mut speeds: Vec<f64>) -> Vec<f64> {
    speeds.retain(|speed| *speed > STANDS);
    let least = RAMP * speeds.iter().sum::<f64>();
    let held = |speeds: &&Vec<f64>| speeds.iter().sum::<f64>() >= least;
    by_feed(speeds).iter().filter(held).filter_map(|speeds| upper_median(speeds)).collect()
}

fn step_s(pair: &[(&Point, f64)]) -> Option<f64> {
    Some(pair[1].0.state.time_s? - pair[0].0.state.time_s?)
}
