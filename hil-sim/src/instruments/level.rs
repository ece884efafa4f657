//! Level or autocollimator: turn of the tool against the table about one direction, µm at the end of one metre, any zero. Rotary axes
//! are at zero, where both attitudes are nominally those of the machine.

use super::virtual_instrument::VirtualInstrument;
use crate::truth::{Own, PlacedSetup};
use nalgebra::Vector3;
use rand::RngExt;
use trunnion_core::InstrumentKind;

/// Largest zero, mm at one metre.
const ZERO_MM: f64 = 0.2;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::Level],
    mounted: |setup, _, rng| {
        let own = Own { zero_mm: rng.random_range(0.0..ZERO_MM), ..Own::default() };
        PlacedSetup { own, ..PlacedSetup::new(setup, Vector3::zeros()) }
    },
    reading: |seen| {
        let poses = seen.poses;
        let turn = poses.machine_from_tool.rotation * poses.machine_from_table.rotation.inverse();
        let about = seen.placed.setup.instrument.direction.normalize();
        [1000.0 * about.dot(&turn.scaled_axis()) - seen.placed.own.zero_mm, 0.0, 0.0]
    },
};
