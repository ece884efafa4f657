//! CANopen probes (CiA 404) and encoders (CiA 406) behind an slcan adapter.
//! Keys: `port`, `baud` (115200), `bitrate` in bit/s (1000000), `sync_ms` (5), and `nodes`, each with `id`, `role`, and
//! optionally `serial` (1018h:04), which must then match.
//!
//! The session opens the adapter, reads every node's description over SDO (the decoder is built from it), starts the
//! nodes, sends SYNC at the configured period, and supervises values and heartbeats. All channels read with one SYNC
//! share its moment as their device clock: µs from the start of the session to when the SYNC was written.
//!
//! Which SYNC a value belongs to: an adapter acknowledges each frame it takes, in the order of its stream, so the
//! last acknowledged SYNC is the one, however late the bytes arrive. With an adapter that acknowledges nothing it is
//! the last one written.

mod bus;
mod nodes;

use super::{Device, Driver, Session};
use crate::config::Role;
use crate::message::Counters;
use crate::supervisor::{Link, SessionEnd};
use bus::Bus;
use nodes::Nodes;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval};
use trunnion_protocol::canopen::network::sync_frame;
use trunnion_protocol::canopen::{NmtCommand, NodeId};
use trunnion_protocol::slcan::{AdapterMessage, Bitrate};
use trunnion_units::input::Table;

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "canopen-slcan",
    about: "CANopen probes and encoders (CiA 404, 406) on a serial CAN adapter",
    default_silence_ms: 500.0,
    read,
};

#[derive(Debug)]
struct CanopenSlcan {
    port: String,
    baud: u32,
    bitrate: Bitrate,
    sync_period: Duration,
    nodes: Vec<NodeConfig>,
}

#[derive(Clone, Copy, Debug)]
struct NodeConfig {
    id: NodeId,
    role: Role,
    serial: Option<u32>,
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
    let sync_ms = table.optional_number("sync_ms", 1.0..=1000.0).unwrap_or(5.0);
    let tables = table.tables("nodes");
    let mut nodes: Vec<NodeConfig> = Vec::new();
    for node in &tables {
        let id = node.number("id", 1.0..=127.0).and_then(|id| NodeId::new(id as u8).ok());
        let role = Role::read(node);
        let serial = node.optional_number("serial", 0.0..=f64::from(u32::MAX)).map(|serial| serial as u32);
        node.no_other_keys();
        let (Some(id), Some(role)) = (id, role) else { continue };
        if nodes.iter().any(|other| other.id == id) {
            node.problem("id", format!("= {} appears twice", id.get()), "each node once", "");
        }
        nodes.push(NodeConfig { id, role, serial });
    }
    if tables.is_empty() {
        table.problem("nodes", "has no entry", "[{ id = 1, role = \"probe-1\" }, …]", "");
    }
    let complete = !nodes.is_empty() && nodes.len() == tables.len();
    let sync_period = Duration::from_secs_f64(sync_ms / 1e3);
    let (port, bitrate) = (port?, known?);
    complete
        .then(|| Arc::new(CanopenSlcan { port, baud: baud as u32, bitrate, sync_period, nodes }) as Arc<_>)
}

impl Device for CanopenSlcan {
    fn channels(&self) -> Vec<(String, Role)> {
        self.nodes.iter().map(|node| (format!("node-{}", node.id.get()), node.role)).collect()
    }

    fn address(&self) -> &str {
        &self.port
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(async move {
            let mut counters = Counters::default();
            let end = match self.run(link, &mut counters).await {
                Ok(never) => match never {},
                Err(end) => end,
            };
            link.final_counters(counters);
            end
        })
    }
}

impl CanopenSlcan {
    async fn run(
        &self,
        link: &mut Link,
        counters: &mut Counters,
    ) -> Result<std::convert::Infallible, SessionEnd> {
        let mut bus = Bus::open(&self.port, self.baud, self.bitrate, link).await?;
        // Silence first: a node left running would talk into the transfers.
        bus.send(NmtCommand::EnterPreOperational.frame(None)).await?;
        let mut descriptions = Vec::new();
        for node in &self.nodes {
            let description = bus.describe(node.id).await?;
            nodes::check(node, &description)?;
            descriptions.push(description);
        }
        let names: Vec<String> = descriptions.iter().map(nodes::identity).collect();
        link.identified(names.join("; "));
        let mut nodes = Nodes::new(&self.nodes, descriptions, link.first_channel, link.now());
        bus.send(NmtCommand::Start.frame(None)).await?;
        bus.wait_accepted().await?; // from here on every acknowledgement is that of a SYNC
        let mut ticker = interval(self.sync_period);
        ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let mut checked = Instant::now();
        loop {
            // The SYNC goes out first when both are ready. Both futures are cancel safe.
            let messages = tokio::select! {
                biased;
                _ = ticker.tick() => {
                    nodes.sync_written(link.now());
                    bus.send(sync_frame(None)).await?;
                    Vec::new()
                }
                messages = bus.receive(link.silence) => messages?,
            };
            let arrival = link.now();
            for message in messages {
                match message {
                    AdapterMessage::Accepted => nodes.sync_accepted(),
                    AdapterMessage::Frame { frame, .. } => nodes.take(&frame, arrival, link, counters)?,
                    AdapterMessage::Refused => {
                        counters.damaged += 1;
                        nodes.sync_accepted(); // it answers a SYNC all the same
                    }
                    AdapterMessage::Done
                    | AdapterMessage::Status(_)
                    | AdapterMessage::Version(_)
                    | AdapterMessage::SerialNumber(_) => {}
                }
            }
            if checked.elapsed() >= link.silence / 8 {
                checked = Instant::now();
                nodes.check_silence(arrival, link.silence)?;
                counters.dropped_bytes = bus.dropped_bytes();
                link.counters(*counters, arrival);
            }
        }
    }
}
