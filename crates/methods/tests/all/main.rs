//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod attribution;
mod axis_errors;
mod ball_bar;
mod certification;
mod circular;
mod circular_guides;
mod circular_rows;
mod circular_zeros;
#[allow(dead_code, reason = "the tests of this crate use a part")]
#[path = "../../../engine/tests/all/common.rs"]
mod common;
mod density;
mod empty_runs;
mod error_map;
mod error_map_tilting;
mod geometry;
mod methods;
mod multilateration;
mod positioning;
mod quasi_static;
mod rotary_values;
mod roundness;
mod thermal;
mod two_height;
