//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod any_calls;
mod attempts;
mod caller;
mod calls_table;
mod mtconnect;
mod opcua;
mod page;
mod plots;
mod runs_of_a_service;
#[allow(dead_code, reason = "the tests of this crate use a part")]
#[path = "../../../../tests/src/section.rs"]
mod section;
mod sparkplug;
