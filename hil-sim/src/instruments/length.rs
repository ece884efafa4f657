//! A length from the table to the tool with an arbitrary zero (tracking interferometer, laser ball bar, leg):
//! `|p_tool − p_table| − zero` [S2 eq. 8].

use super::virtual_instrument::VirtualInstrument;
use crate::physics::natural::normal_vector;
use crate::truth::{Own, PlacedSetup};
use rand::RngExt;
use trunnion_core::InstrumentKind;

/// Where a station or a foot ends up, mm.
pub(super) const STATION_MM: f64 = 1.0;
/// Largest dead path, mm.
pub(super) const DEAD_PATH_MM: f64 = 300.0;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::Tracker, InstrumentKind::LaserBallBar],
    mounted: |setup, _, rng| {
        let zero_mm = rng.random_range(0.0..DEAD_PATH_MM);
        let own = Own { zero_mm, ..Own::default() };
        PlacedSetup { own, ..PlacedSetup::new(setup, normal_vector(rng) * STATION_MM) }
    },
    reading: |seen| [seen.apart.norm() - seen.placed.own.zero_mm, 0.0, 0.0],
};
