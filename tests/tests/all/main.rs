//! Live runs on virtual devices, named methods against known truths, and the map of the crates.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod bar_zero;
mod bars_live;
mod circles;
mod citations;
mod convergence;
mod cycle_boundaries;
mod cycle_program;
mod cycles_in_service;
mod edges;
mod empty_sweeps;
mod fault_matrix;
mod fuzzed;
mod glossary;
mod house;
#[path = "../../../crates/cycles/tests/all/nc/interpreter.rs"]
mod interpreter;
mod licences;
mod load;
mod many_cycles;
mod named_methods;
mod nc_program_measured;
mod nest_uncertainty;
mod opcua_controller;
mod opcua_replies;
mod plausible_runs;
mod prediction_bands;
mod schemes;
mod service;
mod stalled_broker;
