//! What an effect is about, and its numbers: subject, linear parameters with units, shape numbers.

use crate::fixed_text::{FixedText, fixed_text};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use trunnion_core::{Joint, Twist};
use trunnion_machine::Site;

/// Receives the motions of an effect: for each parameter, at each site, the twist per unit (1 mm, 1 rad, …)
/// of that parameter. A parameter may act at several sites; motions add.
pub type Emit<'a> = &'a mut dyn FnMut(usize, Site, Twist);

/// What an instance is about: the part of the id after the colon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Subject {
    /// The whole machine; the id has no colon.
    Whole,
    /// One axis, `:B`.
    Axis(Joint),
    /// A pair of axes, `:ZX`.
    Pair(Joint, Joint),
}

/// One linear parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, unique in the model when prefixed by the effect id; location errors use ISO 230 symbols.
    pub name: String,
    /// Unit on files and screens.
    pub unit: Unit,
    /// Beyond what the parameter is not physical.
    pub limit: Option<Limit>,
    /// True for a change at one moment. A display shows any slow change as sudden ones, each of one step.
    pub sudden: bool,
    /// What a positive and what a negative value say of the machine, where a person can tell which of them is true.
    pub meaning: Option<[&'static str; 2]>,
    /// Standard uncertainty beforehand, inside units, of what no reading shows to first order: the tilt of a beam.
    pub u_beforehand: Option<f64>,
}

/// The largest size of a parameter that its cause can have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// In the unit of screens.
    pub largest: f64,
    /// What a larger one says instead.
    #[serde(deserialize_with = "fixed_text")]
    pub beyond: FixedText,
    /// A larger one says so only where nothing else is found: the readings are another effect's, which it resembles.
    pub resembles: bool,
}

impl Limit {
    /// Whether a value lies beyond, in the unit of screens. Its u is not asked: what speaks for an effect speaks for the value that
    /// fits best.
    pub fn is_exceeded(&self, value: f64) -> bool {
        value.abs() > self.largest
    }
}

/// A unit on files and screens with its size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unit {
    /// Text in JSON, e.g. `um`, `urad`, `um/K`.
    #[serde(deserialize_with = "fixed_text")]
    pub symbol: FixedText,
    /// Value on the screen = value inside × this.
    pub per_inside: f64,
}

impl Unit {
    /// µm for mm.
    pub const UM: Self = Self { symbol: "um", per_inside: 1e3 };
    /// µrad for rad.
    pub const URAD: Self = Self { symbol: "urad", per_inside: 1e6 };
    /// µm/m for a ratio.
    pub const UM_PER_M: Self = Self { symbol: "um/m", per_inside: 1e6 };
    /// µm/K for mm/K.
    pub const UM_PER_K: Self = Self { symbol: "um/K", per_inside: 1e3 };
    /// µm/mm for a ratio.
    pub const UM_PER_MM: Self = Self { symbol: "um/mm", per_inside: 1e3 };
    /// µm/mm² for 1/mm.
    pub const UM_PER_MM2: Self = Self { symbol: "um/mm2", per_inside: 1e3 };
    /// µm per m/s² for s² (mm per mm/s²).
    pub const UM_PER_M_S2: Self = Self { symbol: "um/(m/s2)", per_inside: 1e6 };
    /// µrad per rad/s² for s².
    pub const URAD_PER_RAD_S2: Self = Self { symbol: "urad/(rad/s2)", per_inside: 1e6 };
    /// µrad per m/s² for rad·s²/mm.
    pub const URAD_PER_M_S2: Self = Self { symbol: "urad/(m/s2)", per_inside: 1e9 };
    /// µm per (rad/s)² for mm·s².
    pub const UM_PER_RAD2_S2: Self = Self { symbol: "um/(rad/s)2", per_inside: 1e3 };
    /// ms for s.
    pub const MS: Self = Self { symbol: "ms", per_inside: 1e3 };
    /// Degrees for rad.
    pub const DEG: Self = Self { symbol: "deg", per_inside: 180.0 / std::f64::consts::PI };
    /// mm.
    pub const MM: Self = Self { symbol: "mm", per_inside: 1.0 };
    /// Seconds.
    pub const S: Self = Self { symbol: "s", per_inside: 1.0 };
    /// Radians as they are.
    pub const RAD: Self = Self { symbol: "rad", per_inside: 1.0 };
    /// Hertz for cycles per second.
    pub const HZ: Self = Self { symbol: "Hz", per_inside: 1.0 };
    /// A plain number.
    pub const ONE: Self = Self { symbol: "1", per_inside: 1.0 };

    /// The unit that the name of a shape number ends with, e.g. seconds of `tau_s`; a plain number where it names none.
    pub fn in_name(name: &str) -> Self {
        let ends = [("_s", Self::S), ("_mm", Self::MM), ("_rad", Self::RAD), ("_hz", Self::HZ)];
        ends.into_iter().find(|(end, _)| name.ends_with(end)).map_or(Self::ONE, |(_, unit)| unit)
    }

    /// The symbol as people write it, e.g. `µm/(m/s²)`; empty for a plain number.
    pub fn text(&self) -> String {
        let written = [
            ("um", "µm"),
            ("urad", "µrad"),
            ("deg", "°"),
            ("mm2", "mm²"),
            ("s2", "s²"),
            (")2", ")²"),
            ("1", ""),
        ];
        written.iter().fold(self.symbol.into(), |text: String, (from, to)| text.replace(from, to))
    }
}

/// Grid of shape numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shapes {
    /// Name and unit ([`Unit::in_name`]) of each shape number, e.g. `tau_s`.
    pub names: Vec<String>,
    /// Grid points; one empty entry when the effect has no shape numbers.
    pub grid: Vec<Vec<f64>>,
    /// True when values between grid points make sense (a time constant), false for counts (lobes, teeth).
    pub continuous: bool,
    /// Set where the number is that of a wave along an axis, which may have any value: the grid holds known ones only.
    pub wave: Option<WaveNumber>,
    /// Shape numbers that these poses show as other ones: no fit tries them, but they may be what looks like another effect.
    pub aliased: Vec<Vec<f64>>,
}

/// A shape number that says how a wave repeats along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaveNumber {
    /// Period along a linear axis, mm.
    Period(Joint),
    /// Cycles in a turn of a rotary axis.
    Cycles(Joint),
}

impl WaveNumber {
    /// The axis.
    pub fn joint(self) -> Joint {
        match self {
            Self::Period(joint) | Self::Cycles(joint) => joint,
        }
    }

    /// The shape number of an angular frequency, rad per mm or per rad; its own inverse.
    pub fn number(self, omega: f64) -> f64 {
        match self {
            Self::Period(_) => TAU / omega,
            Self::Cycles(_) => omega,
        }
    }
}

impl Shapes {
    /// No shape numbers.
    pub fn none() -> Self {
        Self { grid: vec![Vec::new()], ..Self::default() }
    }

    /// One shape number with these grid values.
    pub fn one(name: &str, values: impl IntoIterator<Item = f64>, continuous: bool) -> Self {
        let grid = values.into_iter().map(|v| vec![v]).collect();
        Self { names: vec![name.into()], grid, continuous, ..Self::default() }
    }

    /// The same with values of one number that these poses show as others.
    #[must_use]
    pub fn aliasing(self, values: impl IntoIterator<Item = f64>) -> Self {
        Self { aliased: values.into_iter().map(|v| vec![v]).collect(), ..self }
    }

    /// All that the effect may have: what a fit tries, and what these poses show as something else.
    pub fn possible(self) -> Vec<Vec<f64>> {
        self.grid.into_iter().chain(self.aliased).collect()
    }

    /// The same where the number is that of a wave, which may have any value.
    #[must_use]
    pub fn waving(self, wave: WaveNumber) -> Self {
        Self { wave: Some(wave), ..self }
    }
}

impl Parameter {
    /// A parameter.
    pub fn new(name: impl Into<String>, unit: Unit) -> Self {
        Self { name: name.into(), unit, limit: None, sudden: false, meaning: None, u_beforehand: None }
    }

    /// The same where a larger size is not physical.
    #[must_use]
    pub fn at_most(self, limit: Limit) -> Self {
        Self { limit: Some(limit), ..self }
    }

    /// The same with what is known of it beforehand.
    #[must_use]
    pub fn known_within(self, u_beforehand: Option<f64>) -> Self {
        Self { u_beforehand, ..self }
    }

    /// The same where a positive and a negative value say something that a person can see.
    #[must_use]
    pub fn meaning(self, of_signs: [&'static str; 2]) -> Self {
        Self { meaning: Some(of_signs), ..self }
    }

    /// What this value says of the machine by its sign, and what to do where that cannot be; `id` is that of the effect. `None` where a sign says
    /// nothing.
    pub fn said_by_sign(&self, id: &str, value: f64) -> Option<String> {
        let [positive, negative] = self.meaning?;
        let meaning = if value > 0.0 { positive } else { negative };
        Some(format!(
            "By {id}, {meaning}: if that cannot be, weight was taken to act against gravity, and every location error is the other way round: \
             make the sign test then, before anything is changed."
        ))
    }

    /// The same where it changes the readings at one moment.
    #[must_use]
    pub fn sudden(self) -> Self {
        Self { sudden: true, ..self }
    }
}
