//! Sylvac gauge or display on Opto-RS232 (also Käfer, Bowers, Trimos).

use crate::ascii::decoder::Unit;
use crate::ascii::preset::{Preset, Stamp};

pub(super) const PRESET: Preset = Preset {
    name: "sylvac",
    about: "Sylvac gauge or display on Opto-RS232 (also Käfer, Bowers, Trimos)",
    source: "Sylvac \"User's manual for OPTO-RS cable connections\"",
    unconfirmed: "",
    request: "?\r",
    pattern: "{value}",
    unit: Unit::Millimetre,
    printed: &[("+00.0000", "0.0000", Unit::Millimetre), (" 0123.456", "123.456", Unit::Millimetre)],
    errors: ERRORS,
    baud: 4800,
    framing: "7E2",
    stamp: Stamp::Between,
    poll_ms: 100.0,
    may_be_asked: true,
    identity: ("ID?\r", &["SY"]),
    width: 8,
    decimals: 4,
};

/// Words of the Opto-RS232 protocol.
const ERRORS: &[(&str, &str)] = &[
    ("ERR0", "the gauge lost its count: moved too fast, or its scale is dirty; reset it"),
    ("ERR1", "the gauge does not know the command"),
    ("ERR2", "the gauge got a damaged byte; check the cable and the framing"),
    ("ERR3", "outside the measuring range"),
    ("ERR", "the gauge reports an error"),
];
