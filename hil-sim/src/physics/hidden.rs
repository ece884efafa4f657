//! Physics that no base model knows of: one file each, one line in [`KINDS`].
//!
//! A kind says what a unit of it does to the machine at a state; drawing chooses its shape (phases, time
//! constants, directions) and then its amplitude, so that a unit `sigma` gives [`TYPICAL_RMS_MM`] in the readings.

mod axial_error_motion;
mod backlash;
mod cable_drag;
mod coolant_cycle;
mod dahl_hysteresis;
mod drift_gravity;
mod drive_pitch;
mod encoder_eccentricity;
mod gravity_sag;
mod linear_scale;
mod local_bump;
mod radial_error_motion;
mod reversal_spike;
mod servo_lag;
mod setup_slip;
mod size;
mod soft_step;
mod squareness;
mod stiff_stop;
mod straightness;
mod sync_delay;
mod thermal_drift;
mod tilt_error_motion;
mod unbalance;

pub use size::{effect_rms_mm, surviving_rms_mm};

use super::chain;
use super::disturbance::Disturbance;
use crate::truth::SimSetup;
use nalgebra::Vector3;
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trunnion_core::{AxisLetter, State, Twist};
use trunnion_machine::Machine;

/// Raw rms of an effect of `sigma` = 1 over the readings of the cycle in which it is seen, mm [docs/design/physics.md §9: 4–8 µm].
pub const TYPICAL_RMS_MM: f64 = 5e-3;

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
    draw: fn(&mut ChaCha8Rng, &Circumstances<'_>) -> Vec<f64>,
    disturb: fn(&Scene<'_>, &[f64]) -> Disturbance,
}

/// The registry.
pub const KINDS: [&Kind; 23] = [
    &axial_error_motion::KIND,
    &backlash::KIND,
    &cable_drag::KIND,
    &coolant_cycle::KIND,
    &dahl_hysteresis::KIND,
    &drift_gravity::KIND,
    &drive_pitch::KIND,
    &encoder_eccentricity::KIND,
    &gravity_sag::KIND,
    &linear_scale::KIND,
    &local_bump::KIND,
    &radial_error_motion::KIND,
    &reversal_spike::KIND,
    &servo_lag::KIND,
    &setup_slip::KIND,
    &soft_step::KIND,
    &squareness::KIND,
    &stiff_stop::KIND,
    &straightness::KIND,
    &sync_delay::KIND,
    &thermal_drift::KIND,
    &tilt_error_motion::KIND,
    &unbalance::KIND,
];

/// Where a hidden effect sits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In the machine as a whole.
    Machine,
    /// At one axis.
    Axis(AxisLetter),
    /// Between two axes: the first turned against the second.
    Pair(AxisLetter, AxisLetter),
}

/// In which cycle an effect shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeenIn {
    /// In points read at rest.
    StaticGrid,
    /// Only while axes move.
    OnTheFly,
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

/// One hidden effect of one machine.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// Its kind.
    pub kind: &'static Kind,
    /// Where it sits.
    pub place: Place,
    /// In the unit of [`Kind::amplitude`].
    pub amplitude: f64,
    /// The numbers of [`Kind::shape`].
    pub shape: Vec<f64>,
}

/// A wish for a hidden effect.
#[derive(Clone, Debug, PartialEq)]
pub struct HiddenChoice {
    /// One of [`ids`].
    pub id: String,
    /// Size: raw rms over the cycle that shows it, in units of [`TYPICAL_RMS_MM`].
    pub sigma: f64,
}

/// No such hidden physics.
#[derive(Debug, thiserror::Error)]
pub enum UnknownHidden {
    /// The id is in no registry line.
    #[error("hidden physics \"{id}\" is not known; allowed: {}", .allowed.join(", "))]
    NoSuchId {
        /// As asked.
        id: String,
        /// Every id.
        allowed: Vec<String>,
    },
    /// The machine has no such axis.
    #[error(
        "hidden physics \"{id}\" needs an axis that machine {machine} does not have; choose one of its axes"
    )]
    NoSuchAxis {
        /// As asked.
        id: String,
        /// Name of the machine.
        machine: String,
    },
    /// It moves nothing that these setups could read.
    #[error(
        "hidden physics \"{id}\" does nothing that the setups of machine {machine} can read; choose another effect or another setup"
    )]
    NoEffect {
        /// As asked.
        id: String,
        /// Name of the machine.
        machine: String,
    },
}

/// Every id, in order.
pub fn ids() -> Vec<String> {
    KINDS.iter().flat_map(|kind| kind.places.iter().map(|&place| id(kind, place))).collect()
}

/// The kind and place an id names.
///
/// # Errors
/// With every allowed id.
pub fn find(wanted: &str) -> Result<(&'static Kind, Place), UnknownHidden> {
    let all = KINDS.iter().flat_map(|kind| kind.places.iter().map(move |&place| (*kind, place)));
    all.into_iter()
        .find(|&(kind, place)| id(kind, place) == wanted)
        .ok_or_else(|| UnknownHidden::NoSuchId { id: wanted.into(), allowed: ids() })
}

/// A catalogued effect that shows at rest on this machine, chosen by seed.
pub fn random(machine: &Machine, seed: u64) -> HiddenChoice {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x7261_6e64_6f6d);
    let visible: Vec<&str> = SHOWN_BY_A_STATIC_RUN
        .into_iter()
        .filter(|id| find(id).is_ok_and(|(_, place)| fits(machine, place)))
        .collect();
    let id = visible.choose(&mut rng).copied().unwrap_or("thermal-drift");
    HiddenChoice { id: id.into(), sigma: rng.random_range(0.8..1.4) }
}

/// Catalogued effects of which the S1 grid keeps most after location errors and settings are fitted, and that it
/// can tell from each other (docs/design/statistics.md §4.4).
const SHOWN_BY_A_STATIC_RUN: [&str; 13] = [
    "gravity-sag:B",
    "gravity-sag:A",
    "backlash:C",
    "backlash:B",
    "thermal-drift",
    "encoder-eccentricity:C",
    "tilt-error-motion:C",
    "radial-error-motion:C",
    "axial-error-motion:C",
    "unbalance:C",
    "setup-slip",
    "straightness:Z",
    "squareness:ZX",
];

impl Hidden {
    /// Draws the shape of an effect and gives it the size asked for.
    ///
    /// # Errors
    /// Unknown id, an axis the machine has not, or an effect these setups cannot see.
    pub fn draw(
        choice: &HiddenChoice,
        machine: &Machine,
        setups: &[SimSetup],
        run_duration_s: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, UnknownHidden> {
        let (kind, place) = find(&choice.id)?;
        if !fits(machine, place) {
            return Err(UnknownHidden::NoSuchAxis { id: choice.id.clone(), machine: machine.name.clone() });
        }
        let states = size::states(kind, machine, setups, run_duration_s);
        let travel = travel(place, &states);
        let around = Circumstances { machine, place, setups: setups.len(), travel, run_duration_s };
        let shape = (kind.draw)(rng, &around);
        let mut hidden = Self { kind, place, amplitude: 1.0, shape };
        // Sized by a small amplitude, so that the exact transforms stay in their linear range.
        hidden.amplitude = size::PROBE_AMPLITUDE;
        let probed_mm = effect_rms_mm(&hidden, machine, setups, &states);
        if probed_mm < 1e-12 {
            return Err(UnknownHidden::NoEffect { id: choice.id.clone(), machine: machine.name.clone() });
        }
        hidden.amplitude *= choice.sigma * TYPICAL_RMS_MM / probed_mm;
        Ok(hidden)
    }

    /// Its id.
    pub fn id(&self) -> String {
        id(self.kind, self.place)
    }

    /// What it does at a state.
    pub fn at(&self, scene: &Scene<'_>) -> Disturbance {
        (self.kind.disturb)(scene, &self.shape) * self.amplitude
    }
}

impl PartialEq for Hidden {
    fn eq(&self, other: &Self) -> bool {
        self.id() == other.id() && self.amplitude == other.amplitude && self.shape == other.shape
    }
}

impl Scene<'_> {
    /// The letter of the axis where the effect sits.
    fn letter(&self) -> AxisLetter {
        match self.place {
            Place::Axis(letter) | Place::Pair(letter, _) => letter,
            Place::Machine => AxisLetter::C,
        }
    }

    /// Position of that axis.
    fn here(&self) -> f64 {
        self.state.position[self.letter()]
    }

    /// Time into the run, s; zero when the measurement has no time.
    fn time_s(&self) -> f64 {
        self.state.time_s.unwrap_or(0.0)
    }

    /// A positioning error of that axis, in its own coordinate.
    fn positioning(&self, letter: AxisLetter, error: f64) -> Disturbance {
        let Some(axis) = self.machine.axis(letter) else { return Disturbance::default() };
        let along = axis.direction.into_inner() * (axis.sense * error);
        let twist = if axis.is_rotary() { Twist::rotation(along) } else { Twist::translation(along) };
        Disturbance::joint(letter, twist)
    }

    /// (across, along): two directions across an axis and the axis itself, right-handed, in the axes of its carrier.
    fn trihedron(&self) -> [Vector3<f64>; 3] {
        let i = self.letter().index() % 3;
        [(i + 1) % 3, (i + 2) % 3, i].map(|k| Vector3::ith(k, 1.0))
    }
}

fn id(kind: &Kind, place: Place) -> String {
    match place {
        Place::Machine => kind.name.into(),
        Place::Axis(letter) => format!("{}:{letter}", kind.name),
        Place::Pair(turned, against) => format!("{}:{turned}{against}", kind.name),
    }
}

/// Smallest and largest coordinate of the axis at a place; zeros where there is none.
fn travel(place: Place, states: &[State]) -> (f64, f64) {
    let (Place::Axis(letter) | Place::Pair(letter, _)) = place else { return (0.0, 0.0) };
    let positions = || states.iter().map(|state| state.position[letter]);
    let low = positions().fold(f64::INFINITY, f64::min);
    let high = positions().fold(f64::NEG_INFINITY, f64::max);
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// Whether the machine has the axes of a place.
pub fn fits(machine: &Machine, place: Place) -> bool {
    match place {
        Place::Machine => true,
        Place::Axis(letter) => machine.axis(letter).is_some(),
        Place::Pair(one, other) => machine.axis(one).is_some() && machine.axis(other).is_some(),
    }
}

const A: Place = Place::Axis(AxisLetter::A);
const B: Place = Place::Axis(AxisLetter::B);
const C: Place = Place::Axis(AxisLetter::C);
const X: Place = Place::Axis(AxisLetter::X);
const Y: Place = Place::Axis(AxisLetter::Y);
const Z: Place = Place::Axis(AxisLetter::Z);

/// The numbers of a shape by position; their count was checked when the truth was made.
fn numbers<const N: usize>(shape: &[f64]) -> [f64; N] {
    shape.try_into().expect("a shape has the length of its kind's names, checked when drawn and when read")
}

/// An angle anywhere on the circle, rad.
fn any_angle(rng: &mut impl Rng) -> f64 {
    rng.random_range(0.0..std::f64::consts::TAU)
}

/// +1 or −1.
fn any_sign(rng: &mut impl Rng) -> f64 {
    if rng.random::<bool>() { 1.0 } else { -1.0 }
}

/// A direction in space.
fn any_direction(rng: &mut impl Rng) -> Vector3<f64> {
    let z = rng.random_range(-1.0..1.0_f64);
    let around = any_angle(rng);
    let r = (1.0 - z * z).sqrt();
    Vector3::new(r * around.cos(), r * around.sin(), z)
}
