//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod advice;
mod aliases;
mod all_clear;
mod beam_tilts;
mod channels;
mod common;
mod excluded_points;
mod heads;
mod held_out;
mod intervals;
mod linear_axes;
mod lines;
mod nothing_hidden;
mod null;
mod offsets;
mod outside_data;
mod probes;
mod repeats;
mod robot;
mod scatter;
mod shares;
mod single_error_tables;
mod spectrum;
