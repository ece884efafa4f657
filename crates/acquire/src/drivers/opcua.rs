//! Controllers with an OPC UA server. Keys: `url` (`opc.tcp://host:4840`), `interval_ms` (10: sampling and publishing),
//! where the positions are, who we are, and what the controller is doing.
//!
//! - `layout = "sinumerik"` with `axes = "XYZBC"` (machine axes 1, 2, 3 … of the unit): nodes
//!   `ns=2;s=/Channel/MachineAxis/measPos1[u1,n]`; `unit = "u1"`.
//! - `layout = "opc-40502"`: found by browsing, `CncAxisList/<axis>/PosDirect/ActPos`; `position = "PosDirect"` or
//!   another of the axis' positions; `axes = "XYZBC"` limits them.
//! - `layout = "nodes"` with `nodes = { X = "ns=2;s=…", C = "…" }`.
//! - `security = "none"` or `"Basic256Sha256"` (signed and encrypted), which needs `certificates`, a folder of the
//!   service: our certificate is made there at the first start, and the server's is remembered and must stay the same,
//!   or be that of the file `server_certificate`.
//! - `user` with `password` or `password_file` (a relative path is one of systemd's credentials).
//! - `program`, `state`, `block`, `signal`: nodes of the program's name, its status (1 where it runs, by the enumeration
//!   of OPC 40502; for SINUMERIK 3), the block's text, and a signal that begins and ends cycles. The two layouts of
//!   controllers know the first three.
//!
//! Positions are mm and degrees unless the node has other `EngineeringUnits`. Every axis bears its own source time stamp
//! (never the server's); `instants` brings them to common instants and reports the skew. A server reports changes only: while
//! it answers and nothing changes, held positions are sent.

#![cfg_attr(
    not(feature = "opcua"),
    expect(dead_code, reason = "the keys are read and checked; the session only says what to build with")
)]

#[cfg(feature = "opcua")]
mod connect;
#[cfg(feature = "opcua")]
mod instants;
#[cfg(feature = "opcua")]
mod missing;
#[cfg(feature = "opcua")]
mod nodes;
#[cfg(feature = "opcua")]
mod probe;
#[cfg(not(feature = "opcua"))]
#[path = "opcua/not_built.rs"]
mod probe;
#[cfg(feature = "opcua")]
mod session;
mod settings;
#[cfg(feature = "opcua")]
mod status;
#[cfg(feature = "opcua")]
mod subscription;

#[cfg(feature = "opcua")]
use crate::driver::Session;
use crate::driver::{Device, Driver};
#[cfg(feature = "opcua")]
use crate::link::Link;
use crate::probe::{Medium, Probe, Scheme};
#[cfg(feature = "opcua")]
use settings::OpcUa;
use std::sync::Arc;
#[cfg(feature = "opcua")]
use trunnion_core::Role;
use trunnion_core::input::Table;

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "opcua",
    about: "controllers with an OPC UA server (SINUMERIK, OPC 40502, any nodes)",
    default_silence_ms: 2000.0,
    read,
    probe: Some(Probe {
        medium: Medium::Network(Scheme { name: "opc.tcp", port: settings::PORT }),
        asks: "OPC UA: endpoints, CncAxisList below Objects, SINUMERIK's measPos1",
        run: probe::run,
    }),
};

fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let device = settings::read(table);
    #[cfg(not(feature = "opcua"))]
    {
        drop(device);
        table.problem("driver", "= \"opcua\" is not part of this build", "the other drivers", probe::REMEDY);
        None
    }
    #[cfg(feature = "opcua")]
    device.map(|device| Arc::new(device) as Arc<dyn Device>)
}

#[cfg(feature = "opcua")]
impl Device for OpcUa {
    fn channels(&self) -> Vec<(String, Role)> {
        Vec::new()
    }

    fn address(&self) -> &str {
        &self.url
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(session::run(self, link))
    }
}
