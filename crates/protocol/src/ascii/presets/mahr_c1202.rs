//! Mahr Millimar C 1202, feature 1.

use crate::ascii::decoder::Unit;
use crate::ascii::preset::{Preset, Stamp};

pub(super) const PRESET: Preset = Preset {
    name: "mahr-c1202",
    about: "Mahr Millimar C 1202, feature 1",
    source: "Millimar C 1202 manual §7.2, \"C1202 Duplex interface\"",
    unconfirmed: "",
    request: "M1?\r",
    pattern: "# {value} {unit} *",
    unit: Unit::Millimetre,
    printed: &[
        ("1 +003.25 um <", "3.25", Unit::Micrometre),
        ("1 -000.125 mm = =", "-0.125", Unit::Millimetre),
    ],
    errors: &[
        ("ERR6", "feature 1 is switched off at the instrument"),
        ("ERR", "the instrument reports an error"),
    ],
    baud: 9600,
    framing: "7E2",
    stamp: Stamp::Between,
    poll_ms: 100.0,
    may_be_asked: true,
    identity: ("DES?\r", &["1 C1202"]),
    width: 8,
    decimals: 4,
};
