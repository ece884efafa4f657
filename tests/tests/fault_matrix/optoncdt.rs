//! optoNCDT 1420: streams on its own, with a counter and a clock.

use crate::matrix::{Case, Cell, GapOf, Lost, Subject, Trouble};
use trunnion_acquire::DeviceState::{Absent, Failed, Silent, Streaming, Stuck, WrongDevice};
use trunnion_hil_sim::devices::optoncdt::{self, ProbeConfig};
use trunnion_hil_sim::devices::{DeviceClock, Fault};

const NOT_THERE: &str = "PORT is not there; plug it in or correct the port";
const SILENT: &str = "silent for * ms: PORT sends no values*";
const LOST: &str = "values lost on the line (counter jumped)*";

pub const SUBJECT: Subject = Subject {
    driver: "optoncdt",
    about: "optoNCDT 1420 on RS422",
    keys: "port = \"{port}\"\nrole = \"probe-1\"\nrange_mm = 2\n",
    start: |floor, _| {
        Box::pin(async move {
            let config = ProbeConfig::new(0, DeviceClock::steady(50.0, 20.0));
            optoncdt::spawn(floor.world, config, &floor.port, floor.origin, &[]).expect("a good setting")
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
            gap: GapOf::away(SILENT, 1.2),
            message: SILENT,
            ..Case::NONE
        },
        Trouble::Garbled => {
            Case { fault: Some(Fault::GarbleBytes { count: 40 }), gap: GapOf::counted(LOST), ..Case::NONE }
        }
        Trouble::WrongIdentity => Case {
            fault: Some(Fault::WrongIdentity),
            course: &[Silent, WrongDevice],
            gap: GapOf::away(SILENT, 0.2),
            message: "wrong device: found ILD1420-50 serial *, expected an optoNCDT 1320 or 1420 with range 2 mm; correct \
                      the port or the configuration",
            ..Case::NONE
        },
        Trouble::StuckValue => Case {
            fault: Some(Fault::StuckValue { duration_s: 4.0 }),
            course: &[Stuck, Streaming],
            gap: GapOf::without_value(None, "stuck at *", 3.0),
            message: "it is stuck: it has sent * for * s although it trembled before; check that the probe moves freely \
                      and that its display is not held",
            ..Case::TREMBLED
        },
        Trouble::OutOfRange => Case {
            fault: Some(Fault::OutOfRange { duration_s: 0.5 }),
            gap: GapOf::without_value(None, "no value: *target behind the measuring range*", 0.4),
            message: "it has no value: *target behind the measuring range*",
            ..Case::NONE
        },
        Trouble::CounterJump => Case {
            fault: Some(Fault::CounterJump { by: 77 }),
            gap: Some(GapOf { channel: None, reason: LOST, lost: Lost::Exactly(77), at_least_s: 0.0 }),
            ..Case::NONE
        },
        Trouble::ClockJump => Case {
            fault: Some(Fault::ClockJump { by_s: -0.4 }),
            after_s: 2.5,
            gap: GapOf::away(
                "its clock was set by -0.4* s; times of readings between are uncertain by that much",
                0.9,
            ),
            ..Case::NONE
        },
        Trouble::BusOff => return Cell::Cannot("it hangs on no bus"),
        Trouble::Restarted => {
            return Cell::Cannot(
                "it has no program to restart; switched off and on it is silent for a while",
            );
        }
        Trouble::ControllerGone => return Cell::Cannot("there is no controller behind it"),
    })
}
