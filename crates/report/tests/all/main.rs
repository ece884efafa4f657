//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod all_clear;
mod certificate;
mod compensation_formats;
mod doubts;
mod filed;
mod language;
mod pages;
#[allow(dead_code, reason = "the tests of this crate use a part")]
#[path = "../../../../tests/src/section.rs"]
mod section;
mod to_do;
