//! A small rigid displacement: translation and rotation vector, in the axes of some frame.

use nalgebra::Vector3;
use std::ops::{Add, AddAssign, Mul};

/// Lever over which a rotation is weighed against a translation, mm: S4 prints tilts over it (µm/100 mm), and it is about as far as
/// work reaches from an axis.
pub const LEVER_MM: f64 = 100.0;

/// A small displacement of a body: (δ, ω) of docs/design/physics.md §2. The frame is the owner's to name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// δ, translation of the frame origin, mm.
    pub translation_mm: Vector3<f64>,
    /// ω, rotation angles about X, Y, Z, rad (composed as Da·Db·Dc when not infinitesimal).
    pub rotation_rad: Vector3<f64>,
}

impl Twist {
    /// A pure translation, mm.
    pub fn translation(translation_mm: Vector3<f64>) -> Self {
        Self { translation_mm, rotation_rad: Vector3::zeros() }
    }

    /// A pure rotation, rad.
    pub fn rotation(rotation_rad: Vector3<f64>) -> Self {
        Self { translation_mm: Vector3::zeros(), rotation_rad }
    }
}

impl Add for Twist {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            translation_mm: self.translation_mm + other.translation_mm,
            rotation_rad: self.rotation_rad + other.rotation_rad,
        }
    }
}

impl AddAssign for Twist {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<f64> for Twist {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self { translation_mm: self.translation_mm * factor, rotation_rad: self.rotation_rad * factor }
    }
}
