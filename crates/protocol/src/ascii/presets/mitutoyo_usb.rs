//! Mitutoyo gauge on a USB input tool, talking on its own.

use crate::ascii::decoder::Unit;
use crate::ascii::preset::{Preset, Stamp};

pub(super) const PRESET: Preset = Preset {
    name: "mitutoyo-usb",
    about: "Mitutoyo gauge on a USB input tool, talking on its own",
    source: "QM-Height user's manual No. 99MAF600B, §6.2.2",
    unconfirmed: "the answers 911 and 912 of an input tool",
    request: "",
    pattern: "01A{value}",
    unit: Unit::Millimetre,
    printed: &[("01A+0000.123", "0.123", Unit::Millimetre), ("01A+0000.125", "0.125", Unit::Millimetre)],
    errors: &[
        ("911", "no gauge at the input tool"),
        ("912", "the gauge sends what the input tool cannot read"),
    ],
    baud: 9600,
    framing: "8N1",
    stamp: Stamp::Arrival,
    poll_ms: 100.0,
    may_be_asked: true,
    identity: ("", &[]),
    width: 9,
    decimals: 3,
};
