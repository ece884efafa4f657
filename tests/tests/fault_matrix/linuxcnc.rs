//! LinuxCNC through linuxcncrsh: polled over TCP, the server is part of the controller.

use crate::matrix::{Case, Cell, GapOf, Subject, Trouble};
use trunnion_acquire::DeviceState::{Absent, Failed, Silent, Streaming, Stuck, WrongDevice};
use trunnion_hil_sim::devices::Fault;
use trunnion_hil_sim::devices::linuxcncrsh::{self, ServerConfig};

const SILENT: &str = "silent for * ms: ADDRESS does not answer as linuxcncrsh; check that LinuxCNC runs, and the network between";

pub const SUBJECT: Subject = Subject {
    driver: "linuxcnc",
    about: "LinuxCNC through linuxcncrsh",
    keys: "host = \"127.0.0.1\"\nport = {tcp}\njoints = \"XYZBC\"\nsilence_ms = 600\n",
    start: |floor, listen| {
        Box::pin(async move {
            let config = ServerConfig { listen, ..ServerConfig::default() };
            linuxcncrsh::spawn(floor.world, config, floor.origin, &[]).await.expect("a free address")
        })
    },
    cell,
};

fn cell(trouble: Trouble) -> Cell {
    Cell::Case(match trouble {
        Trouble::AbsentAtStart => Case {
            course: &[Absent, Streaming],
            gap: GapOf::away("ADDRESS (*) is not there; *", 0.0),
            message: "ADDRESS (*) is not there; *",
            ..Case::NONE
        },
        Trouble::Unplugged => Case {
            fault: Some(Fault::Unplug { duration_s: 1.5 }),
            course: &[Failed, Absent, Streaming],
            gap: GapOf::away("disconnected: ADDRESS: *", 1.2),
            message: "disconnected: ADDRESS: *",
            ..Case::NONE
        },
        Trouble::Silent => Case {
            fault: Some(Fault::Silence { duration_s: 1.5 }),
            course: &[Silent, Streaming],
            gap: GapOf::away(SILENT, 1.2),
            message: SILENT,
            ..Case::NONE
        },
        Trouble::Garbled => Case {
            fault: Some(Fault::GarbleBytes { count: 20 }),
            course: &[Silent, Streaming],
            gap: GapOf::away(SILENT, 0.2),
            message: SILENT,
            ..Case::NONE
        },
        Trouble::WrongIdentity => Case {
            fault: Some(Fault::WrongIdentity),
            course: &[Failed, WrongDevice],
            gap: GapOf::away("disconnected: ADDRESS: *", 0.2),
            message: "wrong device: found LinuxCNC whose joint 3 is in MM, expected axis B there, by `joints`; compare with \
                      COORDINATES of its INI file; correct the port or the configuration",
            ..Case::NONE
        },
        Trouble::StuckValue => Case {
            fault: Some(Fault::StuckValue { duration_s: 4.0 }),
            course: &[Stuck, Streaming],
            gap: GapOf::away("axis positions were stuck while the program went on", 2.0),
            message: "the program went on by * blocks in * s but no axis moved; check that the controller's positions are \
                      live (adapter, machine lock, dry run)",
            ..Case::NONE
        },
        Trouble::Restarted => Case {
            fault: Some(Fault::AgentRestart),
            course: &[Failed, Streaming],
            gap: GapOf::away("disconnected: ADDRESS: *", 0.2),
            message: "disconnected: ADDRESS: *",
            ..Case::NONE
        },
        Trouble::OutOfRange => return Cell::Cannot("an axis has no measuring range"),
        Trouble::CounterJump => return Cell::Cannot("it does not count its positions"),
        Trouble::ClockJump => return Cell::Cannot("it has no clock; the computer's stamps its answers"),
        Trouble::BusOff => return Cell::Cannot("it hangs on no bus"),
        Trouble::ControllerGone => {
            return Cell::Cannot("the server is part of the controller: see \"unplugged\" and \"restarted\"");
        }
    })
}
