//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod canopen_startup;
mod codecs;
mod fuzz;
mod linuxcncrsh_lines;
mod mtconnect_documents;
mod presets;
#[allow(dead_code, reason = "the tests of this crate use a part")]
#[path = "../../../../tests/src/section.rs"]
mod section;
