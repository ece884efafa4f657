//! An MTConnect agent and the controller behind it: streams over HTTP, with the controller's clock and the agent's count.

use crate::matrix::{Case, Cell, GapOf, Subject, Trouble};
use trunnion_acquire::DeviceState::{Absent, Failed, Streaming, Stuck, WrongDevice};
use trunnion_hil_sim::devices::mtconnect::{self, AgentConfig};
use trunnion_hil_sim::devices::{DeviceClock, Fault};

const WALL_NS: i64 = 1_767_225_600_000_000_000;

pub const SUBJECT: Subject = Subject {
    driver: "mtconnect",
    about: "MTConnect agent in front of a controller",
    keys: "url = \"http://127.0.0.1:{tcp}\"\nsilence_ms = 1000\n",
    start: |floor, listen| {
        Box::pin(async move {
            let config = AgentConfig { listen, ..AgentConfig::new(WALL_NS, DeviceClock::steady(2.0, 20.0)) };
            mtconnect::spawn(floor.world, config, floor.origin, &[]).await.expect("a free address")
        })
    },
    cell,
};

fn cell(trouble: Trouble) -> Cell {
    Cell::Case(match trouble {
        Trouble::AbsentAtStart => Case {
            course: &[Absent, Streaming],
            gap: GapOf::away("http://ADDRESS/ (*) is not there; *", 0.0),
            message: "http://ADDRESS/ (*) is not there; *",
            ..Case::NONE
        },
        Trouble::Unplugged => Case {
            fault: Some(Fault::Unplug { duration_s: 1.5 }),
            course: &[Failed, Absent, Streaming],
            gap: GapOf::away("disconnected: *", 1.2),
            message: "disconnected: *",
            ..Case::NONE
        },
        Trouble::Silent => return Cell::Cannot("not run yet: the virtual device cannot have it"),
        Trouble::Garbled => Case {
            fault: Some(Fault::GarbleBytes { count: 400 }),
            message: "a part of the agent's stream was damaged; it is asked for again",
            ..Case::NONE
        },
        Trouble::WrongIdentity => Case {
            fault: Some(Fault::WrongIdentity),
            course: &[Failed, WrongDevice],
            gap: GapOf::away("disconnected: *", 0.2),
            message: "wrong device: found device VMC-OTHER *, expected *, as at the first connection (restart the service if \
                      the machine was changed); correct the port or the configuration",
            ..Case::NONE
        },
        Trouble::StuckValue => Case {
            fault: Some(Fault::StuckValue { duration_s: 4.0 }),
            course: &[Stuck, Streaming],
            gap: GapOf::away("axis positions were stuck while the program went on", 3.0),
            message: "the program went on by * blocks in * s but no axis moved; check that the controller's positions are \
                      live (adapter, machine lock, dry run)",
            ..Case::NONE
        },
        Trouble::CounterJump => Case {
            fault: Some(Fault::CounterJump { by: 500 }),
            gap: GapOf::counted("the agent's buffer had moved on (OUT_OF_RANGE)"),
            ..Case::NONE
        },
        Trouble::ClockJump => Case {
            fault: Some(Fault::ClockJump { by_s: 3.0 }),
            after_s: 2.5,
            gap: GapOf::away(
                "its clock was set by +* s; times of readings between are uncertain by that much",
                0.0,
            ),
            message: "the controller's clock was set by +* s; time of the axes begins anew",
            ..Case::NONE
        },
        Trouble::Restarted => Case {
            fault: Some(Fault::AgentRestart),
            course: &[Failed, Streaming],
            gap: GapOf::away("disconnected: *", 0.2),
            message: "disconnected: *",
            ..Case::NONE
        },
        Trouble::ControllerGone => Case {
            fault: Some(Fault::Silence { duration_s: 1.5 }),
            gap: GapOf::away("the agent had no value for an axis (UNAVAILABLE)", 1.2),
            message: "the agent has no value for axis * (UNAVAILABLE); check that the controller is on and that its adapter runs",
            ..Case::NONE
        },
        Trouble::OutOfRange => return Cell::Cannot("an axis has no measuring range"),
        Trouble::BusOff => return Cell::Cannot("it hangs on no bus"),
    })
}
