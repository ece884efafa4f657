//! What an effect may know of an experiment besides the state: machine, setups, channels, ranges.

use trunnion_machine::{Machine, State};
use trunnion_units::AxisValues;

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
    /// True when any axis moved while it was read.
    pub on_the_fly: bool,
}

/// What an effect may know of a setup.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSetup {
    /// Name, e.g. `low`.
    pub name: String,
    /// Names of the components of a reading: x y z, or r.
    pub components: &'static [&'static str],
}

impl Scene {
    /// A scene with the ranges of `states`.
    pub fn new<'a>(
        machine: Machine,
        setups: Vec<SceneSetup>,
        channels: Vec<String>,
        states: impl Iterator<Item = &'a State> + Clone,
    ) -> Self {
        let position_range = AxisValues::from_fn(|letter| {
            range(states.clone().map(|s| s.position[letter])).unwrap_or((0.0, 0.0))
        });
        let timed = states.clone().all(|s| s.time_s.is_some());
        let time_range_s = if timed { range(states.clone().filter_map(|s| s.time_s)) } else { None };
        let on_the_fly = states.clone().any(|s| s.velocity.0.iter().any(|v| *v != 0.0));
        Self { machine, setups, channels, time_range_s, position_range, on_the_fly }
    }

    /// Time between the first and the last point, s; `None` without time.
    pub fn duration_s(&self) -> Option<f64> {
        self.time_range_s.map(|(first, last)| last - first)
    }
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, x| {
        Some(range.map_or((x, x), |(low, high): (f64, f64)| (low.min(x), high.max(x))))
    })
}
