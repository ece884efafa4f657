//! Magnescale LT20A, LT30 display unit, channel A.

use crate::ascii::decoder::Unit;
use crate::ascii::preset::{Preset, Stamp};

pub(super) const PRESET: Preset = Preset {
    name: "magnescale-lt30",
    about: "Magnescale LT20A, LT30 display unit, channel A",
    source: "LT20A/LT30 instruction manual, \"The output data format\"",
    unconfirmed: "the request, line speed and framing",
    request: "R\r\n",
    pattern: "A{value} *",
    unit: Unit::Millimetre,
    printed: &[("A+12.3456", "12.3456", Unit::Millimetre)],
    errors: &[
        ("+F", "beyond the digits of the display"),
        ("-F", "beyond the digits of the display"),
        ("AE", "alarm: gauge moved too fast or not connected; reset the display"),
    ],
    baud: 9600,
    framing: "8N1",
    stamp: Stamp::Between,
    poll_ms: 50.0,
    may_be_asked: false,
    identity: ("", &[]),
    width: 8,
    decimals: 4,
};
