//! An MTConnect agent and the controller behind it: streams over HTTP, with the controller's clock and the agent's count.

use super::common::some;
use super::matrix::{Case, Cell, GapOf, Kind, Subject, Trouble};
use trunnion_acquire::DeviceState::{Failed, Silent, Streaming, WrongDevice};
use trunnion_hil_sim::devices::mtconnect::AgentConfig;
use trunnion_hil_sim::devices::{DeviceClock, Fault, mtconnect, relay};

const WALL_NS: i64 = 1_767_225_600_000_000_000;

const GONE: &str = "disconnected: http://ADDRESS/: *";

pub const SUBJECT: Subject = Subject {
    driver: "mtconnect",
    about: "MTConnect agent in front of a controller",
    keys: "url = \"http://127.0.0.1:{tcp}\"\nsilence_ms = 1000\n",
    start: |floor, listen| {
        Box::pin(async move {
            let config = AgentConfig::new(WALL_NS, DeviceClock::steady(2.0, 20.0));
            let agent =
                mtconnect::spawn(floor.world, config, floor.origin, &[]).await.expect("a free address");
            relay::in_front_of(agent, listen, floor.origin, &[]).await.expect("the address is free")
        })
    },
    kind: Kind::Controller { address: "http://ADDRESS/" },
    own,
};

fn own(trouble: Trouble) -> Option<Cell> {
    some(match trouble {
        Trouble::Unplugged => Case::unplugged(GONE),
        Trouble::Silent => Case::away(
            Fault::Freeze { duration_s: 2.5 },
            &[Silent, Streaming],
            "silent for * ms: http://ADDRESS/ does not answer; check that the agent runs, and the network between",
            2.0,
        ),
        Trouble::Garbled => Case {
            fault: Some(Fault::GarbleBytes { count: 400 }),
            message: "a part of the agent's stream was damaged; it is asked for again".into(),
            ..Case::default()
        },
        Trouble::WrongIdentity => Case::another(
            &[Failed, WrongDevice],
            GONE,
            "wrong device: found device VMC-OTHER *, expected *, as at the first connection (restart the service if the \
             machine was changed); correct the port or the configuration",
        ),
        Trouble::CounterJump => {
            Case::lost(Fault::CounterJump { by: 500 }, "the agent's buffer had moved on (OUT_OF_RANGE)")
        }
        Trouble::ClockJump => Case {
            fault: Some(Fault::ClockJump { by_s: 3.0 }),
            after_s: 2.5,
            gap: GapOf::away(
                "its clock was set by +* s; times of readings between are uncertain by that much",
                0.0,
            ),
            message: "the controller's clock was set by +* s; time of the axes begins again".into(),
            ..Case::default()
        },
        Trouble::Restarted => Case::restarted(GONE),
        Trouble::ControllerGone => Case {
            fault: Some(Fault::Silence { duration_s: 1.5 }),
            gap: GapOf::away("the agent had no value for an axis (UNAVAILABLE)", 1.2),
            message: "the agent has no value for axis * (UNAVAILABLE); check that the controller is on and that its \
                      adapter runs"
                .into(),
            ..Case::default()
        },
        _ => return None,
    })
}
