//! Three gauges behind a DL-RS1A box: polled, without counter or clock of its own.

use crate::matrix::{Case, Cell, GapOf, Subject, Trouble};
use trunnion_acquire::DeviceState::{Absent, Failed, Silent, Streaming, Stuck, WrongDevice};
use trunnion_hil_sim::devices::Fault;
use trunnion_hil_sim::devices::keyence::{self, BoxConfig};

const NOT_THERE: &str = "PORT is not there; plug it in or correct the port";
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
            fault: Some(Fault::Silence { duration_s: 2.5 }),
            course: &[Silent, Streaming],
            gap: GapOf::away(SILENT, 2.0),
            message: SILENT,
            ..Case::NONE
        },
        Trouble::Garbled => Case {
            fault: Some(Fault::GarbleBytes { count: 20 }),
            gap: GapOf::counted("replies of the box were missing or damaged*"),
            ..Case::NONE
        },
        Trouble::WrongIdentity => Case {
            fault: Some(Fault::WrongIdentity),
            course: &[Failed, WrongDevice],
            gap: GapOf::away("restarted: the box had 3 amplifiers and now has 1", 0.2),
            message: "wrong device: found Keyence DL-RS1A with 1 amplifiers GT2-70, expected a box with head 2 (probe-2); \
                      correct the port or the configuration",
            ..Case::NONE
        },
        Trouble::StuckValue => Case {
            fault: Some(Fault::StuckValue { duration_s: 4.0 }),
            after_readings: 3 * 400,
            course: &[Stuck, Streaming],
            gap: GapOf::without_value(Some("head-1"), "stuck at *", 3.0),
            message: "it.head-1 is stuck: it has sent * for * s although it trembled before; check that the probe moves \
                      freely and that its display is not held",
            ..Case::TREMBLED
        },
        Trouble::OutOfRange => Case {
            fault: Some(Fault::OutOfRange { duration_s: 0.8 }),
            gap: GapOf::without_value(Some("head-1"), "no value: *", 0.5),
            message: "head 1: no signal from the head*",
            ..Case::NONE
        },
        Trouble::CounterJump => {
            return Cell::Cannot("it does not count its measurements; missing answers are counted");
        }
        Trouble::ClockJump => return Cell::Cannot("it has no clock; the computer's stamps its answers"),
        Trouble::BusOff => return Cell::Cannot("it hangs on no bus"),
        Trouble::Restarted => {
            return Cell::Cannot(
                "it has no program to restart; switched off and on it is silent for a while",
            );
        }
        Trouble::ControllerGone => return Cell::Cannot("there is no controller behind it"),
    })
}
