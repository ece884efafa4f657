//! Magnescale MG80 unit, one channel.

use crate::ascii::decoder::Unit;
use crate::ascii::preset::{Preset, Stamp};

pub(super) const PRESET: Preset = Preset {
    name: "magnescale-mg80",
    about: "Magnescale MG80 unit, one channel",
    source: "",
    unconfirmed: "the request, the line, its speed and framing",
    request: "R\r\n",
    pattern: "{value}",
    unit: Unit::Millimetre,
    printed: &[],
    errors: &[("E", "the unit reports an error")],
    baud: 9600,
    framing: "8N1",
    stamp: Stamp::Between,
    poll_ms: 50.0,
    may_be_asked: false,
    identity: ("", &[]),
    width: 9,
    decimals: 4,
};
