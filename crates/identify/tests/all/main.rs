//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod axis_errors;
mod ball_bar;
mod certification;
mod circular;
mod common;
mod error_map;
mod geometry;
mod intervals;
mod methods;
mod mishaps;
mod nothing_hidden;
mod single_error_tables;
