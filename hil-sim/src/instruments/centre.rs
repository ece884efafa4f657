//! Centre of a ball found by a probe in the spindle: measured minus nominal, machine axes.

use super::on_artefact;
use super::virtual_instrument::VirtualInstrument;
use crate::truth::PlacedSetup;
use trunnion_core::InstrumentKind;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::BallPlate, InstrumentKind::TouchProbe],
    mounted: |setup, setting_mm, rng| match setup.targets.is_empty() {
        true => PlacedSetup::new(setup, setting_mm),
        false => on_artefact::placed(setup, 0.0, rng),
    },
    reading: |seen| (-seen.apart).into(),
};
