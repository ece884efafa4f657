//! CANopen probes, encoders and temperature modules on a CAN interface of the Linux kernel (SocketCAN).
//! Keys: `interface` ("can0"), and those of every CANopen network (`super::canopen`). The bit rate belongs to the
//! interface: `ip link set can0 up type can bitrate 1000000 restart-ms 100`.
//!
//! The kernel stamps every frame when it arrives, and our own SYNC when it has been on the bus: its moment is that
//! stamp, not when we wrote it. One SYNC is under way at a time, so that each has its own stamp.

mod interface;
mod socket;
mod stamps;

use super::canopen::{FoundNodes, Network, listen_and_scan};
use crate::driver::{Device, Driver, Session};
use crate::link::Link;
use crate::probe::{Answer, Medium, Probe, Probing, link};
use crate::session_end::SessionEnd;
use socket::OpenInterface;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use trunnion_core::Role;
use trunnion_core::input::Table;

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "canopen-socketcan",
    about: "CANopen probes and encoders (CiA 404, 406) on a CAN interface of the kernel",
    default_silence_ms: 500.0,
    read,
    probe: Some(Probe {
        medium: Medium::Can,
        asks: "state of the interface; listens for 1.1 s; CANopen nodes 1 to 127: device type 1000h, at the bit rate of the interface",
        run: look,
    }),
};

fn look(name: &str) -> Probing<'_> {
    Box::pin(async move {
        match nodes(name).await {
            Err(end) => Answer::Trouble(end),
            Ok(nodes) => {
                Answer::Found(nodes.found("CAN interface, up", vec![format!("interface = \"{name}\"")]))
            }
        }
    })
}

async fn nodes(name: &str) -> Result<FoundNodes, SessionEnd> {
    listen_and_scan(&mut OpenInterface::open(name)?, &mut link(LOOK_SILENCE)).await
}

/// Nothing here waits for values.
const LOOK_SILENCE: Duration = Duration::from_millis(500);

/// Longest name of a network interface (IFNAMSIZ − 1).
const LONGEST_NAME: usize = 15;

#[derive(Debug)]
struct CanopenSocketcan {
    interface: String,
    network: Network,
}

fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let interface = table.string("interface");
    if let Some(name) = &interface
        && (name.is_empty() || name.len() > LONGEST_NAME || name.contains(['/', ' ']))
    {
        let allowed = "the name of a CAN interface, \"can0\" for example";
        table.problem("interface", format!("= \"{name}\""), allowed, "");
    }
    let network = Network::read(table);
    Some(Arc::new(CanopenSocketcan { interface: interface?, network: network? }))
}

impl Device for CanopenSocketcan {
    fn channels(&self) -> Vec<(String, Role)> {
        self.network.channels()
    }

    fn bar_zero_mm(&self) -> Option<f64> {
        self.network.bar_zero_mm()
    }

    fn asked_every(&self) -> Option<Duration> {
        Some(self.network.sync_period())
    }

    fn address(&self) -> &str {
        &self.interface
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(self.run(link))
    }
}

impl CanopenSocketcan {
    async fn run(&self, link: &mut Link) -> Result<Infallible, SessionEnd> {
        let mut interface = OpenInterface::open(&self.interface)?;
        self.network.measure(&mut interface, link).await
    }
}
