//! What an effect may know of an experiment in addition to the state: machine, setups, channels, ranges, histories.

use crate::SceneSetup;
use crate::history::{History, histories};
use crate::path::{Path, path};
use nalgebra::Vector3;
use std::collections::HashMap;
use trunnion_core::axis::SLOTS;
use trunnion_core::{AxisValues, Joint, Slot, State};
use trunnion_machine::Machine;

/// The experiment an effect is placed in. Built from all points of all runs that are fitted together.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The machine.
    pub machine: Machine,
    /// Setups; `State::setup` indexes them.
    pub setups: Vec<SceneSetup>,
    /// Names of the temperature channels; `State::temperature_degc` follows them.
    pub channels: Vec<String>,
    /// First and last time of the points, s; `None` when the points have no time.
    pub time_range_s: Option<(f64, f64)>,
    /// Times of the points in order, s, at most `TIMES_KEPT` of them, evenly chosen; empty where `time_range_s` is `None`.
    pub times_s: Vec<f64>,
    /// Smallest and largest commanded position of each axis, mm and rad.
    pub position_range: AxisValues<(f64, f64)>,
    /// Smallest step between two positions of each axis, mm and rad; infinite where it stands at one, zero where it was read in motion.
    pub position_step: AxisValues<f64>,
    /// Most different places of each axis while the rotary axes stand at one pose; at most six are counted.
    pub places_at_one_pose: AxisValues<usize>,
    /// Usual time from one point to the next, s; `None` without time or with one point.
    pub time_step_s: Option<f64>,
    /// True when any axis moved while it was read.
    pub on_the_fly: bool,
    /// How the axes move together while they are read.
    pub path: Path,
    /// Smallest and largest direction of travel of each axis: (−1, 1) when it came from both sides.
    pub direction_range: AxisValues<(f64, f64)>,
    /// Smallest and largest speed of each axis while it was read, mm/s and rad/s, never negative.
    pub speed_range: AxisValues<(f64, f64)>,
    /// Smallest and largest acceleration of each axis, mm/s² and rad/s².
    pub acceleration_range: AxisValues<(f64, f64)>,
    /// Largest deflection the probes were asked to read, by component, nest axes, mm.
    pub deflection_mm: Vector3<f64>,
    /// First value of each temperature channel, °C.
    pub first_temperature_degc: Vec<f64>,
    /// Smallest and largest value of each temperature channel, °C.
    pub temperature_range_degc: Vec<(f64, f64)>,
    /// Course of the temperature channels: `histories[run][channel]`; empty without time,
    /// `None` for a channel that a run has not.
    pub histories: Vec<Vec<Option<History>>>,
}

impl Scene {
    /// A scene with the ranges of `states`.
    pub fn new<'a>(
        machine: Machine,
        setups: Vec<SceneSetup>,
        channels: Vec<String>,
        states: impl Iterator<Item = &'a State> + Clone,
    ) -> Self {
        let axis_range = |value: fn(&State, Slot) -> f64| {
            AxisValues::from_fn(|letter| {
                range(states.clone().map(|s| value(s, letter))).unwrap_or((0.0, 0.0))
            })
        };
        let timed = states.clone().all(|s| s.time_s.is_some());
        let deflection_mm = states.clone().fold(Vector3::zeros(), |d, s| d.sup(&s.deflection_mm.abs()));
        let channel = |i: usize| states.clone().filter_map(move |s| s.temperature_degc.get(i).copied());
        let run_of_setup: Vec<usize> = setups.iter().map(|setup| setup.run).collect();
        Self {
            time_range_s: if timed { range(states.clone().filter_map(|s| s.time_s)) } else { None },
            times_s: if timed { times(states.clone().filter_map(|s| s.time_s)) } else { Vec::new() },
            time_step_s: if timed { usual_step(states.clone().filter_map(|s| s.time_s)) } else { None },
            path: path(&machine, &setups, states.clone()),
            histories: if timed {
                histories(states.clone(), &run_of_setup, channels.len())
            } else {
                Vec::new()
            },
            position_range: axis_range(|s, l| s.position[l]),
            places_at_one_pose: places_at_one_pose(states.clone()),
            position_step: AxisValues::from_fn(|letter| step(states.clone(), letter)),
            on_the_fly: states.clone().any(|s| s.velocity.0.iter().any(|v| *v != 0.0)),
            direction_range: axis_range(|s, l| s.direction[l]),
            speed_range: axis_range(|s, l| s.velocity[l].abs()),
            acceleration_range: axis_range(|s, l| s.acceleration[l]),
            deflection_mm,
            first_temperature_degc: (0..channels.len())
                .map(|i| channel(i).next().unwrap_or_default())
                .collect(),
            temperature_range_degc: (0..channels.len())
                .map(|i| range(channel(i)).unwrap_or_default())
                .collect(),
            machine,
            setups,
            channels,
        }
    }

    /// Time between the first and the last point, s; `None` without time.
    pub fn duration_s(&self) -> Option<f64> {
        self.time_range_s.map(|(first, last)| last - first)
    }

    /// Time since the first point, s; `None` without time.
    pub fn elapsed_s(&self, state: &State) -> Option<f64> {
        Some(state.time_s? - self.time_range_s?.0)
    }

    /// Time since the first point after which this share of the points was read, s, between two of them; `None` without time. Where a run has
    /// pauses, what happens once happens among the points or is not seen.
    pub fn moment_s(&self, share: f64) -> Option<f64> {
        let after = ((share * self.times_s.len() as f64).round() as usize).max(1);
        let between =
            0.5 * (self.times_s.get(after - 1)? + self.times_s.get(after).or(self.times_s.last())?);
        Some(between - self.time_range_s?.0)
    }

    /// True when time goes by between the points.
    pub fn has_time(&self) -> bool {
        self.duration_s().is_some_and(|duration_s| duration_s > 0.0)
    }

    /// True when the axis was asked to stand at more than one position.
    pub fn moves(&self, letter: Joint) -> bool {
        let (low, high) = self.position_range[letter];
        high - low > same_position(letter.slot())
    }

    /// Cycles in a turn of a rotary axis, or in 2π mm of a linear one, beyond which its positions show fewer cycles instead
    /// (Nyquist): on a grid of step Δ, N cannot be distinguished from 2π/Δ − N.
    pub fn most_cycles(&self, letter: Joint) -> f64 {
        std::f64::consts::PI / self.position_step[letter]
    }

    /// True when a linear axis was measured all along its travel, not only where it follows the rotary axes.
    pub fn measures_volume(&self, letter: Joint) -> bool {
        self.moves(letter) && self.places_at_one_pose[letter] >= PLACES_OF_A_VOLUME
    }

    /// True when the axis came from, or moved in, both directions.
    pub fn both_directions(&self, letter: Joint) -> bool {
        self.direction_range[letter].0 < 0.0 && self.direction_range[letter].1 > 0.0
    }

    /// True when the axis moved while it was read.
    pub fn read_in_motion(&self, letter: Joint) -> bool {
        self.speed_range[letter].1 > 0.0
    }

    /// True when the acceleration of the axis differs between readings.
    pub fn accelerates(&self, letter: Joint) -> bool {
        differs(self.acceleration_range[letter])
    }

    /// True when the speed of the axis differs between readings.
    pub fn changes_speed(&self, letter: Joint) -> bool {
        differs(self.speed_range[letter])
    }

    /// True when the axis is read at two feeds, or at rest and at one.
    pub fn two_feeds(&self, letter: Joint) -> bool {
        let (slowest, fastest) = self.speed_range[letter];
        fastest > TWO_FEEDS * slowest
    }

    /// True when the axis is read both at rest and in motion.
    pub fn rests_and_moves(&self, letter: Joint) -> bool {
        let (slowest, fastest) = self.speed_range[letter];
        slowest <= 0.0 && fastest > 0.0
    }

    /// Temperature of a channel as a structure feels it that follows with time constant `tau_s`, °C.
    pub fn lagged_temperature_degc(&self, channel: usize, tau_s: f64, state: &State) -> Option<f64> {
        let own_degc = state.temperature_degc.get(channel).copied();
        let Some(time_s) = state.time_s.filter(|_| tau_s > 0.0) else { return own_degc };
        let run = self.setups.get(state.setup).map_or(0, |setup| setup.run);
        let history = self.histories.get(run).and_then(|channels| channels.get(channel)?.as_ref());
        history.map(|history| history.lagged(time_s, tau_s)).or(own_degc)
    }

    /// Channels whose temperature changed, by index.
    pub fn varying_channels(&self) -> Vec<usize> {
        (0..self.channels.len()).filter(|&i| differs(self.temperature_range_degc[i])).collect()
    }
}

/// Places of an axis at one pose of the rotary axes that make it measured by itself.
pub const PLACES_OF_A_VOLUME: usize = 5;

/// Places beyond this many are not counted.
pub const MOST_PLACES: usize = 6;

/// See [`Scene::places_at_one_pose`].
fn places_at_one_pose<'a>(states: impl Iterator<Item = &'a State> + Clone) -> AxisValues<usize> {
    let places = AxisValues::from_fn(|slot| first_of_places(states.clone(), slot));
    let place =
        |state: &State, slot: Slot| places[slot].partition_point(|first| *first <= state.position[slot]);
    let mut at_pose: HashMap<[usize; SLOTS], AxisValues<Vec<usize>>> = HashMap::new();
    for state in states {
        let pose = AxisValues::from_fn(|slot| if slot.is_rotary() { place(state, slot) } else { 0 });
        let seen_there = at_pose.entry(pose.0).or_default();
        for slot in Slot::ALL.into_iter().filter(|slot| !slot.is_rotary()) {
            let (seen, here) = (&mut seen_there[slot], place(state, slot));
            if seen.len() < MOST_PLACES && !seen.contains(&here) {
                seen.push(here);
            }
        }
    }
    AxisValues::from_fn(|slot| at_pose.values().map(|places| places[slot].len()).max().unwrap_or(0))
}

/// Smallest position of each place of an axis. A place begins where the axis stood, not at a multiple of some length: scatter about
/// such a multiple would make two places of one.
fn first_of_places<'a>(states: impl Iterator<Item = &'a State>, slot: Slot) -> Vec<f64> {
    let mut positions: Vec<f64> = states.map(|state| state.position[slot]).collect();
    positions.sort_by(f64::total_cmp);
    let mut firsts: Vec<f64> = Vec::new();
    for position in positions {
        if firsts.last().is_none_or(|first| position - first > same_position(slot)) {
            firsts.push(position);
        }
    }
    firsts
}

/// Smallest step between two positions of an axis at rest; see [`Scene::position_step`].
fn step<'a>(states: impl Iterator<Item = &'a State> + Clone, letter: Slot) -> f64 {
    if states.clone().any(|s| s.velocity[letter] != 0.0) {
        return 0.0;
    }
    let mut positions: Vec<f64> = states.map(|s| s.position[letter]).collect();
    positions.sort_by(f64::total_cmp);
    let steps = positions.windows(2).map(|pair| pair[1] - pair[0]);
    steps.filter(|step| *step > same_position(letter)).fold(f64::INFINITY, f64::min)
}

/// Positions closer than this were meant to be the same, mm and rad: recorded ones scatter by up to 5 µm, 10⁴ of them over eight
/// standard deviations; 1 mrad is 0.06°.
pub fn same_position(slot: Slot) -> f64 {
    if slot.is_rotary() { 1e-3 } else { 50e-3 }
}

/// See [`Scene::moment_s`].
fn times(times_s: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut times_s: Vec<f64> = times_s.collect();
    times_s.sort_by(f64::total_cmp);
    let every = times_s.len().div_ceil(TIMES_KEPT).max(1);
    times_s.into_iter().step_by(every).collect()
}

/// More than ten for each moment that any effect tries.
const TIMES_KEPT: usize = 512;

/// Median of the first steps forward in time.
fn usual_step(times_s: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let steps = times_s.clone().zip(times_s.skip(1)).map(|(before, after)| after - before);
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).take(STEPS_LOOKED_AT).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

const STEPS_LOOKED_AT: usize = 4096;

/// Speeds that differ by this factor are two feeds: a sample belongs to a feed within 5 % and the noise of its speed, and the cycles shipped have
/// feeds of 4 : 3 and more.
const TWO_FEEDS: f64 = 1.3;

fn differs((low, high): (f64, f64)) -> bool {
    high - low > 1e-9
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, x| {
        Some(range.map_or((x, x), |(low, high): (f64, f64)| (low.min(x), high.max(x))))
    })
}
