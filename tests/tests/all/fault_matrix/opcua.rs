//! A controller with an OPC UA server: reports changes, each with the controller's stamp.

use super::common::some;
use super::matrix::{Case, Cell, GapOf, Kind, Subject, Trouble};
use trunnion_acquire::DeviceState::{Failed, Silent, Streaming, WrongDevice};
use trunnion_hil_sim::devices::opcua::ControllerConfig;
use trunnion_hil_sim::devices::{DeviceClock, Fault, opcua};

const WALL_NS: i64 = 1_767_225_600_000_000_000;
const SILENT: &str = "silent for * ms: opc.tcp://ADDRESS does not answer; check that the controller runs, and the network between";
const GONE: &str = "disconnected: opc.tcp://ADDRESS: the server closed the connection";
const LINK_LOST: &str = "silent for * ms: opc.tcp://ADDRESS: the server has no value for axis * (BadNoCommunication); is the server's link \
                         to the controller up?";

pub const SUBJECT: Subject = Subject {
    driver: "opcua",
    about: "controller with an OPC UA server, in the layout of SINUMERIK",
    keys: "url = \"opc.tcp://127.0.0.1:{tcp}\"\nlayout = \"sinumerik\"\naxes = \"XYZBC\"\nsilence_ms = 1000\n",
    start: |floor, listen| {
        Box::pin(async move {
            let clock = DeviceClock::steady(2.0, 20.0);
            let config = ControllerConfig { listen, ..ControllerConfig::new(WALL_NS, clock) };
            opcua::spawn(floor.world, config, floor.origin, &[]).await.expect("a free address")
        })
    },
    kind: Kind::Controller { address: "opc.tcp://ADDRESS" },
    own,
};

fn own(trouble: Trouble) -> Option<Cell> {
    some(match trouble {
        Trouble::Unplugged => Case::unplugged(GONE),
        Trouble::Silent => Case::away(Fault::Freeze { duration_s: 2.5 }, &[Silent, Streaming], SILENT, 2.0),
        Trouble::Garbled => Case::away(Fault::GarbleBytes { count: 40 }, &[Silent, Streaming], SILENT, 0.8),
        Trouble::WrongIdentity => Case::another(
            &[Failed, WrongDevice],
            GONE,
            "wrong device: found a server with ns=2;s=/Channel/MachineAxis/measPos1[u1,1], *; below Objects it has Sinumerik, expected ns=2;s=/Channel/MachineAxis/measPos1[u1,3] (Z), *; correct the port or the configuration",
        ),
        Trouble::ClockJump => Case {
            fault: Some(Fault::ClockJump { by_s: 3.0 }),
            after_s: 2.5,
            gap: GapOf::away(
                "its clock was set by +* s; times of readings between are uncertain by that much",
                0.0,
            ),
            ..Case::default()
        },
        Trouble::Restarted => Case::restarted(GONE),
        Trouble::ControllerGone => {
            Case::away(Fault::Silence { duration_s: 3.0 }, &[Silent, Streaming], LINK_LOST, 2.4)
        }
        _ => return None,
    })
}
