//! Keyence DL-RS1A: RS-232 box in front of up to 15 sensor amplifiers (GT2-70, GT-70A, IG).
//!
//! Everything is a line of ASCII; the host asks, the box answers with the same two letters. Commands end with CR or
//! CR LF, answers with CR LF.
//!
//! | host | box | |
//! |---|---|---|
//! | `M0` | `M0,<value of amplifier 00>,…,<value of the last>` | all values at once |
//! | `SR,ii,nnn` | `SR,ii,nnn,<data>` | data number nnn of amplifier ii |
//! | anything wrong | `ER,<command>,ee` | ee says why |
//!
//! A value is a sign, digits and a point; the number of digits shows the kind of amplifier: `±***.****` GT2-70 (outside
//! ±199.9999 it is a state and no position), `±***.***` GT-70A (−99.999…+999.999), `±**.***` IG (±99.999).
//! Data number 006 is the error state of an amplifier, five decimal digits whose bits are causes.
//! The box refreshes its values every 13 ms with three amplifiers, so a value is older than the reply by up to that.
//! Source: DL-RS1A user's manuals (GT2-70, GT-70A, IG), "Commands and Responses", "Data numbers", "Error numbers".

mod command;
mod reply;
mod value;

pub use command::{Command, CommandDecoder};
pub use reply::{Decoder, Refusal, Reply};
pub use value::{AmplifierFaults, ERROR_STATE, Family, MOST_AMPLIFIERS, Value};
