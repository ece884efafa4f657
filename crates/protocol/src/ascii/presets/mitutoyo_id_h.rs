//! Mitutoyo ID-H0530, ID-H0560 indicator on RS-232C.

use crate::ascii::decoder::Unit;
use crate::ascii::preset::{Preset, Stamp};

pub(super) const PRESET: Preset = Preset {
    name: "mitutoyo-id-h",
    about: "Mitutoyo ID-H0530, ID-H0560 indicator on RS-232C",
    source: "ID-H0530/0560 user's manual No. 99MAH016B, §4.2.4",
    unconfirmed: "line speed and framing are set at the indicator",
    request: "GA00\r\n",
    pattern: "G?##,{value}",
    unit: Unit::Millimetre,
    printed: &[
        ("GN00,+0016.2345", "16.2345", Unit::Millimetre),
        ("GM07,-0016.2345", "-16.2345", Unit::Millimetre),
    ],
    errors: &[("ER", "the indicator reports an error")],
    baud: 9600,
    framing: "7E2",
    stamp: Stamp::Between,
    poll_ms: 100.0,
    may_be_asked: true,
    identity: ("", &[]),
    width: 10,
    decimals: 4,
};
