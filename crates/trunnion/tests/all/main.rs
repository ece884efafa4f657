//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod examples;
mod joined;
mod library;
mod linear;
mod nest;
mod one_answer;
mod plausible;
mod replayed;
mod values;
mod whole;
