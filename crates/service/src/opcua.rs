//! State and newest result for clients of OPC UA on this computer, behind the feature `opcua`.
//!
//! The names are those of OPC 40001-101 (Machinery, result transfer): `ResultManagement/Results/Result` with `ResultMetaData` and
//! `ResultContent`. Limits: structures are given as their parts, not as values of their own; no methods, no events, no file. Without
//! encryption and users, hence for this computer alone; clients read, and write nothing.

#[cfg(feature = "opcua")]
mod nodes;
#[cfg(feature = "opcua")]
mod server;

#[cfg(feature = "opcua")]
pub use server::serve;

use std::net::SocketAddr;
use trunnion_core::input::Table;

/// Where it listens without a word in the configuration: not the usual port 4840, which a controller on this computer may have.
pub const USUAL_ADDRESS: &str = "127.0.0.1:4841";

/// `[opcua]`: where clients reach us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpcUaConfig {
    /// An address of this computer.
    pub listen: SocketAddr,
}

impl OpcUaConfig {
    /// Reads the table.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let listen = table.optional_string("listen").unwrap_or_else(|| USUAL_ADDRESS.into());
        table.no_other_keys();
        let allowed = "an address of this computer, such as 127.0.0.1:4841";
        if !cfg!(feature = "opcua") {
            let advice = "Build it with --features full, or leave [opcua] out.";
            table.problem(
                "listen",
                "cannot be served: this program was built without OPC UA",
                allowed,
                advice,
            );
            return None;
        }
        match listen.parse::<SocketAddr>() {
            Ok(listen) if listen.ip().is_loopback() => Some(Self { listen }),
            Ok(listen) => {
                let found = format!("{listen} can be reached from other computers");
                table.problem("listen", found, allowed, "This server has no encryption.");
                None
            }
            Err(_) => {
                table.problem("listen", format!("\"{listen}\" is no address"), allowed, "");
                None
            }
        }
    }
}
