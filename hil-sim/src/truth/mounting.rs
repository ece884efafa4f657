//! The same machine measured again with other setups.

use super::draw::SETTING_MM;
use super::{Instrument, Own, PlacedSetup, SimSetup, Truth};
use crate::physics::natural::normal_vector;
use nalgebra::Vector3;
use rand::{Rng, RngExt, SeedableRng};
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
                PlacedSetup { form_mm: self.form_mm(setup), ..mounted_by_hand(setup, &mut rng) }
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

/// Where a station or a foot ends up, mm.
const STATION_MM: f64 = 1.0;
/// How far an artefact is off its place and how far it is turned.
const ARTEFACT_MM: f64 = 0.1;
const ARTEFACT_RAD: f64 = 300e-6;
/// Lengths of arms and zeros of their joints.
const ARM_MM: f64 = 0.05;
const JOINT_RAD: f64 = 500e-6;
/// Tilt of a beam or a mirror.
const TILT_RAD: f64 = 300e-6;
/// Radius of a stylus or a tool.
const RADIUS_MM: f64 = 5e-3;
/// Largest dead path, mm.
const DEAD_PATH_MM: f64 = 300.0;

/// How a person mounts an instrument: what is off about it.
fn mounted_by_hand(setup: &SimSetup, rng: &mut impl Rng) -> PlacedSetup {
    let setting_mm = normal_vector(rng) * SETTING_MM;
    let artefact = |rng: &mut _| (normal_vector(rng) * ARTEFACT_MM, normal_vector(rng) * ARTEFACT_RAD);
    match setup.instrument {
        Instrument::RTest | Instrument::BallBar { .. } => PlacedSetup::new(setup, setting_mm),
        Instrument::Length => {
            let zero_mm = rng.random_range(0.0..DEAD_PATH_MM);
            let own = Own { zero_mm, ..Own::default() };
            PlacedSetup { own, ..PlacedSetup::new(setup, normal_vector(rng) * STATION_MM) }
        }
        Instrument::Arm { .. } => {
            let (arms, joints): (Vector3<f64>, Vector3<f64>) = (normal_vector(rng), normal_vector(rng));
            let arms_mm = [arms.x * ARM_MM, arms.y * ARM_MM];
            let joints_rad = [joints.x * JOINT_RAD, joints.y * JOINT_RAD];
            let own = Own { arms_mm, joints_rad, ..Own::default() };
            PlacedSetup { own, ..PlacedSetup::new(setup, setting_mm) }
        }
        Instrument::Line { .. } => {
            let (beam_rad, mirror_rad) = (normal_vector(rng) * TILT_RAD, normal_vector(rng) * TILT_RAD);
            let zero_mm = rng.random_range(0.0..DEAD_PATH_MM);
            let own = Own { zero_mm, beam_rad, mirror_rad, ..Own::default() };
            PlacedSetup { own, ..PlacedSetup::new(setup, Vector3::zeros()) }
        }
        Instrument::Centre if setup.targets.is_empty() => PlacedSetup::new(setup, setting_mm),
        Instrument::Centre | Instrument::Face | Instrument::Cut => {
            let (setting_mm, turn_rad) = artefact(rng);
            let radius = if setup.instrument == Instrument::Centre { 0.0 } else { RADIUS_MM };
            let zero_mm = radius * normal_vector(rng).x;
            let own = Own { turn_rad, zero_mm, ..Own::default() };
            PlacedSetup { own, ..PlacedSetup::new(setup, setting_mm) }
        }
    }
}
