//! Three gauges behind a DL-RS1A box: polled, without counter or clock of its own.

use super::common::some;
use super::matrix::{Case, Cell, Kind, Subject, Trouble};
use trunnion_acquire::DeviceState::{Failed, WrongDevice};
use trunnion_hil_sim::devices::keyence::BoxConfig;
use trunnion_hil_sim::devices::{Fault, keyence};

const SILENT: &str = "silent for * ms: PORT does not answer M0; check that it is switched on, its cable, and that this is its port";

pub const SUBJECT: Subject = Subject {
    driver: "keyence-dl-rs1a",
    about: "three GT2-70 gauges behind a DL-RS1A box",
    keys: "port = \"{port}\"\nbaud = 38400\nheads = [{ head = 1, role = \"probe-1\" }, \
           { head = 2, role = \"probe-2\" }, { head = 3, role = \"probe-3\" }]\n",
    start: |floor, _| {
        Box::pin(async move {
            let config = BoxConfig::three_gauges();
            keyence::spawn(floor.world, config, &floor.port, floor.origin, &[]).expect("a good setting")
        })
    },
    kind: Kind::Serial,
    own,
};

fn own(trouble: Trouble) -> Option<Cell> {
    some(match trouble {
        Trouble::Silent => Case::silent(2.5, SILENT),
        Trouble::Garbled => {
            Case::lost(Fault::GarbleBytes { count: 20 }, "replies of the box were missing or damaged*")
        }
        Trouble::WrongIdentity => Case::another(
            &[Failed, WrongDevice],
            "restarted: the box had 3 amplifiers and now has 1",
            "wrong device: found Keyence DL-RS1A with 1 amplifiers GT2-70, expected a box with head 2 (probe-2); correct \
             the port or the configuration",
        ),
        Trouble::StuckValue => Case::stuck(Some("head-1"), 3 * 400),
        Trouble::OutOfRange => Case::out_of_range(
            Some("head-1"),
            "+999.9998 is a state of the amplifier and no position: no signal from the head: check its cable and that it \
             is the head of this amplifier",
        ),
        _ => return None,
    })
}
