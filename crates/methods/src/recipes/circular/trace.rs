//! Circles among the readings: bar in a coordinate plane, two linear axes moving, nothing else.

use super::plate;
use super::reversals;
use super::sample::{Reversal, Sample};
use crate::common::feed::by_feed;
use crate::common::{Mounted, Recognised};
use crate::recipes::{Method, MethodError};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};
use trunnion_core::statistics::upper_median;
use trunnion_core::{InstrumentKind, Joint, Point, Setup, State, chain};
use trunnion_cycles::{Run, RunKind};
use trunnion_engine::Experiment;
use trunnion_instruments::predict;
use trunnion_machine::{Errors, JointErrors, Machine};

/// Axes that move less than this are at rest, mm or rad.
const STILL_MM: f64 = 0.05;
const STILL_RAD: f64 = 1e-4;
/// A ball that is z out of the plane makes a bar of length L longer by z²/2L; up to this it is no circle's error, mm.
const OUT_OF_PLANE_MM: f64 = 1e-4;
/// Rows farther apart than so many usual steps do not follow a path; feeds of one circle do not differ by so much. A judgement, tuned on no data.
const FARTHEST_STEPS: f64 = 10.0;
/// A wider gap is no step between readings: what the circle would read there is not known. A sixth of the shortest lobe that the list has.
const WHOLE_RAD: f64 = PI / 9.0;
/// Fewer readings at a speed are those of an axis that starts or stops: a tenth of a circle is 36°. A judgement, tuned on no data.
const FEED_SHARE: f64 = 0.1;
/// The list has some twenty unknowns.
const LEAST_READINGS: usize = 60;

/// The planes, first letter to the right.
const PLANES: [[Joint; 2]; 3] = [[Joint::X, Joint::Y], [Joint::Y, Joint::Z], [Joint::Z, Joint::X]];

/// The circles.
pub(super) type Traces = Recognised<Trace>;

/// One setup of one run.
pub(super) struct Trace {
    /// `XY`, with the setup's name when several setups have this plane.
    pub name: String,
    pub plane: [Joint; 2],
    pub radius_mm: f64,
    /// The bar's length is known.
    pub calibrated: bool,
    pub on_the_fly: bool,
    /// The arc that was read where that is no whole circle, rad.
    pub arc_rad: Option<f64>,
    /// Where the speed along the path is from.
    pub speed: Speed,
    /// The run with the readings of this trace alone.
    pub run: Run,
    /// All of them, in the order they were read: the values of ISO 230-4.
    pub read: Vec<Sample>,
    /// Those that the list is fitted to.
    pub samples: Vec<Sample>,
    /// How many readings are in no fit because an axis reversed between them and the row before.
    pub between: usize,
    /// How many beginnings of a pass there are at which an axis may have reversed.
    pub beginnings: usize,
}

/// Where the speed along the path is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Speed {
    /// The run was read on the fly.
    Run,
    /// Times of rows that follow the path.
    Times,
    /// There are times, but the rows do not follow them along the path.
    OutOfOrder,
    /// Rows one after the other have the same time.
    TooCoarse,
    /// No time, no feed.
    Unknown,
}

impl Trace {
    /// Whether the circle was read both ways.
    pub fn both_ways(&self) -> bool {
        [1.0, -1.0].iter().all(|way| self.samples.iter().any(|sample| sample.way == *way))
    }

    /// Whether the run shows the speed along the path.
    pub fn knows_speed(&self) -> bool {
        matches!(self.speed, Speed::Run | Speed::Times)
    }

    /// The readings that the list is fitted to, as causes of the catalogue see them.
    ///
    /// # Errors
    /// Why they give no columns, a part of a sentence.
    pub fn readings(&self) -> Result<Experiment, String> {
        let readings =
            Experiment::of_points(std::slice::from_ref(&self.run)).map_err(|error| chain(&error))?;
        match readings.rows() == self.samples.len() {
            true => Ok(readings),
            false => Err(format!("{} of {} readings can be used", readings.rows(), self.samples.len())),
        }
    }

    /// Feeds along the path, slowest first; empty where they are not known.
    pub fn feeds_mm_per_s(&self) -> Vec<f64> {
        let known = self.samples.iter().filter(|_| self.knows_speed()).map(|sample| sample.speed_mm_per_s);
        let feeds = by_feed(known.filter(|speed| *speed > 0.0).collect());
        let least = FEED_SHARE * self.samples.len() as f64;
        feeds
            .iter()
            .filter(|of_feed| of_feed.len() as f64 >= least)
            .filter_map(|of_feed| upper_median(of_feed))
            .collect()
    }
}

/// Every circle of the runs.
///
/// # Errors
/// No circle.
pub(super) fn recognised(method: &Method, runs: &[Run]) -> Result<Traces, MethodError> {
    let what = "no setup holds a circle of two linear axes";
    let next = "Run a cycle such as config/cycles/circle-xy.toml; rotary axes under a ball bar are for --method ball-bar.";
    Traces::of(method, runs, (what, next), |Mounted { name, run, setup, points, .. }, others| {
        let trace = match setup.instrument {
            InstrumentKind::CrossGrid => {
                let run = plate::by_a_bar(run, setup, points)?;
                let points: Vec<&Point> = run.points.iter().collect();
                circle(&run, &run.setups[points[0].state.setup], &points)?
            }
            _ => circle(run, setup, points)?,
        };
        let taken = others.iter().any(|other| other.plane == trace.plane);
        let name = if taken { format!("{} {name}", trace.name) } else { trace.name };
        Ok(Trace { name, on_the_fly: run.kind == RunKind::OnTheFly, ..trace })
    })
}

fn circle(run: &Run, setup: &Setup, points: &[&Point]) -> Result<Trace, String> {
    let machine = &run.machine;
    if setup.instrument != InstrumentKind::BallBar {
        return Err(format!(
            "read by {}, not by a ball bar or a cross-grid encoder",
            setup.instrument.with_article()
        ));
    }
    if points.len() < LEAST_READINGS {
        return Err(format!("has {} readings; {LEAST_READINGS} or more separate the errors", points.len()));
    }
    let moves = |letter: &Joint| {
        let positions = || points.iter().map(|p| p.state.position[*letter]);
        let (low, high) =
            positions().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low > if letter.is_rotary() { STILL_RAD } else { STILL_MM }
    };
    let moving: Vec<Joint> = machine.joints().into_iter().filter(moves).collect();
    let plane =
        PLANES.into_iter().find(|plane| moving.len() == 2 && plane.iter().all(|l| moving.contains(l)));
    let Some([a, b]) = plane else {
        let names: Vec<_> = moving.iter().map(|letter| letter.as_str()).collect();
        return Err(match names.is_empty() {
            true => "nothing moves".into(),
            false => format!("{} move, not two linear axes alone", names.join(", ")),
        });
    };
    let bars: Vec<Vector3<f64>> = points.iter().map(|p| bar_mm(machine, setup, p)).collect();
    let out_of_plane = 3 - a.index() - b.index();
    if let Some(bar) = bars.iter().find(|bar| bar[out_of_plane].powi(2) > 2.0 * OUT_OF_PLANE_MM * bar.norm())
    {
        return Err(format!("the bar leaves the plane {a}{b} by {:.3} mm", bar[out_of_plane].abs()));
    }
    let angles: Vec<f64> = bars.iter().map(|bar| bar[b.index()].atan2(bar[a.index()])).collect();
    let quadrants = [0, 1, 2, 3].map(|q| {
        let middle = std::f64::consts::FRAC_PI_4 + std::f64::consts::FRAC_PI_2 * f64::from(q);
        angles.iter().any(|angle| (angle - middle).cos() > 0.9)
    });
    if quadrants.iter().filter(|seen| **seen).count() < 2 {
        return Err("the bar turns by less than half a circle".into());
    }
    let radius_mm = bars.iter().map(|bar| bar.norm()).sum::<f64>() / bars.len() as f64;
    // Whether a positive coordinate moves the tool against the table along its letter, or the other way.
    let sense = [a, b].map(|letter| {
        let mean = points.iter().map(|p| p.state.position[letter]).sum::<f64>() / points.len() as f64;
        let together =
            points.iter().zip(&bars).map(|(p, bar)| (p.state.position[letter] - mean) * bar[letter.index()]);
        together.sum::<f64>().signum()
    });
    let samples = (0..points.len()).map(|i| {
        let (state, angle_rad) = (&points[i].state, angles[i]);
        let (from, to) = if i + 1 < angles.len() { (i, i + 1) } else { (i - 1, i) };
        // Between passes the angle jumps back: the directions of the axes show the way there.
        let stated =
            sense[1] * state.direction[b] * angle_rad.cos() - sense[0] * state.direction[a] * angle_rad.sin();
        let step = if stated.abs() > 0.1 { stated } else { (angles[to] - angles[from]).sin() };
        let way = if step < 0.0 { -1.0 } else { 1.0 };
        let along = [-way * angle_rad.sin(), way * angle_rad.cos()];
        let reading_mm = points[i].reading_mm[0] - predict(machine, setup, state, &Errors::default()).x;
        Sample {
            angle_rad,
            way,
            deviation_mm: reading_mm,
            direction: [0, 1].map(|k| match sense[k] * state.direction[[a, b][k]] {
                stated if stated != 0.0 => stated.signum(),
                _ => along[k].signum(),
            }),
            reversal: [0, 1].map(|k| {
                Reversal::Since(match state.since_reversal[[a, b][k]].abs() {
                    stated if stated > 0.0 => stated,
                    // From the last end of the diameter.
                    _ => radius_mm * (1.0 + along[k].signum() * [angle_rad.cos(), angle_rad.sin()][k]),
                })
            }),
            position_mm: [a, b].map(|letter| state.position[letter]),
            speed_mm_per_s: state.velocity[a].hypot(state.velocity[b]),
        }
    });
    let mut samples: Vec<Sample> = samples.collect();
    let speed = match samples.iter().any(|sample| sample.speed_mm_per_s > 0.0) {
        true => Speed::Run,
        false => speed_by_times(points, &mut samples),
    };
    let step_mm =
        |one: &Sample, two: &Sample| (Vector2::from(two.position_mm) - Vector2::from(one.position_mm)).norm();
    let usual_mm = usual(samples.windows(2).map(|two| step_mm(&two[0], &two[1])));
    let begins =
        |one: &Sample, two: &Sample| one.way != two.way || step_mm(one, two) > FARTHEST_STEPS * usual_mm;
    // At both ends of a pass the speed is known from one side alone, and an axis may just have begun to move.
    let is_end = |i: usize| {
        let (before, after) = (i.checked_sub(1).map(|before| &samples[before]), samples.get(i + 1));
        let here = &samples[i];
        before.is_none_or(|before| begins(before, here)) || after.is_none_or(|after| begins(here, after))
    };
    let is_between = |i: usize| {
        let before = i.checked_sub(1).map(|before| &samples[before]);
        let of_pass = before.filter(|before| !begins(before, &samples[i]));
        reversals::is_between(of_pass, &samples[i], usual_mm / radius_mm)
    };
    let is_cut = |i: usize| run.kind == RunKind::OnTheFly && is_end(i);
    let (between, used): (Vec<usize>, Vec<usize>) =
        (0..samples.len()).filter(|&i| !is_cut(i)).partition(|&i| is_between(i));
    let mut points: Vec<Point> = used.iter().map(|&i| points[i].clone()).collect();
    let read = samples;
    let mut samples: Vec<Sample> = used.iter().map(|&i| read[i]).collect();
    let beginnings = reversals::find(&mut samples, radius_mm, begins);
    for (point, sample) in points.iter_mut().zip(&samples) {
        // One direction for the list and for what else may read as its errors, also where the run states none.
        for (k, letter) in [a, b].into_iter().enumerate() {
            point.state.direction[letter] = sense[k] * sample.direction[k];
        }
        if speed == Speed::Run {
            move_on_circle(&mut point.state, sample, [a, b], sense, radius_mm);
        }
    }
    let name = format!("{a}{b}");
    Ok(Trace {
        arc_rad: arc_rad(angles),
        speed,
        run: Run { points, ..run.clone() },
        name,
        plane: [a, b],
        radius_mm,
        calibrated: setup.calibrated,
        on_the_fly: true,
        read,
        samples,
        between: between.len(),
        beginnings,
    })
}

/// The arc that the angles cover where that is no whole circle, rad.
fn arc_rad(mut angles: Vec<f64>) -> Option<f64> {
    angles.sort_by(f64::total_cmp);
    let (first, last) = (*angles.first()?, *angles.last()?);
    let gaps = angles.windows(2).map(|two| two[1] - two[0]).chain([first + TAU - last]);
    let widest = gaps.fold(0.0, f64::max);
    (widest > WHOLE_RAD).then_some(TAU - widest)
}

/// Speed and acceleration of both axes by that along the path, as a circle of this radius has them. Where they come from the rows, an acceleration is
/// the second difference of rounded positions, which the deviation of the same row holds too: that is no inertia.
fn move_on_circle(state: &mut State, sample: &Sample, plane: [Joint; 2], sense: [f64; 2], radius_mm: f64) {
    let (sin, cos) = sample.angle_rad.sin_cos();
    let speed = sample.speed_mm_per_s;
    for (k, letter) in plane.into_iter().enumerate() {
        state.velocity[letter] = sense[k] * sample.way * speed * [-sin, cos][k];
        if state.acceleration[letter] != 0.0 {
            state.acceleration[letter] = -sense[k] * speed * speed / radius_mm * [cos, sin][k];
        }
    }
}

/// Speeds of readings whose rows follow the path in time: way over time to the neighbours of the same way. Rows of which one is earlier than
/// the one before, or that jump within a way, follow no path.
fn speed_by_times(points: &[&Point], samples: &mut [Sample]) -> Speed {
    let times: Vec<f64> = points.iter().filter_map(|point| point.state.time_s).collect();
    if times.len() < points.len() {
        return Speed::Unknown;
    }
    if times.windows(2).any(|pair| pair[1] < pair[0]) {
        return Speed::OutOfOrder;
    }
    if times.windows(2).any(|pair| pair[1] == pair[0]) {
        return Speed::TooCoarse;
    }
    let step_mm = |i: usize| {
        let [from, to] = [i, i + 1].map(|k| Vector2::from(samples[k].position_mm));
        (samples[i].way == samples[i + 1].way).then(|| (to - from).norm())
    };
    let steps_mm: Vec<Option<f64>> = (0..times.len() - 1).map(step_mm).collect();
    let usual_mm = usual(steps_mm.iter().flatten().copied());
    // A row out of order is away from both its neighbours; between two circles of one way there is one jump.
    let jumps = steps_mm.iter().flatten().filter(|step| **step > FARTHEST_STEPS * usual_mm).count();
    if jumps > 1 {
        return Speed::OutOfOrder;
    }
    let speed = |i: usize| Some(steps_mm.get(i).copied()?? / (times[i + 1] - times[i]));
    let usual = usual((0..steps_mm.len()).filter_map(speed));
    let speeds: Vec<f64> = (0..samples.len())
        .map(|i| {
            let near: Vec<f64> = [i.checked_sub(1).and_then(speed), speed(i)].into_iter().flatten().collect();
            if near.is_empty() { usual } else { near.iter().sum::<f64>() / near.len() as f64 }
        })
        .collect();
    for (sample, speed_mm_per_s) in samples.iter_mut().zip(speeds) {
        sample.speed_mm_per_s = speed_mm_per_s;
    }
    Speed::Times
}

fn usual(of: impl Iterator<Item = f64>) -> f64 {
    upper_median(&of.collect::<Vec<_>>()).unwrap_or(0.0)
}

/// Tool ball − table ball of the nominal machine, machine axes, mm.
fn bar_mm(machine: &Machine, setup: &Setup, point: &Point) -> Vector3<f64> {
    let (position, none) = (&point.state.position, JointErrors::default());
    machine.machine_from_tool(position, &none) * setup.ball_in_tool_mm
        - machine.machine_from_table(position, &none) * setup.ball_in_table_mm
}
