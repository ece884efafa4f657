//! The keys of the `opcua` driver.

use crate::credentials;
use std::path::PathBuf;
use std::time::Duration;
use trunnion_core::input::Table;
use trunnion_core::{AxisValues, Joint, Secret};

/// Where such servers listen unless the user says otherwise.
pub(super) const PORT: u16 = 4840;

/// Where positions and states are.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "one for each controller")]
pub(super) enum Layout {
    /// Machine axes in order of their numbers.
    Sinumerik { axes: Vec<Joint>, unit: String },
    /// By browsing.
    Opc40502 { axes: Option<Vec<Joint>>, position: String },
    /// Named nodes.
    Nodes(AxisValues<Option<String>>),
}

/// Nodes of the program, where the configuration names them.
#[derive(Debug, Default, Clone)]
pub(super) struct Named {
    pub(super) program: Option<String>,
    pub(super) state: Option<String>,
    pub(super) block: Option<String>,
    pub(super) signal: Option<String>,
}

#[derive(Debug)]
#[cfg_attr(
    not(feature = "opcua"),
    expect(dead_code, reason = "read, so that a file is checked in every build")
)]
pub(super) struct OpcUa {
    pub(super) url: String,
    pub(super) layout: Layout,
    pub(super) named: Named,
    pub(super) interval: Duration,
    /// Folder of the certificates where the connection is to be encrypted.
    pub(super) certificates: Option<PathBuf>,
    pub(super) server_certificate: Option<PathBuf>,
    pub(super) user: Option<(String, Secret)>,
}

/// Reads the keys of the driver, noting problems.
pub(super) fn read(table: &Table<'_>) -> Option<OpcUa> {
    let url = Secret::read_address(table, "url");
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
    let user = credentials::read_login(table);
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
            let nodes = AxisValues::of(Joint::ISO, |letter| named.optional_string(letter.as_str()));
            named.no_other_keys();
            if nodes.0.iter().all(Option::is_none) {
                table.problem("nodes", "names no axis", "X, Y, Z, A, B, C, U, V, W = \"node id\"", "");
            }
            Some(Layout::Nodes(nodes))
        }
    }
}

fn letters(table: &Table<'_>, text: &str) -> Option<Vec<Joint>> {
    let letters: Vec<char> = text.chars().filter(|c| !c.is_whitespace()).collect();
    let axes: Option<Vec<_>> = letters.iter().map(|c| Joint::parse(&c.to_string())).collect();
    let axes = axes.filter(|axes| !axes.is_empty());
    if axes.is_none() {
        table.problem("axes", format!("= \"{text}\""), "letters of X, Y, Z, A, B, C, U, V, W", "");
    }
    axes
}
