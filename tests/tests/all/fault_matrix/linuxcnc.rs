//! LinuxCNC through linuxcncrsh: polled over TCP, the server is part of the controller.

use super::common::some;
use super::matrix::{Case, Cell, Kind, Subject, Trouble};
use trunnion_acquire::DeviceState::{Failed, Silent, Streaming, WrongDevice};
use trunnion_hil_sim::devices::linuxcncrsh::ServerConfig;
use trunnion_hil_sim::devices::{Fault, linuxcncrsh};

const SILENT: &str = "silent for * ms: ADDRESS does not answer as linuxcncrsh; check that LinuxCNC runs, and the network between";
const GONE: &str = "disconnected: ADDRESS: *";

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
    kind: Kind::Controller { address: "ADDRESS" },
    own,
};

fn own(trouble: Trouble) -> Option<Cell> {
    some(match trouble {
        Trouble::Unplugged => Case::unplugged(GONE),
        Trouble::Silent => Case::silent(1.5, SILENT),
        Trouble::Garbled => Case::away(Fault::GarbleBytes { count: 20 }, &[Silent, Streaming], SILENT, 0.2),
        Trouble::WrongIdentity => Case::another(
            &[Failed, WrongDevice],
            GONE,
            "wrong device: found LinuxCNC whose joint 3 is in MM, expected axis B there, by `joints`; compare with \
             COORDINATES of its INI file; correct the port or the configuration",
        ),
        Trouble::Restarted => Case::restarted(GONE),
        Trouble::ControllerGone => {
            return Some(Cell::Cannot(
                "the server is part of the controller: see \"unplugged\" and \"restarted\"",
            ));
        }
        _ => return None,
    })
}
