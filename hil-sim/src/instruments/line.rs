//! Laser interferometer along a line of the machine: along the beam, or what a tilted flat mirror reflects [S2 §3.2].

use super::length::DEAD_PATH_MM;
use super::virtual_instrument::VirtualInstrument;
use crate::physics::natural::normal_vector;
use crate::truth::{Own, PlacedSetup};
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use trunnion_core::InstrumentKind;

/// Tilt of a beam or a mirror.
const TILT_RAD: f64 = 300e-6;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::Diagonal, InstrumentKind::StepDiagonal],
    mounted: |setup, _, rng| {
        let (beam_rad, mirror_rad) = (normal_vector(rng) * TILT_RAD, normal_vector(rng) * TILT_RAD);
        let zero_mm = rng.random_range(0.0..DEAD_PATH_MM);
        let own = Own { zero_mm, beam_rad, mirror_rad, ..Own::default() };
        PlacedSetup { own, ..PlacedSetup::new(setup, Vector3::zeros()) }
    },
    reading: |seen| {
        let (own, instrument) = (&seen.placed.own, &seen.placed.setup.instrument);
        let direction = instrument.direction.normalize();
        let beam = Rotation3::from_scaled_axis(own.beam_rad) * direction;
        let normal = Rotation3::from_scaled_axis(own.mirror_rad) * direction;
        let along = match instrument.kind {
            InstrumentKind::StepDiagonal => normal.dot(&seen.apart) / normal.dot(&beam),
            _ => beam.dot(&seen.apart),
        };
        [along - own.zero_mm, 0.0, 0.0]
    },
};
