//! Plant status over MQTT: plain JSON topics, and Sparkplug B where the configuration asks for it (docs/design/protocols.md §5).
//!
//! Each has a connection of its own, for a connection has one last will. Both show the present values of the board, and send them again
//! after each CONNACK. History lives in the recording, not here.

mod connection;
pub mod sparkplug;
mod tls;
mod topics;

pub use sparkplug::SparkplugConfig;
pub use tls::MqttTls;

use crate::board::Board;
use tokio_util::sync::CancellationToken;
use trunnion_core::Secret;
use trunnion_core::input::Table;

/// How to reach the broker.
#[derive(Clone, Debug, PartialEq)]
pub struct MqttConfig {
    /// Host name or address.
    pub host: String,
    /// TCP port.
    pub port: u16,
    /// Machine name in the topics.
    pub machine: String,
    /// User, and password if the broker asks for one.
    pub login: Option<(String, Option<Secret>)>,
    /// Encryption; none without.
    pub tls: Option<MqttTls>,
    /// Sparkplug B in addition to the JSON topics; none without.
    pub sparkplug: Option<SparkplugConfig>,
}

impl MqttConfig {
    /// Reads the table; `machine` names this one.
    pub fn read(table: &Table<'_>, machine: &str) -> Option<Self> {
        let host = table.string("host");
        let port = table.number("port", 1.0..=65_535.0);
        let user = table.optional_string("user");
        let password = Secret::read(table);
        let tls = table.optional_table("tls").map(|table| MqttTls::read(&table));
        let sparkplug = table.optional_table("sparkplug").map(|table| SparkplugConfig::read(&table, machine));
        table.no_other_keys();
        if user.is_none() && password.is_some() {
            table.problem("password", "has no user", "user and password_file, or neither", "");
        }
        let login = user.map(|user| (user, password));
        let tls = match tls {
            None => None,
            Some(tls) => Some(tls?),
        };
        let sparkplug = match sparkplug {
            None => None,
            Some(sparkplug) => Some(sparkplug?),
        };
        Some(Self { host: host?, port: port? as u16, machine: machine.into(), login, tls, sparkplug })
    }
}

/// Runs until `cancel`; connects, keeps what the broker has current, reconnects with back-off.
pub async fn run(config: MqttConfig, board: Board, cancel: CancellationToken) {
    let topics = topics::Topics::new(&config.machine, board.clone());
    let topics = connection::keep(&config, topics, &board, &cancel);
    match &config.sparkplug {
        None => topics.await,
        Some(place) => {
            let node = sparkplug::EdgeNode::new(place, board.clone());
            tokio::join!(topics, connection::keep(&config, node, &board, &cancel));
        }
    }
}
