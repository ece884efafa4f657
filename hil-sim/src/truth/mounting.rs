//! The same machine measured again with other setups.

use super::draw::SETTING_MM;
use super::{PlacedSetup, SimSetup, Truth};
use crate::physics::natural::normal_vector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Streams of the truth's seed for settings drawn later.
const SETTING_STREAM: u64 = 0x7365_7474_0000;

impl Truth {
    /// This machine with `setups` mounted in a later run. In run 0 a setup of the truth's own (same name and place) keeps
    /// its setting; every other one, and all in later runs, are mounted anew: their setting is drawn from the seed, the
    /// run and the number of the setup.
    #[must_use]
    pub fn mounted(&self, setups: &[SimSetup], run: u64) -> Self {
        let own = |setup: &SimSetup| self.setups.iter().find(|placed| run == 0 && placed.setup == *setup);
        let place = |(i, setup): (usize, &SimSetup)| {
            own(setup).cloned().unwrap_or_else(|| {
                let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
                rng.set_stream(SETTING_STREAM + (run << 8) + i as u64);
                PlacedSetup { setup: setup.clone(), setting_mm: normal_vector(&mut rng) * SETTING_MM }
            })
        };
        Self { setups: setups.iter().enumerate().map(place).collect(), ..self.clone() }
    }
}
