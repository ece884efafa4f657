//! TESA TT80 (TT90 with unit = "um").

use crate::ascii::decoder::Unit;
use crate::ascii::preset::{Preset, Stamp};

pub(super) const PRESET: Preset = Preset {
    name: "tesa",
    about: "TESA TT80 (TT90 with unit = \"um\")",
    source: "TT80/TT90 manual §11, \"Functions accessible through the RS232 interface\"",
    unconfirmed: "",
    request: "?\r",
    pattern: "{value}",
    unit: Unit::Millimetre,
    printed: &[("-1234.56", "-1234.56", Unit::Millimetre)],
    errors: &[("ERR", "the instrument reports an error; its manual lists the number")],
    baud: 4800,
    framing: "7E2",
    stamp: Stamp::Between,
    poll_ms: 100.0,
    may_be_asked: true,
    identity: ("ID?\r", &["TE"]),
    width: 8,
    decimals: 2,
};
