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
//! (never the server's); `instants` brings them to common instants and tells the skew. A server tells changes only: while
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
mod nodes;
#[cfg(feature = "opcua")]
mod probe;
#[cfg(not(feature = "opcua"))]
#[path = "opcua/not_built.rs"]
mod probe;
#[cfg(feature = "opcua")]
mod session;
#[cfg(feature = "opcua")]
mod status;

#[cfg(feature = "opcua")]
use super::Session;
use super::{Device, Driver};
use crate::probe::{Medium, Probe, Scheme};
#[cfg(feature = "opcua")]
use crate::supervisor::Link;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
#[cfg(feature = "opcua")]
use trunnion_core::Role;
use trunnion_core::input::Table;
use trunnion_core::{AxisLetter, AxisValues};

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "opcua",
    about: "controllers with an OPC UA server (SINUMERIK, OPC 40502, any nodes)",
    default_silence_ms: 2000.0,
    read,
    probe: Some(Probe {
        medium: Medium::Network(Scheme { name: "opc.tcp", port: PORT }),
        asks: "OPC UA: endpoints, CncAxisList below Objects, SINUMERIK's measPos1",
        run: probe::run,
    }),
};

/// Where such servers listen unless told otherwise.
const PORT: u16 = 4840;

/// Where positions and states are.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "one for each controller")]
enum Layout {
    /// Machine axes in order of their numbers.
    Sinumerik { axes: Vec<AxisLetter>, unit: String },
    /// By browsing.
    Opc40502 { axes: Option<Vec<AxisLetter>>, position: String },
    /// Named nodes.
    Nodes(AxisValues<Option<String>>),
}

/// Where the password is.
#[derive(Clone)]
enum Password {
    Given(String),
    File(PathBuf),
}

impl std::fmt::Debug for Password {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Password")
    }
}

/// Nodes of the program, where the configuration names them.
#[derive(Debug, Default, Clone)]
struct Named {
    program: Option<String>,
    state: Option<String>,
    block: Option<String>,
    signal: Option<String>,
}

#[derive(Debug)]
#[cfg_attr(
    not(feature = "opcua"),
    expect(dead_code, reason = "read, so that a file is checked in every build")
)]
struct OpcUa {
    url: String,
    layout: Layout,
    named: Named,
    interval: Duration,
    /// Folder of the certificates where the connection is to be encrypted.
    certificates: Option<PathBuf>,
    server_certificate: Option<PathBuf>,
    user: Option<(String, Password)>,
}

fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let device = read_keys(table);
    #[cfg(not(feature = "opcua"))]
    {
        drop(device);
        table.problem("driver", "= \"opcua\" is not part of this build", "the other drivers", probe::REMEDY);
        None
    }
    #[cfg(feature = "opcua")]
    device.map(|device| Arc::new(device) as Arc<dyn Device>)
}

fn read_keys(table: &Table<'_>) -> Option<OpcUa> {
    let url = table.string("url");
    let is_url = |url: &String| url.strip_prefix("opc.tcp://").is_some_and(|rest| !rest.is_empty());
    if let Some(url) = url.as_ref().filter(|url| !is_url(url)) {
        table.problem("url", format!("= \"{url}\""), "opc.tcp://host:port", "");
    }
    let layout = read_layout(table);
    let named = Named {
        program: table.optional_string("program"),
        state: table.optional_string("state"),
        block: table.optional_string("block"),
        signal: table.optional_string("signal"),
    };
    let interval_ms = table.optional_number("interval_ms", 1.0..=1000.0).unwrap_or(10.0);
    let security = table.optional_one_of("security", &["none", "Basic256Sha256"]);
    let mut certificates = table.optional_string("certificates").map(PathBuf::from);
    match (security.as_deref(), &certificates) {
        (Some("Basic256Sha256"), None) => {
            let advice = "Give a folder that the service may write, for example /var/lib/trunnion/opcua.";
            table.problem("security", "= \"Basic256Sha256\" needs the key certificates", "both", advice);
        }
        (Some("Basic256Sha256"), Some(_)) => {}
        _ => certificates = None,
    }
    let server_certificate = table.optional_string("server_certificate").map(PathBuf::from);
    let user = table.optional_string("user");
    let password = table.optional_string("password").map(Password::Given);
    let file = table.optional_string("password_file").map(|path| Password::File(path.into()));
    let user = match (user, password, file) {
        (Some(user), Some(password), None) | (Some(user), None, Some(password)) => Some((user, password)),
        (None, None, None) => None,
        _ => {
            let allowed = "user with either password or password_file";
            table.problem("user", "is not complete", allowed, "");
            None
        }
    };
    Some(OpcUa {
        url: url?,
        layout: layout?,
        named,
        interval: Duration::from_secs_f64(interval_ms / 1e3),
        certificates,
        server_certificate,
        user,
    })
}

fn read_layout(table: &Table<'_>) -> Option<Layout> {
    match table.one_of("layout", &["sinumerik", "opc-40502", "nodes"])?.as_str() {
        "sinumerik" => {
            let unit = table.optional_string("unit").unwrap_or_else(|| "u1".into());
            let axes = table.string("axes").and_then(|text| letters(table, &text));
            Some(Layout::Sinumerik { axes: axes?, unit })
        }
        "opc-40502" => {
            let position = table.optional_string("position").unwrap_or_else(|| "PosDirect".into());
            let axes = table.optional_string("axes").and_then(|text| letters(table, &text));
            Some(Layout::Opc40502 { axes, position })
        }
        _ => {
            let named = table.table("nodes")?;
            let nodes = AxisValues::of(AxisLetter::ISO, |letter| named.optional_string(letter.as_str()));
            named.no_other_keys();
            if nodes.0.iter().all(Option::is_none) {
                table.problem("nodes", "names no axis", "X, Y, Z, A, B, C, U, V, W = \"node id\"", "");
            }
            Some(Layout::Nodes(nodes))
        }
    }
}

fn letters(table: &Table<'_>, text: &str) -> Option<Vec<AxisLetter>> {
    let letters: Vec<char> = text.chars().filter(|c| !c.is_whitespace()).collect();
    let axes: Option<Vec<_>> = letters.iter().map(|c| AxisLetter::parse(&c.to_string())).collect();
    let axes = axes.filter(|axes| !axes.is_empty());
    if axes.is_none() {
        table.problem("axes", format!("= \"{text}\""), "letters of X, Y, Z, A, B, C, U, V, W", "");
    }
    axes
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
