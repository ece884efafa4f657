//! The service's configuration, `config/trunnion.toml`.

use crate::analysis::AnalysisLimits;
use crate::begun_by::BegunBy;
use crate::mqtt::MqttConfig;
use crate::mtconnect::MtConnectConfig;
use crate::opcua::OpcUaConfig;
use crate::page;
use crate::page::{AddressError, Lan};
use crate::storage::StorageConfig;
use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use trunnion_acquire::config::channels;
use trunnion_acquire::{DeviceConfig, read_devices};
use trunnion_core::input::{Document, Table};
use trunnion_core::{Calibration, Problems, Role, read_calibrations};
use trunnion_sync::{CycleBounds, NestCalibration, StartRule};

/// What the service needs to know.
#[derive(Clone, Debug)]
pub struct Config {
    /// Name of this machine tool in topics and reports.
    pub name: String,
    /// Cycle file of a program that `programs` do not name.
    pub cycle: Option<PathBuf>,
    /// Cycles by program.
    pub programs: Vec<ProgramCycle>,
    /// Model file to judge by; the base model without it.
    pub model: Option<PathBuf>,
    /// Folder of the recordings and reports.
    pub recordings: PathBuf,
    /// Probe directions of the R-test; of no meaning without probes.
    pub nest: NestCalibration,
    /// Whether the file says these directions.
    pub has_nest: bool,
    /// What begins a cycle.
    pub cycle_start: StartRule,
    /// Devices.
    pub devices: Vec<DeviceConfig>,
    /// What the certificates of their sensors say.
    pub calibrations: Vec<Calibration>,
    /// Broker, if any.
    pub mqtt: Option<MqttConfig>,
    /// Where agents of MTConnect reach the service; nowhere without it.
    pub mtconnect: Option<MtConnectConfig>,
    /// Where clients of OPC UA reach the service; nowhere without it.
    pub opcua: Option<OpcUaConfig>,
    /// Where the page listens; there is none without it.
    pub page: Option<PageConfig>,
    /// What the recordings may take of the disk.
    pub storage: StorageConfig,
    /// What the analysis of a run may take.
    pub analysis: AnalysisLimits,
    /// The file as read, for the recording.
    pub text: String,
    /// Where it was read.
    pub file: PathBuf,
}

/// Where the page is, and for whom.
#[derive(Clone, Debug)]
pub struct PageConfig {
    /// Where it listens.
    pub listen: SocketAddr,
    /// What other computers need; they are not let in without it.
    pub lan: Option<Lan>,
}

/// One `[[program]]`: what is measured when the controller runs it.
#[derive(Clone, Debug)]
pub struct ProgramCycle {
    /// What begins it.
    pub begun_by: BegunBy,
    /// Cycle file.
    pub cycle: PathBuf,
    /// Model file to judge by; that of the configuration without it.
    pub model: Option<PathBuf>,
}

impl Config {
    /// Reads the configuration; relative paths are relative to its folder.
    ///
    /// # Errors
    /// Every problem of the file with its line.
    pub fn parse(file: &Path, text: &str) -> Result<Self, Problems> {
        parse_with(file, text, needed_nest)
    }

    /// The same before the nest is calibrated: `[nest]` may be missing.
    ///
    /// # Errors
    /// Every problem of the file with its line.
    pub fn parse_uncalibrated(file: &Path, text: &str) -> Result<Self, Problems> {
        parse_with(file, text, stated_nest)
    }

    /// What begins and ends cycles; a number of the signal is a cycle of its own where a `[[program]]` asks for one.
    pub fn cycle_bounds(&self) -> CycleBounds {
        CycleBounds::new(self.cycle_start.clone()).by_number(has_numbers(&self.programs))
    }
}

/// Reads the table `[nest]`, given the root and whether there are probes.
type ReadNest = fn(&Table<'_>, bool) -> Option<NestCalibration>;

/// A ball bar alone has no nest.
fn needed_nest(root: &Table<'_>, probes: bool) -> Option<NestCalibration> {
    match probes {
        true => root.table("nest").and_then(|table| NestCalibration::read(&table)),
        false => stated_nest(root, probes),
    }
}

fn stated_nest(root: &Table<'_>, _probes: bool) -> Option<NestCalibration> {
    match root.optional_table("nest") {
        Some(table) => NestCalibration::read(&table),
        None => Some(NestCalibration::orthogonal()),
    }
}

fn parse_with(file: &Path, text: &str, nest: ReadNest) -> Result<Config, Problems> {
    let name = file.display().to_string();
    let document = Document::parse(&name, text)?;
    let config = read(&document, file, text, nest);
    document.finish(config)
}

fn read(document: &Document<'_>, file: &Path, text: &str, nest: ReadNest) -> Option<Config> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let root = document.root();
    let format = root.format("trunnion-config/1");
    let name = root.string("name");
    if name.as_deref().is_some_and(|name| name.is_empty() || name.contains(['/', '+', '#', ' '])) {
        root.problem("name", "cannot be part of an MQTT topic", "letters, digits, - and _", "");
    }
    let programs = read_programs(&root, folder);
    // One cycle for every program, or programs with a cycle each, or both.
    let cycle = if root.has("program") { root.optional_string("cycle") } else { root.string("cycle") };
    let model = root.optional_string("model").map(|path| folder.join(path));
    let recordings = root.string("recordings").map(|path| folder.join(path));
    let cycle_start = StartRule::read(&root);
    let by_number = programs.as_deref().is_some_and(has_numbers);
    if by_number && cycle_start.as_ref().is_some_and(|rule| *rule != StartRule::Signal) {
        root.problem(
            "cycle_start",
            "begins no cycle by a signal, whose number [[program]] asks for",
            "by = \"signal\"",
            "",
        );
    }
    let devices = read_devices(&root);
    let channels = devices.as_deref().map(channels).unwrap_or_default();
    let sensors: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
    let calibrations = read_calibrations(&root, devices.as_ref().map(|_| &sensors[..]));
    let probes = channels.iter().any(|channel| matches!(channel.role, Role::Probe(_)));
    let (nest, has_nest) = (nest(&root, probes), root.has("nest"));
    let mqtt = root
        .optional_table("mqtt")
        .map(|table| MqttConfig::read(&table, name.as_deref().unwrap_or("machine")));
    let mtconnect = root.optional_table("mtconnect").map(|table| MtConnectConfig::read(&table));
    let opcua = root.optional_table("opcua").map(|table| OpcUaConfig::read(&table));
    let page = root.optional_table("page").map(|table| read_page(&table));
    let storage = root.optional_table("storage").map(|table| StorageConfig::read(&table));
    let analysis = root.optional_table("analysis").map(|table| AnalysisLimits::read(&table));
    root.no_other_keys();
    format?;
    let mqtt = match mqtt {
        None => None,
        Some(broker) => Some(broker?),
    };
    let mtconnect = match mtconnect {
        None => None,
        Some(adapter) => Some(adapter?),
    };
    let opcua = match opcua {
        None => None,
        Some(server) => Some(server?),
    };
    let page = match page {
        None => None,
        Some(address) => Some(address?),
    };
    let storage = match storage {
        None => StorageConfig::default(),
        Some(storage) => storage?,
    };
    let analysis = match analysis {
        None => AnalysisLimits::default(),
        Some(limits) => limits?,
    };
    Some(Config {
        name: name?,
        cycle: cycle.map(|path| folder.join(path)),
        programs: programs?,
        model,
        recordings: recordings?,
        nest: nest?,
        has_nest,
        cycle_start: cycle_start?,
        devices: devices?,
        calibrations: calibrations?,
        mqtt,
        mtconnect,
        opcua,
        page,
        storage,
        analysis,
        text: text.into(),
        file: file.into(),
    })
}

fn read_programs(root: &Table<'_>, folder: &Path) -> Option<Vec<ProgramCycle>> {
    let mut numbers = BTreeSet::new();
    let read = |table: Table<'_>| {
        let (begun_by, cycle) = (BegunBy::read(&table), table.string("cycle"));
        if let Some(BegunBy::Signal(number)) = begun_by
            && !numbers.insert(number)
        {
            table.problem("signal", format!("= {number} appears twice"), "each number once", "");
        }
        let model = table.optional_string("model").map(|path| folder.join(path));
        table.no_other_keys();
        Some(ProgramCycle { begun_by: begun_by?, cycle: folder.join(cycle?), model })
    };
    let read: Vec<Option<ProgramCycle>> = root.tables("program").into_iter().map(read).collect();
    read.into_iter().collect()
}

fn has_numbers(programs: &[ProgramCycle]) -> bool {
    programs.iter().any(|of| matches!(of.begun_by, BegunBy::Signal(_)))
}

fn read_page(table: &Table<'_>) -> Option<PageConfig> {
    let listen = table.optional_string("listen").unwrap_or_else(|| page::USUAL_ADDRESS.into());
    let lan = Lan::read(table);
    table.no_other_keys();
    match (page::address(&listen), lan) {
        (Ok(listen), lan) => Some(PageConfig { listen, lan }),
        (Err(AddressError::NotThisComputer(listen)), Some(lan)) => {
            Some(PageConfig { listen, lan: Some(lan) })
        }
        (Err(refused), _) => {
            table.problem("listen", refused, "an address of this computer, such as 127.0.0.1:8460", "");
            None
        }
    }
}
