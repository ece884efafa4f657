//! What an effect may know of an experiment besides the state: machine, setups, channels, ranges, histories.

use crate::Unit;
use crate::history::{History, histories};
use crate::path::{Path, path};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::collections::HashMap;
use trunnion_core::axis::SLOTS;
use trunnion_core::{AxisLetter, AxisValues, Slot, State, Twist};
use trunnion_machine::{Machine, Side, Site};

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

/// What an effect may know of a setup.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSetup {
    /// Name, e.g. `low`.
    pub name: String,
    /// Names of the components of a reading: x y z, or r.
    pub components: &'static [&'static str],
    /// Which side carries the nest; the ball is on the other.
    pub nest: Side,
    /// Nominal centre of the table-side ball or nest in table axes, mm.
    pub ball_in_table_mm: Point3<f64>,
    /// Number of the run it belongs to: each run has its own clock.
    pub run: usize,
    /// Unknowns of the mounting.
    pub settings: Vec<SceneSetting>,
    /// What is measured at several places.
    pub artefact: Option<SceneArtefact>,
}

/// An unknown that comes with a mounting: place, zero, inner geometry of the instrument.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSetting {
    /// Name, unique in the setup.
    pub name: &'static str,
    /// Unit on screens.
    pub unit: Unit,
    /// Where it acts.
    pub site: Site,
    /// What one unit (1 mm, 1 rad) of it does there.
    pub twist: Twist,
}

/// What an effect may know of an artefact.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneArtefact {
    /// Name; setups with the same one measure the same thing.
    pub name: String,
    /// Names of its targets; `State::target` indexes them.
    pub targets: Vec<String>,
    /// Table axes from artefact axes.
    pub table_from_artefact: UnitQuaternion<f64>,
}

impl SceneSetup {
    /// An R-test with the nest on the table and its place as unknowns, in run 0.
    pub fn r_test(name: &str, ball_in_table_mm: Point3<f64>) -> Self {
        Self {
            name: name.into(),
            components: &["x", "y", "z"],
            nest: Side::Table,
            ball_in_table_mm,
            run: 0,
            settings: place(),
            artefact: None,
        }
    }

    /// The same on a plate of two targets, for examples.
    #[must_use]
    pub fn with_plate(self) -> Self {
        let artefact = SceneArtefact {
            name: "plate".into(),
            targets: vec!["1".into(), "2".into()],
            table_from_artefact: UnitQuaternion::identity(),
        };
        Self { artefact: Some(artefact), ..self }
    }

    /// A ball bar, likewise.
    pub fn ball_bar(name: &str, ball_in_table_mm: Point3<f64>) -> Self {
        let length = SceneSetting {
            name: "length",
            unit: Unit::UM,
            site: Site::Reading,
            twist: Twist::translation(-Vector3::x()),
        };
        let settings = place().into_iter().chain([length]).collect();
        Self { components: &["r"], settings, ..Self::r_test(name, ball_in_table_mm) }
    }
}

/// Place of the table-side ball, table axes.
fn place() -> Vec<SceneSetting> {
    let along = |(k, name)| SceneSetting {
        name,
        unit: Unit::UM,
        site: Site::TableBall,
        twist: Twist::translation(Vector3::ith(k, 1.0)),
    };
    ["x", "y", "z"].into_iter().enumerate().map(along).collect()
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

    /// True when time goes by between the points.
    pub fn has_time(&self) -> bool {
        self.duration_s().is_some_and(|duration_s| duration_s > 0.0)
    }

    /// True when the axis stands at more than one position.
    pub fn moves(&self, letter: AxisLetter) -> bool {
        differs(self.position_range[letter])
    }

    /// Cycles in a turn of a rotary axis, or in 2π mm of a linear one, beyond which its positions show fewer cycles instead
    /// (Nyquist): on a grid of step Δ, N cannot be told from 2π/Δ − N.
    pub fn most_cycles(&self, letter: AxisLetter) -> f64 {
        std::f64::consts::PI / self.position_step[letter]
    }

    /// True when a linear axis was measured all along its travel, not only where it follows the rotary axes.
    pub fn measures_volume(&self, letter: AxisLetter) -> bool {
        self.moves(letter) && self.places_at_one_pose[letter] >= PLACES_OF_A_VOLUME
    }

    /// True when the axis came from, or moved in, both directions.
    pub fn both_directions(&self, letter: AxisLetter) -> bool {
        self.direction_range[letter].0 < 0.0 && self.direction_range[letter].1 > 0.0
    }

    /// True when the axis moved while it was read.
    pub fn read_in_motion(&self, letter: AxisLetter) -> bool {
        self.speed_range[letter].1 > 0.0
    }

    /// True when the acceleration of the axis differs between readings.
    pub fn accelerates(&self, letter: AxisLetter) -> bool {
        differs(self.acceleration_range[letter])
    }

    /// True when the speed of the axis differs between readings.
    pub fn changes_speed(&self, letter: AxisLetter) -> bool {
        differs(self.speed_range[letter])
    }

    /// True when the axis is read both at rest and in motion.
    pub fn rests_and_moves(&self, letter: AxisLetter) -> bool {
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
fn places_at_one_pose<'a>(states: impl Iterator<Item = &'a State>) -> AxisValues<usize> {
    let rounded = |value: f64| (value / SAME_POSITION).round() as i64;
    let mut at_pose: HashMap<[i64; SLOTS], AxisValues<Vec<i64>>> = HashMap::new();
    for state in states {
        let pose = AxisValues::from_fn(|l| if l.is_rotary() { rounded(state.position[l]) } else { 0 });
        let places = at_pose.entry(pose.0).or_default();
        for letter in Slot::ALL.into_iter().filter(|slot| !slot.is_rotary()) {
            let (seen, here) = (&mut places[letter], rounded(state.position[letter]));
            if seen.len() < MOST_PLACES && !seen.contains(&here) {
                seen.push(here);
            }
        }
    }
    AxisValues::from_fn(|letter| at_pose.values().map(|places| places[letter].len()).max().unwrap_or(0))
}

/// Smallest step between two positions of an axis at rest; see [`Scene::position_step`].
fn step<'a>(states: impl Iterator<Item = &'a State> + Clone, letter: Slot) -> f64 {
    if states.clone().any(|s| s.velocity[letter] != 0.0) {
        return 0.0;
    }
    let mut positions: Vec<f64> = states.map(|s| s.position[letter]).collect();
    positions.sort_by(f64::total_cmp);
    let steps = positions.windows(2).map(|pair| pair[1] - pair[0]);
    steps.filter(|step| *step > SAME_POSITION).fold(f64::INFINITY, f64::min)
}

/// Positions closer than this were meant to be the same, mm and rad.
const SAME_POSITION: f64 = 1e-3;

/// Median of the first steps forward in time.
fn usual_step(times_s: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let steps = times_s.clone().zip(times_s.skip(1)).map(|(before, after)| after - before);
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).take(STEPS_LOOKED_AT).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

const STEPS_LOOKED_AT: usize = 4096;

fn differs((low, high): (f64, f64)) -> bool {
    high - low > 1e-9
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, x| {
        Some(range.map_or((x, x), |(low, high): (f64, f64)| (low.min(x), high.max(x))))
    })
}
