//! Indicators and counters that say their value as a line of ASCII: one codec, and a [`Preset`] for each kind.
//!
//! Some are asked (a few bytes), some talk on their own. What a line looks like is a [`Pattern`]; what a device says
//! instead of a value is a list of words with their meanings. A 7-bit format has its parity bit taken away here,
//! because not every port does it.

mod decoder;
mod pattern;
mod preset;
mod presets;

pub use decoder::{Decoder, Format, Line, Measured, Unit};
pub use pattern::{Number, Pattern, PatternError};
pub use preset::{Preset, Stamp};
pub use presets::PRESETS;
