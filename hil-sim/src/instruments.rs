//! What each instrument is in the virtual machine: one file each, one line here. Nothing is shared with `trunnion-instruments`, which
//! says what a fit expects of it.

mod ball_bar;
mod centre;
mod cross_grid;
mod cut;
mod face;
mod laser_tracker;
mod length;
mod level;
mod line;
mod on_artefact;
mod passive_arm;
mod r_test;
mod virtual_instrument;

pub(crate) use virtual_instrument::Poses;

use crate::truth::{PlacedSetup, SimSetup};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use trunnion_core::InstrumentKind;
use virtual_instrument::{Seen, VirtualInstrument};

/// Every kind of instrument, one or several kinds a line.
static REGISTRY: &[&VirtualInstrument] = &[
    &r_test::INSTRUMENT,
    &ball_bar::INSTRUMENT,
    &length::INSTRUMENT,
    &laser_tracker::INSTRUMENT,
    &passive_arm::INSTRUMENT,
    &cross_grid::INSTRUMENT,
    &level::INSTRUMENT,
    &line::INSTRUMENT,
    &centre::INSTRUMENT,
    &face::INSTRUMENT,
    &cut::INSTRUMENT,
];

fn of(kind: InstrumentKind) -> &'static VirtualInstrument {
    let mut all = REGISTRY.iter().copied();
    all.find(|instrument| instrument.kinds.contains(&kind)).expect("every kind is registered (tested)")
}

/// How a person mounts an instrument, from the offset of ball against nest: what is off about it.
pub(crate) fn mounted_by_hand(
    setup: &SimSetup,
    setting_mm: Vector3<f64>,
    rng: &mut ChaCha8Rng,
) -> PlacedSetup {
    (of(setup.instrument.kind).mounted)(setup, setting_mm, rng)
}

/// Noise-free reading, mm.
pub(crate) fn read_mm(placed: &PlacedSetup, target: usize, poses: &Poses) -> [f64; 3] {
    (of(placed.setup.instrument.kind).reading)(&Seen::new(placed, target, poses))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_instrument_is_registered_once() {
        for (name, kind) in InstrumentKind::NAMES {
            let count = REGISTRY.iter().filter(|instrument| instrument.kinds.contains(&kind)).count();
            assert_eq!(
                count, 1,
                "{name}: add it to the `kinds` of the file in hil-sim/src/instruments that reads the same, or write one and its line in \
                 REGISTRY of hil-sim/src/instruments.rs"
            );
        }
    }
}
