//! A CANopen probe (CiA 404) behind an slcan adapter: asked by SYNC, so that the host counts what is missing.

use super::common::some;
use super::matrix::{Case, Cell, Kind, Subject, Trouble};
use trunnion_acquire::DeviceState::{Failed, Silent, Streaming, WrongDevice};
use trunnion_hil_sim::devices::canopen::BusConfig;
use trunnion_hil_sim::devices::{DeviceClock, Fault, canopen};

const OUT_OF_RANGE: &str = "the node calls its value above the measuring range (status 6150h = 03h); bring it back into the range, or check \
                            the sensor and its cable";

pub const SUBJECT: Subject = Subject {
    driver: "canopen-slcan",
    about: "CiA 404 probe behind an slcan adapter",
    keys: "port = \"{port}\"\nnodes = [{ id = 1, role = \"probe-1\" }]\n",
    start: |floor, _| {
        Box::pin(async move {
            let mut config = BusConfig::ball_bar_and_probes(DeviceClock::steady(5.0, 20.0));
            // Another node takes the place of the first.
            config.nodes.retain(|node| node.id.get() == 1);
            canopen::spawn(floor.world, &config, &floor.port, floor.origin, &[]).expect("a good setting")
        })
    },
    kind: Kind::Serial,
    own,
};

fn own(trouble: Trouble) -> Option<Cell> {
    some(match trouble {
        Trouble::Silent => Case::silent(1.5, "silent for * ms: node 1 sends no values*"),
        Trouble::Garbled => Case::lost(Fault::GarbleBytes { count: 120 }, "node 1 missed SYNCs*"),
        Trouble::WrongIdentity => Case::another(
            &[Failed, WrongDevice],
            "restarted: node 1 is *",
            "wrong device: *I/O module*expected *CiA 404 or CiA 406*; correct the port or the configuration",
        ),
        Trouble::StuckValue => Case::stuck(Some("node-1"), 400),
        Trouble::OutOfRange => Case::out_of_range(Some("node-1"), OUT_OF_RANGE),
        Trouble::BusOff => Case {
            perhaps: Some((Silent, "the node is missed before the adapter reports its state")),
            ..Case::away(
                Fault::BusOff { duration_s: 2.0 },
                &[Failed, Streaming],
                "disconnected: *check cable, both 120 Ω terminators, the bit rate, and that a node is switched on*",
                1.5,
            )
        },
        Trouble::Restarted => {
            return Some(Cell::Cannot(
                "a node that restarts reports it on the bus, as the node under \"wrong identity\" does",
            ));
        }
        _ => return None,
    })
}
