//! Ball bar: `|p_tool − p_table| − L`.

use super::virtual_instrument::VirtualInstrument;
use crate::truth::PlacedSetup;
use trunnion_core::InstrumentKind;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::BallBar],
    mounted: |setup, setting_mm, _| PlacedSetup::new(setup, setting_mm),
    reading: |seen| [seen.apart.norm() - seen.placed.setup.instrument.length_mm, 0.0, 0.0],
};
