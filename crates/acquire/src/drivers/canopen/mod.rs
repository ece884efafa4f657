//! CANopen probes (CiA 404), encoders (CiA 406) and temperature modules (CiA 404 in °C), whatever carries the frames.
//!
//! The session reads every node's description over SDO (the decoder is built from it), starts the nodes, sends SYNC at
//! the configured period, and supervises values and heartbeats. All channels read with one SYNC share its moment as
//! their device clock: µs from the start of the session to the SYNC, as well as the transport knows it.
//!
//! Shared keys: `sync_ms` (5) and `nodes`, each with `id`, `role`, and optionally `serial` (1018h:04), which must then
//! match, and for a bar `zero_mm`, what its encoder shows at the length of the bar.

mod bus;
mod description;
mod listen;
mod nodes;
mod scan;

pub(super) use bus::{Bus, BusEvent};
pub(super) use listen::{Heard, listen, listen_and_scan};
pub(super) use scan::{Nodes as FoundNodes, scan};

use crate::bar_zero;
use crate::link::Link;
use crate::session_end::SessionEnd;
use description::NodeConfig;
use nodes::Nodes;
use std::convert::Infallible;
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval};
use trunnion_core::Role;
use trunnion_core::input::Table;
use trunnion_protocol::can::CanId;
use trunnion_protocol::canopen::{CobId, NmtCommand, NodeId};

/// Time between two questions to the transport how the bus is doing.
const LONGEST_TEND: Duration = Duration::from_secs(1);

/// What is measured on the bus.
#[derive(Debug)]
pub(super) struct Network {
    sync_period: Duration,
    nodes: Vec<NodeConfig>,
}

impl Network {
    /// Reads the shared keys, noting problems.
    pub(super) fn read(table: &Table<'_>) -> Option<Self> {
        let sync_ms = table.optional_number("sync_ms", 1.0..=1000.0).unwrap_or(5.0);
        let tables = table.tables("nodes");
        let mut nodes: Vec<NodeConfig> = Vec::new();
        for node in &tables {
            let id = node.number("id", 1.0..=127.0).and_then(|id| NodeId::new(id as u8).ok());
            let role = Role::read(node);
            let serial =
                node.optional_number("serial", 0.0..=f64::from(u32::MAX)).map(|serial| serial as u32);
            let bar_zero_mm = bar_zero::read(node, role);
            node.no_other_keys();
            let (Some(id), Some(role)) = (id, role) else { continue };
            if nodes.iter().any(|other| other.id == id) {
                node.problem("id", format!("= {} appears twice", id.get()), "each node once", "");
            }
            nodes.push(NodeConfig { id, role, serial, bar_zero_mm });
        }
        if tables.is_empty() {
            table.problem("nodes", "has no entry", "[{ id = 1, role = \"probe-1\" }, …]", "");
        }
        let complete = !nodes.is_empty() && nodes.len() == tables.len();
        complete.then_some(Self { sync_period: Duration::from_secs_f64(sync_ms / 1e3), nodes })
    }

    /// Name suffix and role of each node.
    pub(super) fn channels(&self) -> Vec<(String, Role)> {
        self.nodes.iter().map(|node| (format!("node-{}", node.id.get()), node.role)).collect()
    }

    /// Time between two SYNCs.
    pub(super) fn sync_period(&self) -> Duration {
        self.sync_period
    }

    /// What the bar shows at its length, mm, where the configuration says it.
    pub(super) fn bar_zero_mm(&self) -> Option<f64> {
        self.nodes.iter().find_map(|node| node.bar_zero_mm)
    }

    /// Identifies the nodes on an open bus and reads them until something ends it.
    pub(super) async fn measure(
        &self,
        bus: &mut impl Bus,
        link: &mut Link,
    ) -> Result<Infallible, SessionEnd> {
        let mut nodes = self.start(bus, link).await?;
        let end = self.read_values(bus, &mut nodes, link).await;
        nodes.count_silent(link);
        end
    }

    async fn start(&self, bus: &mut impl Bus, link: &mut Link) -> Result<Nodes, SessionEnd> {
        let services = |id| [CobId::Emergency(id), CobId::SdoAnswer(id), CobId::Heartbeat(id)];
        let of_nodes = self.nodes.iter().flat_map(|node| services(node.id));
        let mut heard: Vec<CanId> = of_nodes.chain([CobId::Sync]).map(CobId::can_id).collect();
        bus.hear(&heard)?;
        // Silence first: a node left running would talk into the transfers.
        bus.send(NmtCommand::EnterPreOperational.frame(None)).await?;
        let mut descriptions = Vec::new();
        for node in &self.nodes {
            let description = bus::describe(bus, node.id, &descriptions, link).await?;
            description::check(node, &description)?;
            descriptions.push(description);
        }
        let values = descriptions.iter().flat_map(|of| &of.tpdos);
        heard.extend(values.map(|tpdo| tpdo.communication.can_id()));
        bus.hear(&heard)?;
        let names: Vec<String> = descriptions.iter().map(description::identity).collect();
        link.identified(names.join("; "));
        let nodes = Nodes::new(&self.nodes, descriptions, link.first_channel, link.now());
        bus.send(NmtCommand::Start.frame(None)).await?;
        Ok(nodes)
    }

    async fn read_values<B: Bus>(
        &self,
        bus: &mut B,
        nodes: &mut Nodes,
        link: &mut Link,
    ) -> Result<Infallible, SessionEnd> {
        let mut ticker = interval(self.sync_period);
        ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let (mut checked, mut tended) = (Instant::now(), Instant::now());
        loop {
            // The SYNC goes out first when both are ready. Both futures are cancel safe.
            let events = tokio::select! {
                biased;
                _ = ticker.tick() => {
                    let now = link.now();
                    if nodes.may_sync(B::SYNCS_UNDER_WAY, now, link) {
                        nodes.sync_written(link.now());
                        bus.send_sync().await?;
                    }
                    Vec::new()
                }
                events = bus.receive(link.silence, link) => events?,
            };
            for event in events {
                match event {
                    BusEvent::Frame { frame, at } => nodes.take(&frame, at, link)?,
                    BusEvent::SyncSent { at } => nodes.sync_accepted(at),
                    BusEvent::SyncRefused => {
                        link.counters.damaged += 1;
                        nodes.sync_accepted(None); // it answers a SYNC all the same
                    }
                    BusEvent::Remark { warning, text } => link.log(warning, text),
                }
            }
            if tended.elapsed() >= LONGEST_TEND.min(link.silence / 4) {
                tended = Instant::now();
                bus.tend().await?;
            }
            if checked.elapsed() >= link.silence / 8 {
                checked = Instant::now();
                let now = link.now();
                nodes.check_silence(now, link.silence).map_err(|end| bus::explain(end, bus))?;
                link.counters.dropped_bytes = bus.dropped_bytes();
                link.report_counters(now);
            }
        }
    }
}
