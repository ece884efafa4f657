//! A CANopen probe (CiA 404) behind an slcan adapter: asked by SYNC, so that the host counts what is missing.

use crate::matrix::{Case, Cell, GapOf, Subject, Trouble};
use trunnion_acquire::DeviceState::{Absent, Failed, Silent, Streaming, Stuck, WrongDevice};
use trunnion_hil_sim::devices::canopen::{self, BusConfig};
use trunnion_hil_sim::devices::{DeviceClock, Fault};

const NOT_THERE: &str = "PORT is not there; plug it in or correct the port";

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
    cell,
};

fn cell(trouble: Trouble) -> Cell {
    Cell::Case(match trouble {
        Trouble::AbsentAtStart => Case {
            course: &[Absent, Streaming],
            gap: GapOf::away(NOT_THERE, 0.0),
            message: NOT_THERE,
            ..Case::NONE
        },
        Trouble::Unplugged => Case {
            fault: Some(Fault::Unplug { duration_s: 1.5 }),
            course: &[Failed, Absent, Streaming],
            gap: GapOf::away("disconnected: *", 1.2),
            message: "disconnected: *",
            ..Case::NONE
        },
        Trouble::Silent => Case {
            fault: Some(Fault::Silence { duration_s: 1.5 }),
            course: &[Silent, Streaming],
            gap: GapOf::away("silent for * ms: node 1 sends no values*", 1.2),
            message: "silent for * ms: node 1 sends no values*",
            ..Case::NONE
        },
        Trouble::Garbled => Case {
            fault: Some(Fault::GarbleBytes { count: 120 }),
            gap: GapOf::counted("node 1 missed SYNCs*"),
            ..Case::NONE
        },
        Trouble::WrongIdentity => Case {
            fault: Some(Fault::WrongIdentity),
            course: &[Failed, WrongDevice],
            gap: GapOf::away("restarted: node 1 is *", 0.2),
            message: "wrong device: *I/O module*expected *CiA 404 or CiA 406*; correct the port or the configuration",
            ..Case::NONE
        },
        Trouble::StuckValue => Case {
            fault: Some(Fault::StuckValue { duration_s: 4.0 }),
            course: &[Stuck, Streaming],
            gap: GapOf::without_value(Some("node-1"), "stuck at *", 3.0),
            message: "it.node-1 is stuck: it has sent * for * s although it trembled before; check that the probe moves \
                      freely and that its display is not held",
            ..Case::TREMBLED
        },
        Trouble::OutOfRange => Case {
            fault: Some(Fault::OutOfRange { duration_s: 0.8 }),
            gap: GapOf::without_value(Some("node-1"), "no value: *", 0.5),
            message: "it.node-1 has no value: *",
            ..Case::NONE
        },
        Trouble::BusOff => Case {
            fault: Some(Fault::BusOff { duration_s: 2.0 }),
            course: &[Failed, Silent, Streaming],
            gap: GapOf::away(
                "*check cable, both 120 Ω terminators, the bit rate, and that a node is switched on*",
                1.5,
            ),
            message: "*check cable, both 120 Ω terminators, the bit rate, and that a node is switched on*",
            ..Case::NONE
        },
        Trouble::CounterJump => {
            return Cell::Cannot("it does not count its measurements; missing answers are counted");
        }
        Trouble::ClockJump => return Cell::Cannot("it has no clock; the computer's stamps its answers"),
        Trouble::Restarted => {
            return Cell::Cannot(
                "a node that starts anew says so on the bus, as the node under \"wrong identity\" does",
            );
        }
        Trouble::ControllerGone => return Cell::Cannot("there is no controller behind it"),
    })
}
