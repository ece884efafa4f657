//! Points at rest, reduced to stations as they are read: a few thousand means of neighbours instead of millions of points.
//!
//! A station is what was read at about the same pose, from the same side, at about the same time, in one setup at one target. It
//! keeps the mean state and the mean of (reading − nominal reading at each point's own positions), with the nominal reading of the mean
//! state added back, so that averaging loses nothing of the kinematics.
//!
//! Width: as fine as [`Stations::new`]'s limit allows. Stations begin at ⅛ of a unit (1°, 8 mm) and 10 s; whenever there are twice as many
//! as allowed, in turn the time gets twice and the pose √2 times as wide, and neighbours are merged. What is faster than the time width
//! averages out. Memory follows the number of stations, not of points.
//! Limits: averaging over a width w damps a harmonic n by 1 − (n w)²/24; scatter within a station is not kept.

use crate::blocks::{FINEST, UNIT};
use nalgebra::Vector3;
use std::collections::HashMap;
use trunnion_core::axis::SLOTS;
use trunnion_core::{AxisValues, Point, Quality, Slot, State};

/// Time width of a station before any merging, s: as for blocks.
const FINEST_S: f64 = 10.0;
/// A unit of a linear axis, in units of blocks: 8 mm are what 1° moves a ball 460 mm off its axis, so that axes which follow a
/// ball cut no finer than the axis that they follow.
const LINEAR: f64 = 4.0;
/// Beyond this no merging helps.
const MOST_LEVELS: i32 = 80;

/// Reduces points one by one. `nominal_mm` is the reading of a machine without errors at a state, mm.
pub struct Stations<F> {
    most: usize,
    nominal_mm: F,
    level: i32,
    stations: HashMap<Key, Station>,
    points: u64,
    missing: u64,
}

/// What points were reduced to.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduced {
    /// The stations, in the order in which they were first taken.
    pub points: Vec<Point>,
    /// Points read, those left out included.
    pub read: u64,
    /// Points without a usable reading.
    pub missing: u64,
    /// Width of a station, units of 1° or 8 mm.
    pub width_units: f64,
    /// Time that one station may take, s.
    pub time_s: f64,
}

#[derive(Clone, PartialEq, Eq, Hash)]
struct Key {
    setup: usize,
    target: usize,
    heading: [i8; SLOTS],
    place: [i32; SLOTS],
    time: i64,
}

struct Station {
    first: u64,
    count: u32,
    state: State,
    departure_mm: [f64; 3],
}

impl<F: Fn(&State) -> [f64; 3]> Stations<F> {
    /// At most `most` stations.
    pub fn new(most: usize, nominal_mm: F) -> Self {
        Self { most: most.max(1), nominal_mm, level: 0, stations: HashMap::new(), points: 0, missing: 0 }
    }

    /// Takes one point; `index` is its place in the order of the run.
    pub fn push(&mut self, index: u64, point: Point) {
        self.points += 1;
        if point.quality != Quality::Good || point.reading_mm.iter().any(|mm| !mm.is_finite()) {
            self.missing += 1;
            return;
        }
        let nominal_mm = (self.nominal_mm)(&point.state);
        let departure_mm = std::array::from_fn(|k| point.reading_mm[k] - nominal_mm[k]);
        let count = point.samples.max(1);
        self.join(Station { first: index, count, state: point.state, departure_mm });
        if self.stations.len() >= 2 * self.most {
            self.coarsen(2 * self.most - 1);
        }
    }

    /// The stations.
    pub fn finish(mut self) -> Reduced {
        self.coarsen(self.most);
        let mut stations: Vec<Station> = self.stations.drain().map(|(_, station)| station).collect();
        stations.sort_by_key(|station| station.first);
        let point = |station: Station| {
            let nominal_mm = (self.nominal_mm)(&station.state);
            Point {
                reading_mm: std::array::from_fn(|k| station.departure_mm[k] + nominal_mm[k]),
                state: station.state,
                spread_mm: [0.0; 3],
                samples: station.count,
                quality: Quality::Good,
            }
        };
        Reduced {
            points: stations.into_iter().map(point).collect(),
            read: self.points,
            missing: self.missing,
            width_units: self.width_units(),
            time_s: self.time_s(),
        }
    }

    fn coarsen(&mut self, most: usize) {
        while self.stations.len() > most && self.level < MOST_LEVELS {
            self.level += 1;
            let mut finer: Vec<Station> = self.stations.drain().map(|(_, station)| station).collect();
            // The order of a hash map is chance; sums must not be.
            finer.sort_by_key(|station| station.first);
            finer.into_iter().for_each(|station| self.join(station));
        }
    }

    fn join(&mut self, station: Station) {
        let key = self.key(&station.state);
        match self.stations.entry(key) {
            std::collections::hash_map::Entry::Occupied(mut there) => there.get_mut().merge(&station),
            std::collections::hash_map::Entry::Vacant(free) => {
                free.insert(station);
            }
        }
    }

    fn width_units(&self) -> f64 {
        FINEST * std::f64::consts::SQRT_2.powi(self.level / 2)
    }

    fn time_s(&self) -> f64 {
        FINEST_S * 2_f64.powi((self.level + 1) / 2)
    }

    fn key(&self, state: &State) -> Key {
        let (width, time_s) = (self.width_units(), self.time_s());
        let unit = |slot: Slot| if slot.is_rotary() { UNIT[slot] } else { LINEAR * UNIT[slot] };
        Key {
            setup: state.setup,
            target: state.target,
            heading: Slot::ALL.map(|slot| {
                let direction = if slot.is_rotary() { state.direction[slot] } else { 0.0 };
                i8::from(direction > 0.0) - i8::from(direction < 0.0)
            }),
            place: Slot::ALL.map(|slot| (state.position[slot] / (width * unit(slot))).round() as i32),
            time: state.time_s.map_or(0, |t| (t / time_s).floor() as i64),
        }
    }
}

impl Station {
    fn merge(&mut self, next: &Self) {
        let count = self.count.saturating_add(next.count);
        let share = f64::from(next.count) / f64::from(count);
        let mean = |mine: &mut f64, theirs: f64| *mine += (theirs - *mine) * share;
        let all = |mine: &mut AxisValues<f64>, theirs: &AxisValues<f64>| {
            mine.0.iter_mut().zip(theirs.0).for_each(|(mine, theirs)| mean(mine, theirs));
        };
        let (here, there) = (&mut self.state, &next.state);
        all(&mut here.position, &there.position);
        all(&mut here.direction, &there.direction);
        all(&mut here.since_reversal, &there.since_reversal);
        if let (Some(mine), Some(theirs)) = (&mut here.time_s, there.time_s) {
            mean(mine, theirs);
        }
        here.temperature_degc.iter_mut().zip(&there.temperature_degc).for_each(|(mine, t)| mean(mine, *t));
        self.departure_mm.iter_mut().zip(next.departure_mm).for_each(|(mine, d)| mean(mine, d));
        self.state.deflection_mm = Vector3::zeros();
        (self.first, self.count) = (self.first.min(next.first), count);
    }
}

impl Reduced {
    /// One line for a person: how many points became how many stations, and how far apart their points are.
    pub fn summary(&self) -> String {
        let mut text = format!(
            "{} points at rest became {} means of neighbours, up to {:.3}° or {:.3} mm and {:.0} s apart",
            self.read,
            self.points.len(),
            self.width_units,
            8.0 * self.width_units,
            self.time_s
        );
        if self.missing > 0 {
            text += &format!(", {} without a reading", self.missing);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_core::Joint;

    /// Poses of a grid, again and again, with an error that turns with C and one that drifts.
    #[test]
    fn a_grid_keeps_its_poses_and_the_mean_of_what_was_read_there() {
        let nominal = |state: &State| [100.0 * state.position[Joint::C].cos(), 0.0, 0.0];
        let mut stations = Stations::new(100, nominal);
        let rounds = 1000;
        for k in 0..12 * rounds {
            let mut state = State { time_s: Some(f64::from(k)), ..State::default() };
            state.position[Joint::C] = f64::from(k % 12) * 30_f64.to_radians();
            let error = 1e-3 * state.position[Joint::C].sin() + 1e-6 * f64::from(k);
            let reading_mm = [nominal(&state)[0] + error, 0.0, 0.0];
            let point = Point { state, reading_mm, spread_mm: [0.0; 3], samples: 0, quality: Quality::Good };
            stations.push(u64::from(k as u32), point);
        }
        let reduced = stations.finish();
        assert!((12..=100).contains(&reduced.points.len()), "{}", reduced.points.len());
        assert_eq!(reduced.points.iter().map(|point| point.samples).sum::<u32>(), 12 * rounds as u32);
        for point in &reduced.points {
            let c = point.state.position[Joint::C];
            let degrees = c.to_degrees();
            assert!((degrees / 30.0 - (degrees / 30.0).round()).abs() < 1e-9, "{degrees}");
            let expected = 100.0 * c.cos() + 1e-3 * c.sin() + 1e-6 * point.state.time_s.unwrap();
            assert!((point.reading_mm[0] - expected).abs() < 1e-9);
        }
    }
}
