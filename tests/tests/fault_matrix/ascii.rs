//! An indicator that says a value as a line, here the preset `mahr-c1202`; all presets share one driver.

use crate::matrix::{Case, Cell, GapOf, Subject, Trouble};
use trunnion_acquire::DeviceState::{Absent, Failed, Silent, Streaming, Stuck, WrongDevice};
use trunnion_hil_sim::devices::Fault;
use trunnion_hil_sim::devices::ascii::{self, IndicatorConfig, Sees};
use trunnion_protocol::ascii::Preset;

const NOT_THERE: &str = "PORT is not there; plug it in or correct the port";
const SILENT: &str = "silent for * ms: PORT does not answer *; check that it is switched on, its cable, and that this is its port";

pub const SUBJECT: Subject = Subject {
    driver: "ascii",
    about: "Mahr Millimar C 1202, as all presets",
    keys: "port = \"{port}\"\nsilence_ms = 1500\npoll_ms = 20\npreset = \"mahr-c1202\"\nrole = \"probe-1\"\n",
    start: |floor, _| {
        Box::pin(async move {
            let preset = *Preset::named("mahr-c1202").expect("a preset");
            let config = IndicatorConfig { answer_s: 0.015, ..IndicatorConfig::new(Sees::Probe(0), preset) };
            ascii::spawn(floor.world, config, &floor.port, floor.origin, &[]).expect("a good setting")
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
            fault: Some(Fault::GarbleBytes { count: 10 }),
            gap: GapOf::counted("answers were missing or damaged*"),
            ..Case::NONE
        },
        Trouble::WrongIdentity => Case {
            fault: Some(Fault::WrongIdentity),
            course: &[Silent, WrongDevice],
            gap: GapOf::away("silent for * ms: PORT does not answer *", 0.5),
            message: "wrong device: found a device that says \"HELLO 17\", expected *; correct the port or the \
                      configuration",
            ..Case::NONE
        },
        Trouble::StuckValue => Case {
            fault: Some(Fault::StuckValue { duration_s: 4.0 }),
            course: &[Stuck, Streaming],
            gap: GapOf::without_value(None, "stuck at *", 3.0),
            message: "it is stuck: it has sent * for * s although it trembled before; check that the probe moves freely \
                      and that its display is not held",
            after_s: 13.0,
            ..Case::TREMBLED
        },
        Trouble::OutOfRange => Case {
            fault: Some(Fault::OutOfRange { duration_s: 0.8 }),
            gap: GapOf::without_value(None, "no value: *the instrument reports an error*", 0.5),
            message: "it has no value: *the instrument reports an error*",
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
