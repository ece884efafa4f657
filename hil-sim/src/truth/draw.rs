//! Drawing a truth from a seed.
//!
//! Location errors ~10 µm and 50 µrad, of the minimum set only [S2 tables 2–5]: what the others do, these do too.

use super::{Noise, PlacedSetup, SimSetup, Truth};
use crate::physics::hidden::{Hidden, HiddenChoice, UnknownHidden};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{AxisLetter, Twist};
use trunnion_machine::{JointErrors, Machine};

const LOCATION_MM: f64 = 10e-3;
const LOCATION_RAD: f64 = 50e-6;
/// Where a ball ends up when it is set by hand, mm.
pub(super) const SETTING_MM: f64 = 15e-3;

/// One component of an axis' location error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LocationError {
    /// The axis.
    pub axis: AxisLetter,
    /// Direction of the error: a translation for X, Y, Z, a rotation for A, B, C.
    pub direction: AxisLetter,
}

impl LocationError {
    /// Its name by ISO 230-1, e.g. `EX0C`.
    pub fn name(self) -> String {
        format!("E{}0{}", self.direction, self.axis)
    }

    /// One unit of it, 1 mm or 1 rad.
    pub fn twist(self) -> Twist {
        let unit = Vector3::ith(self.direction.index() % 3, 1.0);
        if self.direction.is_rotary() { Twist::rotation(unit) } else { Twist::translation(unit) }
    }

    /// Its value in a set of joint errors, mm or rad.
    pub fn of(self, errors: &JointErrors) -> f64 {
        let twist = &errors[self.axis];
        let vector = if self.direction.is_rotary() { twist.rotation_rad } else { twist.translation_mm };
        vector[self.direction.index() % 3]
    }
}

/// The location errors that say all: two translations and two tilts across each rotary axis; of a carried axis the
/// tilt about its carrier's line is called the zero position of the carrier (EB0B for EB0C). `table-bc`:
/// EX0B EZ0B EA0B EB0B EC0B EX0C EY0C EA0C.
pub fn minimum_set(machine: &Machine) -> Vec<LocationError> {
    let mut set: Vec<LocationError> = Vec::new();
    let mut carrier: Option<(AxisLetter, usize, trunnion_machine::Side)> = None;
    for axis in machine.rotary() {
        let side = machine.side(axis.letter);
        let along = axis.direction.iamax();
        let across = (0..3).filter(|&k| k != along);
        set.extend(
            across.clone().map(|k| LocationError { axis: axis.letter, direction: AxisLetter::LINEAR[k] }),
        );
        for k in across {
            let tilt = LocationError { axis: axis.letter, direction: AxisLetter::ROTARY[k] };
            match carrier {
                Some((carrier, about, of)) if Some(of) == side && about == k => {
                    set.push(LocationError { axis: carrier, direction: AxisLetter::ROTARY[k] });
                }
                _ => set.push(tilt),
            }
        }
        carrier = side.map(|side| (axis.letter, along, side));
    }
    set
}

impl Truth {
    /// Draws a machine with everything real machines have, and the hidden physics asked for. Time constants
    /// are shares of the run, so that a run pressed into a minute looks like half an hour.
    ///
    /// # Errors
    /// Unknown hidden physics, or such as this machine cannot have.
    pub fn draw(
        machine: &Machine,
        setups: &[SimSetup],
        hidden: &[HiddenChoice],
        run_duration_s: f64,
        seed: u64,
    ) -> Result<Self, UnknownHidden> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut truth = Self::perfect(&machine.name, setups, run_duration_s);
        truth.seed = seed;
        truth.noise = Noise::real(run_duration_s);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        for error in minimum_set(machine) {
            let size = if error.direction.is_rotary() { LOCATION_RAD } else { LOCATION_MM };
            truth.location[error.axis] += error.twist() * (size * normal());
        }
        for PlacedSetup { setting_mm, .. } in &mut truth.setups {
            *setting_mm = Vector3::from_fn(|_, _| SETTING_MM * normal());
        }
        // A stream of its own for each: what is hidden does not change with how many others are.
        for (i, choice) in hidden.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(1000 + i as u64);
            truth.hidden.push(Hidden::draw(choice, machine, setups, run_duration_s, &mut rng)?);
        }
        Ok(truth)
    }
}
