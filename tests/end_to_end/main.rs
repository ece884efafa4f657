//! The program `trunnion` from end to end, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod attribute;
mod bad_input;
mod combined;
mod compensation;
mod demo;
mod devices;
mod hybrid;
mod long_lists;
mod methods;
mod nc_program;
mod outside_data;
mod plan;
mod program;
mod record;
mod schemes;
mod setting_up;
mod story;
mod streams;
mod volumetric;
