//! A leg as the machine file gives it.

use nalgebra::Vector3;
use trunnion_core::Joint;

/// One leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// The letter its stroke has on recordings and in cycles.
    pub letter: Joint,
    /// A: joint on the base, base axes, mm.
    pub base_joint_mm: Vector3<f64>,
    /// B: joint on the platform, from the platform's origin, platform axes, mm.
    pub platform_joint_mm: Vector3<f64>,
    /// Length from joint to joint at coordinate zero, mm.
    pub length_at_zero_mm: f64,
    /// +1: the leg grows with its coordinate; −1: it shortens.
    pub sense: f64,
}
