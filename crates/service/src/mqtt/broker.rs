//! Where the broker is, who we are for it, and whether what is said is encrypted.

use super::tls::MqttTls;
use std::time::Duration;
use trunnion_core::Secret;
use trunnion_core::input::Table;

/// How to reach the broker.
#[derive(Clone, Debug, PartialEq)]
pub struct Broker {
    /// Host name or address.
    pub host: String,
    /// TCP port.
    pub port: u16,
    /// User, and password if the broker asks for one.
    pub login: Option<(String, Option<Secret>)>,
    /// Encryption; none without.
    pub tls: Option<MqttTls>,
    /// How often it is asked whether it is there; after two of them without an answer it is not.
    pub keep_alive: Duration,
}

/// Twice this is how long a dead broker is not noticed: a dashboard that is 20 s old still shows the same cycle.
const KEEP_ALIVE: Duration = Duration::from_secs(10);

impl Broker {
    /// On this computer, for anybody, as a test broker is.
    pub fn local(port: u16) -> Self {
        Self { host: "127.0.0.1".into(), port, login: None, tls: None, keep_alive: KEEP_ALIVE }
    }

    /// Reads its keys of `[mqtt]`.
    pub(super) fn read(table: &Table<'_>) -> Option<Self> {
        let host = Secret::read_address(table, "host");
        let port = table.number("port", 1.0..=65_535.0);
        let user = table.optional_string("user");
        let password = Secret::read(table);
        let tls = table.optional_table("tls").map(|table| MqttTls::read(&table));
        if user.is_none() && password.is_some() {
            table.problem("password", "has no user", "user and password_file, or neither", "");
        }
        let login = user.map(|user| (user, password));
        let tls = match tls {
            None => None,
            Some(tls) => Some(tls?),
        };
        Some(Self { host: host?, port: port? as u16, login, tls, keep_alive: KEEP_ALIVE })
    }
}
