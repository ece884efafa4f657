//! CANopen probes, encoders and temperature modules behind an slcan adapter on a serial port.
//! Keys: `port`, `baud` (115200), `bitrate` in bit/s (1000000), and those of every CANopen network (`super::canopen`).
//!
//! Which SYNC a value belongs to: an adapter acknowledges each frame it takes, in the order of its stream, so the
//! last acknowledged SYNC is the one, however late the bytes arrive. With an adapter that acknowledges nothing it is
//! the last one written. The moment of a SYNC is when it was written to the port.

mod adapter;
mod probe;

use super::canopen::Network;
use crate::driver::{Device, Driver, Session};
use crate::link::Link;
use crate::session_end::SessionEnd;
use adapter::OpenAdapter;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use trunnion_core::Role;
use trunnion_core::input::Table;
use trunnion_protocol::slcan::Bitrate;

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "canopen-slcan",
    about: "CANopen probes and encoders (CiA 404, 406) on a serial CAN adapter",
    default_silence_ms: 500.0,
    read,
    probe: Some(probe::PROBE),
};

#[derive(Debug)]
struct CanopenSlcan {
    port: String,
    baud: u32,
    bitrate: Bitrate,
    network: Network,
}

fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let port = table.string("port");
    let baud = table.optional_number("baud", 9600.0..=4_000_000.0).unwrap_or(115_200.0);
    let bitrate = table.optional_number("bitrate", 10_000.0..=1_000_000.0).unwrap_or(1e6);
    let known = Bitrate::ALL.into_iter().find(|known| f64::from(known.bits_per_s()) == bitrate);
    if known.is_none() {
        let allowed = Bitrate::ALL.map(|known| known.bits_per_s().to_string()).join(", ");
        table.problem("bitrate", format!("= {bitrate}"), allowed, "");
    }
    let network = Network::read(table);
    let device = CanopenSlcan { port: port?, baud: baud as u32, bitrate: known?, network: network? };
    Some(Arc::new(device))
}

impl Device for CanopenSlcan {
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
        &self.port
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(self.run(link))
    }
}

impl CanopenSlcan {
    async fn run(&self, link: &mut Link) -> Result<Infallible, SessionEnd> {
        let mut adapter = OpenAdapter::open(&self.port, self.baud, self.bitrate, link).await?;
        self.network.measure(&mut adapter, link).await
    }
}
