//! Tests against implementations of others, which tests/peers/run installs; without it they are ignored.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod canopen;
#[path = "../../../crates/cycles/tests/all/nc/interpreter.rs"]
#[expect(dead_code, reason = "LinuxCNC interprets here")]
mod interpreter;
mod linuxcnc;
mod linuxcnc_cell;
mod linuxcnc_correct;
mod linuxcnc_moves;
mod linuxcnc_process;
mod mcap;
mod mosquitto;
mod mosquitto_choice;
mod mosquitto_slow;
mod opcua;
mod opcua_results;
mod shdr;
mod socketcan;
mod sparkplug;
#[path = "../../../crates/cycles/tests/all/nc/visited.rs"]
mod visited;
