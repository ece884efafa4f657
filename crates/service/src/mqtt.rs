//! Plant status over MQTT: plain JSON topics, and Sparkplug B where the configuration asks for it (docs/design/protocols.md §5).
//!
//! Each has a connection of its own, for a connection has one last will. Both show the present values of the board, and send them again
//! after each CONNACK. History lives in the recording, not here.

mod broker;
mod connection;
pub mod sparkplug;
mod tls;
mod topics;

pub use broker::Broker;
pub use sparkplug::SparkplugConfig;
pub use tls::MqttTls;

use crate::board::Board;
use tokio_util::sync::CancellationToken;
use trunnion_core::input::Table;

/// `[mqtt]`: the broker, and what it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct MqttConfig {
    /// The broker.
    pub broker: Broker,
    /// Machine name in the topics.
    pub machine: String,
    /// Sparkplug B in addition to the JSON topics; none without.
    pub sparkplug: Option<SparkplugConfig>,
}

impl MqttConfig {
    /// Reads the table; `machine` names this one.
    pub fn read(table: &Table<'_>, machine: &str) -> Option<Self> {
        let broker = Broker::read(table);
        let sparkplug = table.optional_table("sparkplug").map(|table| SparkplugConfig::read(&table, machine));
        table.no_other_keys();
        let sparkplug = match sparkplug {
            None => None,
            Some(sparkplug) => Some(sparkplug?),
        };
        Some(Self { broker: broker?, machine: machine.into(), sparkplug })
    }
}

/// Runs until `cancel`; connects, keeps what the broker has current, reconnects with back-off.
pub async fn run(config: MqttConfig, board: Board, cancel: CancellationToken) {
    let topics = topics::Topics::new(&config.machine, board.clone());
    let topics = connection::keep(&config.broker, topics, &board, &cancel);
    match &config.sparkplug {
        None => topics.await,
        Some(place) => {
            let node = sparkplug::EdgeNode::new(place, board.clone());
            tokio::join!(topics, connection::keep(&config.broker, node, &board, &cancel));
        }
    }
}
