//! Sparkplug B 3.0: this service as an edge node, each of its devices as a device [Sparkplug 3.0].
//!
//! The broker's last will is the death of the node. Births name every metric; data names what changed. A metric that a birth did not name
//! begins a new birth. Nothing is retained, and nothing is sent later than it was true: a host that missed something asks for a rebirth.
//! Limits: no aliases, no primary host, no commands but the rebirth.

mod metrics;
mod session;
mod wire;

pub use metrics::{Metric, Metrics, Value, View};
pub use session::{Message, Session};
pub use wire::{Payload, WireMetric, WireValue};

use super::connection::Speaker;
use crate::board::Board;
use crate::clock::SystemClock;
use rumqttc::{AsyncClient, LastWill, Packet, Publish, QoS};
use tracing::{debug, info};
use trunnion_core::Clock;
use trunnion_core::input::Table;

/// `[mqtt.sparkplug]`: where this node stands in the names of the plant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SparkplugConfig {
    /// Group of edge nodes.
    pub group: String,
    /// This edge node: the name of the machine, if nothing else is said.
    pub node: String,
}

impl SparkplugConfig {
    /// Reads the table; `machine` names this one.
    pub fn read(table: &Table<'_>, machine: &str) -> Option<Self> {
        let group = table.string("group");
        let node = table.optional_string("node").unwrap_or_else(|| machine.into());
        table.no_other_keys();
        for (key, name) in [("group", group.as_ref()), ("node", Some(&node))] {
            if name.is_some_and(|name| name.is_empty() || session::part_of_topic(name) != *name) {
                table.problem(key, "cannot be part of a topic", "a name without /, + and #", "");
            }
        }
        Some(Self { group: group?, node })
    }
}

/// The edge node of this service.
pub(super) struct EdgeNode {
    session: Session,
    client_id: String,
    board: Board,
}

impl EdgeNode {
    /// Shows this board.
    pub(super) fn new(config: &SparkplugConfig, board: Board) -> Self {
        // The same for every process: a broker ends the session that it still has of one that died before it lets this one in.
        let client_id = format!("trunnion-{}-{}", config.group, config.node);
        Self { session: Session::new(&config.group, &config.node), client_id, board }
    }
}

impl Speaker for EdgeNode {
    const PART: &'static str = "sparkplug";

    fn client_id(&self) -> String {
        self.client_id.clone()
    }

    fn last_will(&mut self) -> LastWill {
        let death = self.session.next_death();
        LastWill::new(death.topic, death.payload, death.qos, false)
    }

    fn connected(&mut self, client: &AsyncClient) {
        self.session.bear_again();
        if let Err(error) = client.try_subscribe(self.session.commands(), QoS::AtLeastOnce) {
            debug!(%error, "the broker was not asked for commands of hosts");
        }
    }

    fn received(&mut self, message: &Publish) {
        if message.topic == self.session.commands() && self.session.asks_for_rebirth(&message.payload) {
            info!("a host asks for the birth of this Sparkplug node again");
            self.session.bear_again();
        }
    }

    /// Births and data go without acknowledgement [Sparkplug 3.0 §6.4]: what it answers is the subscription.
    fn answered(&mut self, answer: &Packet) -> bool {
        matches!(answer, Packet::SubAck(_))
    }

    fn publish(&mut self, client: &AsyncClient) {
        for message in self.session.news(View::of(&self.board), wall_ms()) {
            if let Err(error) = client.try_publish(message.topic, message.qos, false, message.payload) {
                debug!(%error, "the queue for Sparkplug is full; the node is born again when there is room");
                self.session.bear_again();
                return;
            }
        }
    }

    fn farewell(&mut self, client: &AsyncClient) -> Option<usize> {
        let death = self.session.death();
        client.try_publish(death.topic, death.qos, false, death.payload).ok()?;
        Some(1)
    }
}

fn wall_ms() -> u64 {
    u64::try_from(SystemClock::start().wall_ns() / 1_000_000).unwrap_or(0)
}
