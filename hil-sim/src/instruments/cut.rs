//! Surface left by a tool in the spindle, measured elsewhere along its normal.

use super::on_artefact::{RADIUS_MM, placed};
use super::virtual_instrument::VirtualInstrument;
use trunnion_core::InstrumentKind;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::MachinedSurface],
    mounted: |setup, _, rng| placed(setup, RADIUS_MM, rng),
    reading: |seen| [seen.normal.dot(&seen.apart) - seen.placed.own.zero_mm, 0.0, 0.0],
};
