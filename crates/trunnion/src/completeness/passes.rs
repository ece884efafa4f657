//! How the samples of a cycle on the fly find their planned states: by setup, feed, direction and the angle on the way.
//!
//! The way is a sweep of one axis, whose angle is its own, or a curve of the tool about the table's ball. The angle on a curve is
//! known but for whole turns, so each of its turns is another round of the same places.

use std::collections::HashMap;
use std::f64::consts::TAU;
use trunnion_core::{AxisValues, Joint, Point, State};
use trunnion_cycles::cycle::Motion;
use trunnion_cycles::{Cycle, Pace};
use trunnion_machine::Machine;
use trunnion_sync::SweepRules;

/// Time h over which the speed ω along a curve is a difference, s. The tangent leaves the angle of a circle by (ω h)²/3 of the speed,
/// 3e-7 at 10 rad/s; the last digits of 1 m on a radius of 100 mm are 1e-9 of it at 0.01 rad/s.
const NEAR_S: f64 = 1e-4;
/// A sample on a curve belongs to a place within so many of their distances: half of its own, and one more place at the ends of a pass,
/// where the axis still speeds up. Farther out is the run-in.
const NEXT: f64 = 1.5;

/// Planned states of a run on the fly by setup and feed.
pub(super) struct Passes {
    way: Way,
    /// Part of a feed within which a pass belongs to it.
    feed_tolerance: f64,
    feeds: Vec<f64>,
    angles: HashMap<(usize, usize), Angles>,
    /// Where the last sample belonged: (setup, feed, angle).
    at: Option<(usize, usize, usize)>,
}

/// What a cycle travels along.
enum Way {
    /// The angle of an axis.
    Axis(Joint),
    /// The angle on a curve.
    Curve(Box<(Cycle, Machine)>),
}

/// Planned angles of one setup at one feed, in order.
type Angles = Vec<Place>;

/// A planned angle: the states of each round, and how often the machine came by.
struct Place {
    angle: f64,
    rounds: Vec<Vec<usize>>,
    visits: usize,
}

impl Place {
    /// One more state here; neighbours on the way are of one round.
    fn plan(&mut self, state: usize) {
        match self.rounds.last_mut() {
            Some(round) if round.last().is_some_and(|last| last + 1 == state) => round.push(state),
            _ => self.rounds.push(vec![state]),
        }
    }
}

impl Way {
    fn of(cycle: &Cycle, machine: &Machine) -> Option<Self> {
        match &cycle.motion {
            Motion::OnTheFly { axis, .. } => Some(Self::Axis(*axis)),
            Motion::Path { .. } => Some(Self::Curve(Box::new((cycle.clone(), machine.clone())))),
            Motion::Static { .. } | Motion::Line { .. } => None,
        }
    }

    /// Angle on the way, rad, and its speed, rad/s.
    fn at(&self, state: &State) -> (f64, f64) {
        match self {
            Self::Axis(axis) => (state.position[*axis], state.velocity[*axis]),
            Self::Curve(curve) => {
                let (cycle, machine) = curve.as_ref();
                let angle = |position: &AxisValues<f64>| {
                    let place = machine.tool_in_table(position).0;
                    cycle.curve_angle_rad(machine, &place).unwrap_or(f64::NAN)
                };
                let soon = AxisValues::from_fn(|slot| state.position[slot] + NEAR_S * state.velocity[slot]);
                let here = angle(&state.position);
                let gone = angle(&soon) - here;
                (here.rem_euclid(TAU), (gone - (gone / TAU).round() * TAU) / NEAR_S)
            }
        }
    }

    /// The planned angle that a state stands for: on a curve its turns meet at places as far apart as the states.
    fn place(&self, angle: f64, feed: f64) -> f64 {
        match self {
            Self::Axis(_) => angle,
            Self::Curve(_) => {
                let width = Self::width(feed);
                ((angle / width).floor() + 0.5) * width
            }
        }
    }

    /// Distance of the places of a curve, rad: that of its states, so that a turn is whole.
    fn width(feed: f64) -> f64 {
        TAU / (TAU * Pace::default().points_per_s / feed.abs()).round().max(1.0)
    }

    /// How far a place is from an angle, rad; `None` beyond the ends of a curve.
    fn distance(&self, place: f64, angle: f64, feed: f64) -> Option<f64> {
        match self {
            Self::Axis(_) => Some((place - angle).abs()),
            Self::Curve(_) => {
                let apart = (place - angle).rem_euclid(TAU);
                Some(apart.min(TAU - apart)).filter(|apart| *apart <= NEXT * Self::width(feed))
            }
        }
    }
}

impl Passes {
    /// `None` for a cycle at rest.
    pub fn of(cycle: &Cycle, machine: &Machine, states: &[State]) -> Option<Self> {
        let way = Way::of(cycle, machine)?;
        let feed_tolerance = SweepRules::of(cycle)?.feed_tolerance;
        let mut feeds: Vec<f64> = Vec::new();
        let mut angles: HashMap<(usize, usize), Angles> = HashMap::new();
        for (k, state) in states.iter().enumerate() {
            let (angle, feed) = way.at(state);
            // Of nearer feeds a sample would belong to either.
            let is_same = |known: &f64| (known - feed).abs() <= feed_tolerance * feed.abs();
            let index = feeds.iter().position(is_same).unwrap_or_else(|| {
                feeds.push(feed);
                feeds.len() - 1
            });
            let angle = way.place(angle, feeds[index]);
            let list = angles.entry((state.setup, index)).or_default();
            match list.iter_mut().find(|place| (place.angle - angle).abs() < 1e-9) {
                Some(place) => place.plan(k),
                None => list.push(Place { angle, rounds: vec![vec![k]], visits: 0 }),
            }
        }
        angles.values_mut().for_each(|list| list.sort_by(|a, b| a.angle.total_cmp(&b.angle)));
        Some(Self { way, feed_tolerance, feeds, angles, at: None })
    }

    /// The planned states of a sample: the nearest, and its neighbours, because at the ends of a pass the axis still speeds up. A
    /// round ends when its angle is left.
    pub fn find(&mut self, point: &Point) -> Vec<usize> {
        let (angle, velocity) = self.way.at(&point.state);
        let is_at = |feed: &f64| (velocity - feed).abs() <= self.feed_tolerance * feed.abs();
        let Some(feed) = self.feeds.iter().position(is_at) else { return Vec::new() };
        let Some(list) = self.angles.get_mut(&(point.state.setup, feed)) else { return Vec::new() };
        let above = list.partition_point(|place| place.angle < angle);
        // The places of a curve close to a turn.
        let around = [above.checked_sub(1).unwrap_or(list.len() - 1), above % list.len()];
        let distance = |k: usize| self.way.distance(list[k].angle, angle, self.feeds[feed]);
        let near = around.into_iter().filter_map(|k| Some((k, distance(k)?)));
        let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((nearest, _)) = nearest else { return Vec::new() };
        let here = (point.state.setup, feed, nearest);
        if self.at.replace(here) == Some(here) {
            return Vec::new();
        }
        let round = list[nearest].visits;
        list[nearest].visits += 1;
        let Some(own) = list[nearest].rounds.get(round) else { return Vec::new() };
        // The places of a closed curve go on with the first behind the last.
        let goes_on = |k: usize| matches!(self.way, Way::Curve(_)).then_some(k);
        let before = nearest.checked_sub(1).or(goes_on(list.len() - 1));
        let behind = Some(nearest + 1).filter(|k| *k < list.len()).or(goes_on(0));
        let is_near =
            |place: &&Place| self.way.distance(place.angle, list[nearest].angle, self.feeds[feed]).is_some();
        let next_to = [before, behind].into_iter().flatten().map(|k| &list[k]).filter(is_near);
        let neighbours =
            next_to.flat_map(|place| place.rounds.iter().filter(|round| meet(own, round)).flatten());
        own.iter().chain(neighbours).copied().collect()
    }
}

/// True for states that follow each other on the way.
fn meet(one: &[usize], other: &[usize]) -> bool {
    let follows = |early: &[usize], late: &[usize]| {
        early.last().zip(late.first()).is_some_and(|(last, first)| last + 1 == *first)
    };
    follows(one, other) || follows(other, one)
}
