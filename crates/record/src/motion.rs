//! Motion that a table does not state: directions and travel since the last reversal, speeds and accelerations.
//!
//! v(t₁) = slope, a(t₁) = curvature at the row of the parabola through its two neighbours and itself; at both ends of a stretch through the two next
//! rows of it, so that they are as good as inside. Without time the way along the path takes its place, as long as the feed says.
//! At rest an axis came from where it stood before ([`Travel`]); on the fly it goes where v points ([`turning`]).

mod moving;
mod turning;

use moving::Moving;
use std::collections::VecDeque;
use trunnion_core::direction::Travel;
use trunnion_core::{AxisSample, AxisValues, Joint, Point, Slot, State};
use turning::Turning;

/// Points further apart than this are not on one path, s: as when samples become blocks.
const PAUSE_S: f64 = 0.25;

/// One row as a point, with its feed (mm/s) and what the encoders read.
pub struct Taken {
    pub point: Point,
    pub feed_mm_per_s: Option<f64>,
    pub actual: Option<AxisSample>,
}

/// What is to be filled.
pub struct Wanted {
    /// Axes whose direction no column states.
    pub directions: Vec<Joint>,
    pub since_reversal: bool,
    pub speeds: bool,
    pub accelerations: bool,
    /// The rows were read while the axes moved.
    pub on_the_fly: bool,
}

/// Passes points on, two rows late, with their motion.
pub struct Motion {
    wanted: Wanted,
    travel: Travel,
    turning: Turning,
    /// The last two rows that were passed on, the later one first.
    before: VecDeque<Place>,
    waiting: VecDeque<Taken>,
}

/// Where a row stands.
#[derive(Clone, Copy)]
struct Place {
    setup: usize,
    time_s: Option<f64>,
    feed_mm_per_s: Option<f64>,
    position: AxisValues<f64>,
}

impl Motion {
    pub fn new(wanted: Wanted) -> Self {
        let (before, waiting) = (VecDeque::new(), VecDeque::new());
        Self { wanted, travel: Travel::default(), turning: Turning::default(), before, waiting }
    }

    /// Takes a row; gives the one two rows before it.
    pub fn push(&mut self, mut next: Taken) -> Option<Taken> {
        let stated = next.point.state.since_reversal;
        if !self.wanted.on_the_fly {
            self.travel.fill(&mut next.point.state, &self.wanted.directions);
            if !self.wanted.since_reversal {
                next.point.state.since_reversal = stated;
            }
        }
        self.waiting.push_back(next);
        (self.waiting.len() > 2).then(|| self.next()).flatten()
    }

    /// The first row that waits: of the last two there is no other.
    pub fn next(&mut self) -> Option<Taken> {
        let mut taken = self.waiting.pop_front()?;
        let here = Place::of(&taken);
        let after = here.on_path(self.waiting.iter().map(Place::of));
        let before = here.on_path(self.before.iter().copied());
        self.before.push_front(here);
        self.before.truncate(2);
        if self.wanted.on_the_fly {
            self.fill(&mut taken.point.state, &here, &here.moving(&before, &after));
        }
        Some(taken)
    }

    fn fill(&mut self, state: &mut State, here: &Place, moving: &AxisValues<Moving>) {
        let (heading, since_reversal) = self.turning.follow(&state.position, moving);
        for joint in &self.wanted.directions {
            state.direction[joint.slot()] = heading[joint.slot()];
        }
        if self.wanted.since_reversal {
            state.since_reversal = since_reversal;
        }
        if self.wanted.speeds {
            state.velocity = here.speeds(moving);
        }
        if self.wanted.accelerations && here.time_s.is_some() {
            state.acceleration = AxisValues::from_fn(|slot| moving[slot].acceleration);
        }
    }
}

impl Place {
    fn of(taken: &Taken) -> Self {
        let state = &taken.point.state;
        let (setup, time_s, position) = (state.setup, state.time_s, state.position);
        Self { setup, time_s, feed_mm_per_s: taken.feed_mm_per_s, position }
    }

    /// Two rows at most, nearest first, as long as they are on one path with this one; each with its time from here, s.
    fn on_path(&self, others: impl Iterator<Item = Self>) -> Vec<(f64, Self)> {
        let (mut from, mut apart_s, mut found) = (*self, 0.0, Vec::new());
        for other in others.take(2) {
            let step_s = self.seconds(&from, &other);
            let pauses = self.time_s.is_some() && step_s > PAUSE_S;
            if other.setup != self.setup || pauses || step_s <= 0.0 {
                break;
            }
            apart_s += step_s;
            found.push((apart_s, other));
            from = other;
        }
        found
    }

    /// From one row to the next by the clock, else by the feed of this row; without both the rows are counted, which gives directions.
    fn seconds(&self, from: &Self, to: &Self) -> f64 {
        match (from.time_s.zip(to.time_s), self.feed_mm_per_s) {
            (Some((from_s, to_s)), _) => (to_s - from_s).abs(),
            (None, Some(feed)) => linear(|slot| to.position[slot] - from.position[slot]) / feed,
            (None, None) => 1.0,
        }
    }

    fn moving(&self, before: &[(f64, Self)], after: &[(f64, Self)]) -> AxisValues<Moving> {
        let before: Vec<(f64, Self)> = before.iter().map(|(apart_s, row)| (-apart_s, *row)).collect();
        let neighbours = match (&before[..], after) {
            ([back, ..], [ahead, ..]) => [Some(*back), Some(*ahead)],
            (one_side, []) | ([], one_side) => [one_side.first().copied(), one_side.get(1).copied()],
        };
        AxisValues::from_fn(|slot| {
            let q = self.position[slot];
            let slope = |(apart_s, row): &(f64, Self)| (*apart_s, (row.position[slot] - q) / apart_s);
            let (speed, acceleration) = match neighbours.map(|row| row.as_ref().map(slope)) {
                [Some((one_s, of_one)), Some((two_s, of_two))] => {
                    let half = (of_two - of_one) / (two_s - one_s);
                    (of_one - half * one_s, 2.0 * half)
                }
                [Some((_, slope)), None] => (slope, 0.0),
                _ => (0.0, 0.0),
            };
            let back = before.first().map(|(apart_s, row)| (*apart_s, q - row.position[slot]));
            let ahead = after.first().map(|(_, row)| row.position[slot] - q);
            Moving { back, ahead, speed, acceleration }
        })
    }

    /// The speeds of a table: by the clock, else those along the path of its feed; without both none.
    fn speeds(&self, moving: &AxisValues<Moving>) -> AxisValues<f64> {
        let along = linear(|slot| moving[slot].speed);
        let share = match (self.time_s, self.feed_mm_per_s) {
            (Some(_), _) => 1.0,
            // The chord between rows is a little shorter than the path.
            (None, Some(feed)) if along > 0.0 => feed / along,
            _ => 0.0,
        };
        AxisValues::from_fn(|slot| share * moving[slot].speed)
    }
}

/// √(ΣΔ²) over the linear axes.
fn linear(of: impl Fn(Slot) -> f64) -> f64 {
    Slot::ALL.into_iter().filter(|slot| !slot.is_rotary()).map(|slot| of(slot).powi(2)).sum::<f64>().sqrt()
}
