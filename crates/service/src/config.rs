//! The service's configuration, `config/trunnion.toml`.

use crate::mqtt::MqttConfig;
use crate::page;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use trunnion_acquire::config::channels;
use trunnion_acquire::{DeviceConfig, read_devices};
use trunnion_core::input::{Document, Table};
use trunnion_core::{Problems, Role, Secret};
use trunnion_sync::{NestCalibration, StartRule};

/// What the service needs to know.
#[derive(Clone, Debug)]
pub struct Config {
    /// Name of this machine tool in topics and reports.
    pub name: String,
    /// Cycle file to run.
    pub cycle: PathBuf,
    /// Model file to judge by; the base model without it.
    pub model: Option<PathBuf>,
    /// Folder of the recordings and reports.
    pub recordings: PathBuf,
    /// Probe directions of the R-test; of no meaning without probes.
    pub nest: NestCalibration,
    /// What begins a cycle.
    pub cycle_start: StartRule,
    /// Devices.
    pub devices: Vec<DeviceConfig>,
    /// Broker, if any.
    pub mqtt: Option<MqttConfig>,
    /// Where the page listens; there is none without it.
    pub page: Option<SocketAddr>,
    /// The file as read, for the recording.
    pub text: String,
}

impl Config {
    /// Reads the configuration; relative paths are relative to its folder.
    ///
    /// # Errors
    /// Every problem of the file with its line.
    pub fn parse(file: &Path, text: &str) -> Result<Self, Problems> {
        let name = file.display().to_string();
        let document = Document::parse(&name, text)?;
        let config = read(&document, file.parent().unwrap_or(Path::new("")), text);
        document.finish(config)
    }
}

fn read(document: &Document<'_>, folder: &Path, text: &str) -> Option<Config> {
    let root = document.root();
    let format = root.format("trunnion-config/1");
    let name = root.string("name");
    if name.as_deref().is_some_and(|name| name.is_empty() || name.contains(['/', '+', '#', ' '])) {
        root.problem("name", "cannot be part of an MQTT topic", "letters, digits, - and _", "");
    }
    let cycle = root.string("cycle").map(|path| folder.join(path));
    let model = root.optional_string("model").map(|path| folder.join(path));
    let recordings = root.string("recordings").map(|path| folder.join(path));
    let cycle_start = StartRule::read(&root);
    let devices = read_devices(&root);
    let probes = devices.as_deref().is_some_and(has_probes);
    // A ball bar alone has no nest.
    let nest = if probes || root.has("nest") {
        root.table("nest").and_then(|table| NestCalibration::read(&table))
    } else {
        Some(NestCalibration::orthogonal())
    };
    let mqtt =
        root.optional_table("mqtt").map(|table| read_mqtt(&table, name.as_deref().unwrap_or("machine")));
    let page = root.optional_table("page").map(|table| read_page(&table));
    root.no_other_keys();
    format?;
    let mqtt = match mqtt {
        None => None,
        Some(broker) => Some(broker?),
    };
    let page = match page {
        None => None,
        Some(address) => Some(address?),
    };
    Some(Config {
        name: name?,
        cycle: cycle?,
        model,
        recordings: recordings?,
        nest: nest?,
        cycle_start: cycle_start?,
        devices: devices?,
        mqtt,
        page,
        text: text.into(),
    })
}

fn has_probes(devices: &[DeviceConfig]) -> bool {
    channels(devices).iter().any(|channel| matches!(channel.role, Role::Probe(_)))
}

fn read_mqtt(table: &Table<'_>, machine: &str) -> Option<MqttConfig> {
    let host = table.string("host");
    let port = table.number("port", 1.0..=65_535.0);
    let user = table.optional_string("user");
    let password = Secret::read(table);
    table.no_other_keys();
    if user.is_none() && password.is_some() {
        table.problem("password", "has no user", "user and password_file, or neither", "");
    }
    let login = user.map(|user| (user, password));
    Some(MqttConfig { host: host?, port: port? as u16, machine: machine.into(), login })
}

fn read_page(table: &Table<'_>) -> Option<SocketAddr> {
    let listen = table.optional_string("listen").unwrap_or_else(|| page::USUAL_ADDRESS.into());
    table.no_other_keys();
    match page::address(&listen) {
        Ok(address) => Some(address),
        Err(refused) => {
            table.problem(
                "listen",
                &refused.to_string(),
                "an address of this computer, such as 127.0.0.1:8460",
                "",
            );
            None
        }
    }
}
