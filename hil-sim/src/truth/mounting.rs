//! The same machine measured again with other setups.

use super::draw::SETTING_MM;
use super::{PlacedSetup, SimSetup, Truth};
use crate::instruments::mounted_by_hand;
use crate::physics::natural::normal_vector;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Streams of the truth's seed for settings drawn later.
const SETTING_STREAM: u64 = 0x7365_7474_0000;

impl Truth {
    /// This machine with `setups` mounted in a later run. In run 0 a setup of the truth's own (same name and place) keeps
    /// its setting; every other one, and all in later runs, are mounted again: their setting is drawn from the seed, the
    /// run and the number of the setup.
    #[must_use]
    pub fn mounted(&self, setups: &[SimSetup], run: u64) -> Self {
        let own = |setup: &SimSetup| self.setups.iter().find(|placed| run == 0 && placed.setup == *setup);
        let place = |(i, setup): (usize, &SimSetup)| {
            own(setup).cloned().unwrap_or_else(|| {
                let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
                rng.set_stream(SETTING_STREAM + (run << 8) + i as u64);
                let setting_mm = normal_vector(&mut rng) * SETTING_MM;
                let mut placed = mounted_by_hand(setup, setting_mm, &mut rng);
                let off = normal_vector(&mut rng) * self.off_spindle_mm;
                placed.own.off_spindle_mm = Vector3::new(off.x, off.y, 0.0);
                PlacedSetup { form_mm: self.form_mm(setup), ..placed }
            })
        };
        Self { setups: setups.iter().enumerate().map(place).collect(), ..self.clone() }
    }
}

/// Streams of the truth's seed for forms of artefacts.
const FORM_STREAM: u64 = 0x666f_726d_0000;
/// How far a ball of an uncalibrated artefact is off its nominal place, mm.
const FORM_MM: f64 = 10e-3;

impl Truth {
    /// Where the targets of an uncalibrated artefact really are: the same for every setup that it is in.
    fn form_mm(&self, setup: &SimSetup) -> Vec<Vector3<f64>> {
        let Some(form) = &setup.uncalibrated else { return Vec::new() };
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let named = form.name.bytes().fold(0u64, |sum, byte| (sum * 31 + u64::from(byte)) % 65_521);
        rng.set_stream(FORM_STREAM + named);
        let one = |_| form.table_from_artefact * (normal_vector(&mut rng) * FORM_MM);
        setup.targets.iter().map(one).collect()
    }
}
