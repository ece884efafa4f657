//! Physics that no base model knows of: one file each, one line in [`KINDS`].
//!
//! A kind says what a unit of it does to the machine at a state; drawing chooses its shape (phases, time
//! constants, directions) and then its amplitude, so that a unit `sigma` gives [`TYPICAL_RMS_MM`] in the readings.

mod angular_motion;
mod axial_error_motion;
mod backlash;
mod cable_drag;
mod coolant_cycle;
mod dahl_hysteresis;
mod drift_gravity;
mod drive_pitch;
mod encoder_eccentricity;
mod gravity_sag;
mod kind;
mod linear_scale;
mod local_bump;
mod radial_error_motion;
mod reversal_spike;
mod servo_lag;
mod setup_slip;
pub mod size;
mod soft_step;
mod squareness;
mod stiff_stop;
mod straightness;
mod sync_delay;
mod thermal_drift;
mod tilt_error_motion;
mod unbalance;

pub use kind::{Circumstances, Kind, Place, Scene, SeenIn};

use super::disturbance::Disturbance;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trunnion_core::names;
use trunnion_machine::Machine;

/// Raw rms of an effect of `sigma` = 1 over the readings of the cycle in which it is seen, mm [docs/design/physics.md §9: 4–8 µm].
pub const TYPICAL_RMS_MM: f64 = 5e-3;

/// The registry.
pub const KINDS: [&Kind; 24] = [
    &angular_motion::KIND,
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
    #[error("hidden physics \"{id}\" is not known; allowed: {}", names::allowed(id, allowed))]
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
/// can separate from each other (docs/design/statistics.md §4.4).
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

fn id(kind: &Kind, place: Place) -> String {
    match place {
        Place::Machine => kind.name.into(),
        Place::Axis(letter) => format!("{}:{letter}", kind.name),
        Place::Pair(turned, against) => format!("{}:{turned}{against}", kind.name),
    }
}

/// Whether the machine has the axes of a place.
pub fn fits(machine: &Machine, place: Place) -> bool {
    match place {
        Place::Machine => true,
        Place::Axis(letter) => machine.axis(letter).is_some(),
        Place::Pair(one, other) => machine.axis(one).is_some() && machine.axis(other).is_some(),
    }
}
