//! Our SocketCAN driver on an emulated computer with a real kernel: a bus without hardware, two emulated cards, and the
//! kernel's own slcan driver with nodes of python `canopen` at the other end of its line.

use std::process::Command;
use trunnion_tests::alignment::{HEAD, SOCKETCAN};
use trunnion_tests::peer::PythonPeer;
use trunnion_tests::section::{is_writing, write_or_compare};
use trunnion_tests::workspace_root;

/// Boots, runs the trial in this mode, and prints the figures it measured; all it printed.
fn machine(mode: &str, peer_tty: Option<&str>) -> String {
    let mut command = Command::new(workspace_root().join("tests/peers/can_machine.sh"));
    command.args([mode, env!("CARGO_BIN_EXE_can-guest")]);
    if let Some(tty) = peer_tty {
        command.env("PEER_TTY", tty);
    }
    let reported = command.output().expect("the script runs");
    let text = String::from_utf8_lossy(&reported.stdout).into_owned();
    for line in text.lines().filter(|line| line.contains("FIGURES")) {
        println!("{line}");
    }
    assert!(reported.status.success(), "{text}\n{}", String::from_utf8_lossy(&reported.stderr));
    text
}

/// Writes the line into docs/measured/alignment.md when TRUNNION_WRITE_DOCS is set.
fn alignment_line(line: &str) {
    println!("{line}");
    if is_writing() {
        write_or_compare("docs/measured/alignment.md", SOCKETCAN, &format!("{HEAD}{line}\n"));
    }
}

#[test]
#[ignore = "a peer test: tests/peers/run"]
fn readings_keep_the_stamps_of_the_kernel_and_whatever_happens_to_the_interface_is_reported_and_mended() {
    let reported = machine("vcan", None);
    let rows: Vec<&str> =
        reported.lines().filter_map(|line| Some(line.split_once("FAULT ")?.1.trim_end())).collect();
    let head = "| fault | state | recorded gap | readings missing | message |\n|---|---|---|---|---|\n";
    let table = format!("{head}{}\n", rows.join("\n"));
    write_or_compare("docs/measured/faults.md", SOCKETCAN, &table);
}

#[test]
#[ignore = "a peer test: tests/peers/run"]
fn two_cards_on_one_bus_give_readings_and_a_pulled_cable_is_a_gap() {
    let reported = machine("kvaser", None);
    // The firmware leaves the first line unfinished.
    let line = reported.lines().find_map(|line| line.split_once("ALIGNMENT "));
    let (_, line) = line.expect("the trial reports the errors in time");
    alignment_line(line);
}

#[test]
#[ignore = "a peer test: tests/peers/run"]
fn python_nodes_behind_the_slcan_driver_of_the_kernel_are_read() {
    let peer = PythonPeer::start("canopen_peer.py", &["--raw".as_ref()]);
    machine("slcan", Some(&peer.port()));
}
