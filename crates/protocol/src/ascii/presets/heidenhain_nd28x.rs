//! Heidenhain ND 280, ND 281, ND 287 position display.

use crate::ascii::decoder::Unit;
use crate::ascii::preset::{Preset, Stamp};

pub(super) const PRESET: Preset = Preset {
    name: "heidenhain-nd28x",
    about: "Heidenhain ND 280, ND 281, ND 287 position display",
    source: "ND 287 user's manual, \"Measured value output\"",
    unconfirmed: "",
    request: "\x02",
    pattern: "{value} {unit} *",
    unit: Unit::Millimetre,
    printed: &[
        // "Example: order of the measured value output", X = -5.23 mm, sorted (=), actual value of a series (A).
        ("-      5.23  =A", "-5.23", Unit::Millimetre),
        ("+    1.2345 \"  ", "1.2345", Unit::Inch),
    ],
    errors: &[("?", "the display shows a fault; clear it at the display")],
    baud: 9600,
    framing: "7E2",
    stamp: Stamp::Request,
    poll_ms: 100.0,
    may_be_asked: true,
    identity: ("\x1bA0000\r", &["ND"]),
    width: 11,
    decimals: 4,
};
