//! One kind of hidden physics, and what its files need.

pub(super) use super::super::chain;
pub(super) use super::super::disturbance::Disturbance;
pub(super) use nalgebra::Vector3;
pub(super) use rand::{Rng, RngExt};
pub(super) use rand_chacha::ChaCha8Rng;
pub(super) use trunnion_core::{Joint, State, Twist};
pub(super) use trunnion_machine::Machine;

/// One kind of hidden physics.
#[derive(Debug)]
pub struct Kind {
    /// File name with hyphens; the id without its place.
    pub name: &'static str,
    /// What happens, in one line.
    pub about: &'static str,
    /// What a unit of amplitude is, e.g. `lost motion, mm or rad`.
    pub amplitude: &'static str,
    /// Where it can be.
    pub places: &'static [Place],
    /// In which cycle it shows.
    pub seen_in: SeenIn,
    /// Whether the axis' own encoder sees it: it is a following error, not one between encoder and tool.
    pub at_encoder: bool,
    /// Whether the program's catalogue promises an effect of this id (docs/design/contracts.md §1).
    pub catalogued: bool,
    /// Names of the shape's numbers, units in the name.
    pub shape: &'static [&'static str],
    pub(super) draw: fn(&mut ChaCha8Rng, &Circumstances<'_>) -> Vec<f64>,
    pub(super) disturb: fn(&Scene<'_>, &[f64]) -> Disturbance,
}

/// Where a hidden effect sits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In the machine as a whole.
    Machine,
    /// At one axis.
    Axis(Joint),
    /// Between two axes: the first turned against the second.
    Pair(Joint, Joint),
}

/// In which cycle an effect shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeenIn {
    /// In points read at rest.
    StaticGrid,
    /// Only while axes move.
    OnTheFly,
    /// In readings of turns, a level or an autocollimator; a ball shows it at an arm only, and that of some axes not at all.
    Turns,
}

/// What a draw may depend on.
#[derive(Clone, Copy, Debug)]
pub struct Circumstances<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Where the effect will sit.
    pub place: Place,
    /// Setups, measured one after the other.
    pub setups: usize,
    /// Smallest and largest coordinate of the axis at `place` in the cycle that shows the effect, mm or rad.
    pub travel: (f64, f64),
    /// Length of the run, s.
    pub run_duration_s: f64,
}

/// What an effect may depend on.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Where the effect sits.
    pub place: Place,
    /// The setup read.
    pub setup: usize,
    /// What the machine is doing.
    pub state: &'a State,
}

impl Scene<'_> {
    /// The letter of the axis where the effect sits.
    pub(super) fn letter(&self) -> Joint {
        match self.place {
            Place::Axis(letter) | Place::Pair(letter, _) => letter,
            Place::Machine => Joint::C,
        }
    }

    /// Position of that axis.
    pub(super) fn here(&self) -> f64 {
        self.state.position[self.letter()]
    }

    /// Time into the run, s; zero when the measurement has no time.
    pub(super) fn time_s(&self) -> f64 {
        self.state.time_s.unwrap_or(0.0)
    }

    /// A positioning error of that axis, in its own coordinate.
    pub(super) fn positioning(&self, letter: Joint, error: f64) -> Disturbance {
        let Some(axis) = self.machine.axis(letter) else { return Disturbance::default() };
        let along = axis.direction.into_inner() * (axis.sense * error);
        let twist = if axis.is_rotary() { Twist::rotation(along) } else { Twist::translation(along) };
        Disturbance::joint(letter, twist)
    }

    /// (across, along): two directions across an axis and the axis itself, right-handed, in the axes of its carrier.
    pub(super) fn trihedron(&self) -> [Vector3<f64>; 3] {
        let i = self.letter().index() % 3;
        [(i + 1) % 3, (i + 2) % 3, i].map(|k| Vector3::ith(k, 1.0))
    }
}

pub(super) const A: Place = Place::Axis(Joint::A);

pub(super) const B: Place = Place::Axis(Joint::B);

pub(super) const C: Place = Place::Axis(Joint::C);

pub(super) const X: Place = Place::Axis(Joint::X);

pub(super) const Y: Place = Place::Axis(Joint::Y);

pub(super) const Z: Place = Place::Axis(Joint::Z);

/// The numbers of a shape by position; their count was checked when the truth was made.
pub(super) fn numbers<const N: usize>(shape: &[f64]) -> [f64; N] {
    shape.try_into().expect("a shape has the length of its kind's names, checked when drawn and when read")
}

/// An angle anywhere on the circle, rad.
pub(super) fn any_angle(rng: &mut impl Rng) -> f64 {
    rng.random_range(0.0..std::f64::consts::TAU)
}

/// +1 or −1.
pub(super) fn any_sign(rng: &mut impl Rng) -> f64 {
    if rng.random::<bool>() { 1.0 } else { -1.0 }
}

/// A direction in space.
pub(super) fn any_direction(rng: &mut impl Rng) -> Vector3<f64> {
    let z = rng.random_range(-1.0..1.0_f64);
    let around = any_angle(rng);
    let r = (1.0 - z * z).sqrt();
    Vector3::new(r * around.cos(), r * around.sin(), z)
}
