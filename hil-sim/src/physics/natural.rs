//! The small repeatable error motions every real rotary axis has: a fraction of a micrometre, low harmonics.
//!
//! `δ, ω(θ) = Σ_{n=1..4} (a cos nθ + b sin nθ)/n` at the joint; translations of the given size, rotations of
//! that size over [`ARM_MM`]. Too small and too mixed to deserve a name.

use super::Disturbance;
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{Joint, State, Twist};
use trunnion_machine::Machine;

/// Typical distance of the ball from an axis, mm.
const ARM_MM: f64 = 250.0;
const HARMONICS: usize = 4;

/// Error motion of one axis.
#[derive(Clone, Debug)]
pub struct NaturalMotion {
    letter: Joint,
    /// Cosine and sine amplitudes of each harmonic.
    harmonics: [[Twist; 2]; HARMONICS],
}

/// The error motions of every rotary axis of a machine.
pub fn draw(machine: &Machine, size_mm: f64, seed: u64) -> Vec<NaturalMotion> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x6e61_7475_7261_6c00);
    // Twelve independent terms share the variance of about three visible components.
    let share_mm = size_mm / 2.0;
    let mut motions = Vec::new();
    for axis in machine.rotary() {
        let harmonics = std::array::from_fn(|n| {
            let size_mm = share_mm / (n + 1) as f64;
            std::array::from_fn(|_| Twist {
                translation_mm: normal_vector(&mut rng) * size_mm,
                rotation_rad: normal_vector(&mut rng) * (size_mm / ARM_MM),
            })
        });
        motions.push(NaturalMotion { letter: axis.letter, harmonics });
    }
    motions
}

impl NaturalMotion {
    /// The error at a state.
    pub fn at(&self, state: &State) -> Disturbance {
        let angle = state.position[self.letter];
        let mut twist = Twist::default();
        for (n, [cosine, sine]) in (1..).zip(self.harmonics) {
            let (sin, cos) = (f64::from(n) * angle).sin_cos();
            twist += cosine * cos + sine * sin;
        }
        Disturbance::joint(self.letter, twist)
    }
}

/// Three independent standard normal numbers.
pub fn normal_vector(rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(rng))
}
