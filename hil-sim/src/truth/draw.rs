//! Drawing a truth from a seed.
//!
//! Location errors ~10 µm and 50 µrad, of the minimum set only [S2 tables 2–5]: what the others do, these do too.

use super::location::minimum_set;
use super::{Noise, PlacedSetup, SimSetup, Truth};
use crate::physics::hidden::{Hidden, HiddenChoice, UnknownHidden};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_machine::Machine;

const LOCATION_MM: f64 = 10e-3;
const LOCATION_RAD: f64 = 50e-6;
/// Where a ball ends up when it is set by hand, mm.
pub(super) const SETTING_MM: f64 = 15e-3;

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
