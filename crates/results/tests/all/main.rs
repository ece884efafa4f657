//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

#[path = "../../../../tests/src/json_schema.rs"]
mod json_schema;
mod round_trip;
mod schemas;
