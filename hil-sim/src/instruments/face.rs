//! Face found by a probe in the spindle: measured minus nominal along its normal.

use super::on_artefact::{RADIUS_MM, placed};
use super::virtual_instrument::VirtualInstrument;
use trunnion_core::InstrumentKind;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::TouchProbeFace],
    mounted: |setup, _, rng| placed(setup, RADIUS_MM, rng),
    reading: |seen| [seen.placed.own.zero_mm - seen.normal.dot(&seen.apart), 0.0, 0.0],
};
