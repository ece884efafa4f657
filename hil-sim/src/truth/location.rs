//! The location errors that a machine can have.

use nalgebra::Vector3;
use trunnion_core::{Joint, Twist};
use trunnion_machine::{JointErrors, Machine};

/// One component of an axis' location error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LocationError {
    /// The axis.
    pub axis: Joint,
    /// Direction of the error: a translation for X, Y, Z, a rotation for A, B, C.
    pub direction: Joint,
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

/// A location error of a joint whose name is no letter, by name: which place the joint has is known to its machine.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedError {
    /// Name of the joint, e.g. `C1`.
    pub joint: String,
    /// Direction of the error, as in [`LocationError`].
    pub direction: Joint,
    /// mm or rad.
    pub amount: f64,
}

impl NamedError {
    /// What `key` of a truth file names, e.g. `EX0C1_um`, and whether its unit fits.
    pub(super) fn of_key(key: &str) -> Option<(String, Joint)> {
        let (direction, rest) = key.strip_prefix('E')?.split_at_checked(1)?;
        let direction = Joint::ALL.into_iter().find(|joint| joint.as_str() == direction)?;
        let unit = if direction.is_rotary() { "_urad" } else { "_um" };
        Some((rest.strip_prefix('0')?.strip_suffix(unit)?.into(), direction))
    }

    /// As an error of a joint of `machine`; `None` when it has no joint of that name.
    pub(crate) fn on(&self, machine: &Machine) -> Option<(Joint, Twist)> {
        let axis = machine.joint(&self.joint)?;
        Some((axis, LocationError { axis, direction: self.direction }.twist() * self.amount))
    }
}

/// The location errors that say all: two translations and two tilts across each rotary axis; of a carried axis the
/// tilt about its carrier's line is called the zero position of the carrier (EB0B for EB0C). `table-bc`:
/// EX0B EZ0B EA0B EB0B EC0B EX0C EY0C EA0C.
pub fn minimum_set(machine: &Machine) -> Vec<LocationError> {
    let mut set: Vec<LocationError> = Vec::new();
    let mut carrier: Option<(Joint, usize, trunnion_machine::Side)> = None;
    for axis in machine.rotary() {
        let side = machine.side(axis.letter);
        let along = axis.direction.iamax();
        let across = (0..3).filter(|&k| k != along);
        set.extend(across.clone().map(|k| LocationError { axis: axis.letter, direction: Joint::LINEAR[k] }));
        for k in across {
            let tilt = LocationError { axis: axis.letter, direction: Joint::ROTARY[k] };
            match carrier {
                Some((carrier, about, of)) if Some(of) == side && about == k => {
                    set.push(LocationError { axis: carrier, direction: Joint::ROTARY[k] });
                }
                _ => set.push(tilt),
            }
        }
        carrier = side.map(|side| (axis.letter, along, side));
    }
    set
}
