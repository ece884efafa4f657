//! A volume of axis positions and its grid.

use trunnion_core::{AxisValues, Joint, convert, number};
use trunnion_effects::Scene;
use trunnion_machine::Machine;

/// Most places of a grid.
pub const MOST_PLACES: usize = 10_000;
/// Beyond the measured range by no more than this counts as inside, mm and rad.
const INSIDE: f64 = 1e-6;

/// Ranges of the axes, and how many places of each.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Joints of the machine.
    pub joints: Vec<Joint>,
    /// Smallest and largest position, mm and rad; an axis at one place has both alike.
    pub range: AxisValues<(f64, f64)>,
    /// Places of each axis that moves.
    pub steps: AxisValues<usize>,
    /// Point of the tool looked at, tool axes, mm; zero is the tool point of the machine file.
    pub point_in_tool_mm: [f64; 3],
}

/// A volume that cannot be had.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VolumeError {
    /// A part of the text that is no range.
    #[error(
        "--volume: \"{part}\" is no range of an axis; write e.g. X=-200..200 (mm), B=-90..90 (degrees) or C=30, with commas between"
    )]
    NoRange {
        /// What was found.
        part: String,
    },
    /// An axis that the machine has not.
    #[error("--volume: the machine {machine} has no axis {letter}; allowed: {allowed}")]
    NoAxis {
        /// What was found.
        letter: String,
        /// Name of the machine.
        machine: String,
        /// Its axes.
        allowed: String,
    },
    /// An axis given twice.
    #[error("--volume: axis {0} is given twice; keep one")]
    Twice(Joint),
    /// Beyond what was measured.
    #[error(
        "--volume: {asked} reaches beyond what these runs measured ({measured}); the model says nothing there: ask for less, or measure more"
    )]
    Beyond {
        /// The axis and range asked for.
        asked: String,
        /// The measured range.
        measured: String,
    },
    /// Too many places.
    #[error(
        "--volume: {places} places are too many (allowed: up to {MOST_PLACES}); take fewer --steps or axes"
    )]
    TooMany {
        /// Number of places asked for.
        places: f64,
    },
    /// Nothing to look at.
    #[error("--volume: no axis of the volume moves; give at least one a range, e.g. X=-200..200")]
    Empty,
    /// Nothing to see.
    #[error(
        "--volume: by this model nothing moves tool against table over {0}: its effects are those of axes that are at rest there. Give these axes a range, e.g. B=-90..90, or add effects of the axes that move"
    )]
    Nothing(String),
}

impl Volume {
    /// The measured range of every linear axis, rotary axes at zero; `text` replaces some of it: `X=-200..200,B=-90..90,C=30`.
    ///
    /// # Errors
    /// A text that is no list of ranges, axes the machine has not, ranges beyond the measured ones, too many places.
    pub fn parse(text: &str, steps: usize, scene: &Scene) -> Result<Self, VolumeError> {
        let machine = &scene.machine;
        let measured = |letter: Joint| scene.position_range[letter];
        let mut range = AxisValues::of(machine.linear_joints(), measured);
        let mut given = Vec::new();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let (letter, inside) = read(part, machine)?;
            if given.contains(&letter) {
                return Err(VolumeError::Twice(letter));
            }
            given.push(letter);
            let (low, high) = measured(letter);
            if high > low && (inside.0 < low - INSIDE || inside.1 > high + INSIDE) {
                return Err(VolumeError::Beyond { asked: part.into(), measured: spelt(letter, (low, high)) });
            }
            range[letter] = inside;
        }
        let steps = AxisValues::from_fn(|_| steps);
        Self { joints: machine.joints(), range, steps, point_in_tool_mm: [0.0; 3] }.checked()
    }

    /// The measured range of every rotary axis, linear axes at zero.
    ///
    /// # Errors
    /// No rotary axis moved, or too many places.
    pub fn of_rotary_axes(steps: usize, scene: &Scene) -> Result<Self, VolumeError> {
        let joints = scene.machine.joints();
        let moved =
            |letter: Joint| if letter.is_rotary() { scene.position_range[letter] } else { (0.0, 0.0) };
        let range = AxisValues::of(joints.iter().copied(), moved);
        let steps = AxisValues::from_fn(|_| steps);
        Self { joints, range, steps, point_in_tool_mm: [0.0; 3] }.checked()
    }

    fn checked(self) -> Result<Self, VolumeError> {
        let places: f64 = self.moving().map(|letter| self.steps[letter] as f64).product();
        match () {
            () if places <= 1.0 => Err(VolumeError::Empty),
            () if places > MOST_PLACES as f64 => Err(VolumeError::TooMany { places }),
            () => Ok(self),
        }
    }

    /// Axes with more than one place.
    pub fn moving(&self) -> impl Iterator<Item = Joint> + '_ {
        self.joints.iter().copied().filter(|&letter| self.range[letter].1 > self.range[letter].0)
    }

    /// Places of an axis, mm or rad.
    pub fn places(&self, letter: Joint) -> Vec<f64> {
        let (low, high) = self.range[letter];
        if high <= low {
            return vec![low];
        }
        let steps = self.steps[letter];
        (0..steps).map(|k| low + (high - low) * k as f64 / (steps - 1) as f64).collect()
    }

    /// All positions, the last axis fastest.
    pub fn grid(&self) -> Vec<AxisValues<f64>> {
        self.joints.iter().fold(vec![AxisValues::default()], |grid, &letter| {
            let places = self.places(letter);
            let with = |at: AxisValues<f64>, place: f64| {
                let mut at = at;
                at[letter] = place;
                at
            };
            grid.into_iter()
                .flat_map(|at| places.iter().map(move |&place| with(at, place)).collect::<Vec<_>>())
                .collect()
        })
    }

    /// E.g. `X −240..240 mm, B 0°`, of the axes of a machine.
    pub fn words(&self, machine: &Machine) -> String {
        let axes = machine.joints().into_iter();
        axes.map(|letter| spelt(letter, self.range[letter])).collect::<Vec<_>>().join(", ")
    }
}

/// `X=-200..200` or `C=30`, mm or degrees, as inside units.
fn read(part: &str, machine: &Machine) -> Result<(Joint, (f64, f64)), VolumeError> {
    let no_range = || VolumeError::NoRange { part: part.into() };
    // With either minus sign: what is printed can be given.
    let number = |text: &str| {
        let text = text.trim().replace('−', "-");
        text.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(no_range)
    };
    let (name, range) = part.split_once('=').ok_or_else(no_range)?;
    let (low, high) = match range.split_once("..") {
        Some((low, high)) => (number(low)?, number(high)?),
        None => (number(range)?, number(range)?),
    };
    let letter = machine.joint(name.trim()).ok_or_else(|| VolumeError::NoAxis {
        letter: name.trim().into(),
        machine: machine.name.clone(),
        allowed: machine.joints_near(name.trim()),
    })?;
    let inside = |x: f64| if letter.is_rotary() { convert::rad_from_deg(x) } else { x };
    if low > high { Err(no_range()) } else { Ok((letter, (inside(low), inside(high)))) }
}

fn spelt(letter: Joint, (low, high): (f64, f64)) -> String {
    let (unit, low, high) = match letter.is_rotary() {
        true => ("°", convert::deg_from_rad(low), convert::deg_from_rad(high)),
        false => (" mm", low, high),
    };
    let [low, high] = [low, high].map(|x| number::trimmed(x, 3));
    if low == high { format!("{letter} {low}{unit}") } else { format!("{letter} {low}..{high}{unit}") }
}
