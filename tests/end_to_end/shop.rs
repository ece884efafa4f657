//! A service as a process, a simulated shop floor for it, and waiting for what it does.

use crate::three_probes::{self, SILENCE_MS};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};
use trunnion::results::RunRecord;
use trunnion_cycles::Cycle;
use trunnion_hil_sim::devices::cell;
use trunnion_hil_sim::devices::cell::{Cell, CellConfig};
use trunnion_hil_sim::scenario::{Pace, Station, static_cycle};
use trunnion_hil_sim::{SimSetup, Truth, VirtualMachine};
use trunnion_machine::shipped;

const CYCLE: &str = include_str!("../../config/cycles/demo-static.toml");
/// Longest wait for a state; no promise of speed.
const LIMIT: Duration = Duration::from_secs(300);

/// A service; killed when the test ends.
pub struct Service(pub Child);

impl Service {
    pub fn start(config: &Path) -> Self {
        Self::start_by(Command::new(env!("CARGO_BIN_EXE_trunnion")).arg("daemon").arg("--config").arg(config))
    }

    /// By a command that becomes it.
    pub fn start_by(command: &mut Command) -> Self {
        Self(command.stdin(Stdio::null()).spawn().unwrap())
    }

    /// As a power cut ends it.
    pub fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// As systemd ends it.
    pub fn stop(mut self) {
        self.signal("TERM");
        assert!(self.0.wait().unwrap().success(), "it ends well");
    }

    /// Processes that analyse for it.
    pub fn analyses(&self) -> Vec<u32> {
        let parent = format!("PPid:\t{}\n", self.0.id());
        let processes = std::fs::read_dir("/proc").unwrap().flatten();
        let of_service = |id: &u32| {
            let read = |file: &str| std::fs::read_to_string(format!("/proc/{id}/{file}")).unwrap_or_default();
            read("status").contains(&parent) && read("cmdline").contains("analyse-run")
        };
        processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).filter(of_service).collect()
    }

    pub fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([&format!("-{name}"), &self.0.id().to_string()]).status();
        assert!(sent.unwrap().success(), "{name}");
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// Probes and a controller, at the beginning of a cycle.
pub struct Floor {
    pub cell: Cell,
    /// Address of the agent.
    pub url: String,
    /// Text of the cycle.
    pub cycle: String,
}

/// A floor whose ports lie in this folder; the demo's cycle with a pose every so many degrees.
pub async fn floor(ports: &Path, step_deg: u32, pace: Pace, change: impl FnOnce(&mut CellConfig)) -> Floor {
    let text = CYCLE.replace("step_deg = 30", &format!("step_deg = {step_deg}"));
    let cycle = Cycle::parse("c.toml", &text).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    let poses = cycle.poses(&machine).unwrap();
    let stations: Vec<Station> =
        poses.iter().map(|pose| Station { setup: pose.setup, position: pose.position }).collect();
    let setups: Vec<SimSetup> = cycle.setups.iter().map(SimSetup::from).collect();
    let truth = Truth::draw(&machine, &setups, &[], 60.0, 3).unwrap();
    let world = VirtualMachine::new(machine, truth).unwrap();
    let world = static_cycle(Arc::new(world), "c", &stations, pace).unwrap();
    let mut floor = CellConfig { can: None, ..CellConfig::new(ports, 0) };
    floor.controller.as_mut().unwrap().0.filters_duplicates = false;
    change(&mut floor);
    let cell = cell::start(Arc::new(world), floor, tokio::time::Instant::now()).await.unwrap();
    let url = cell.controller.as_ref().and_then(|agent| agent.url()).unwrap().to_owned();
    Floor { cell, url, cycle: text }
}

/// A configuration for the probes of a floor, with the table of a controller and further tables.
pub fn config(ports: &Path, recordings: &str, controller: &str, tables: &str) -> String {
    let devices = three_probes::devices(ports, SILENCE_MS);
    [&three_probes::head(recordings), &three_probes::nest(), &devices, controller, tables].concat()
}

/// Table of a controller behind an agent.
pub fn agent(url: &str) -> String {
    format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n")
}

/// Waits for what a look finds.
pub fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(seen) = look() {
            return seen;
        }
        assert!(begun.elapsed() < LIMIT, "never came: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Files of a folder whose names end so.
pub fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let paths = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    paths.filter(|path| path.to_string_lossy().ends_with(ending)).collect()
}

/// Waits for a journal of at least so many bytes.
pub fn journal(runs: &Path, bytes: u64) -> PathBuf {
    until("a journal", || {
        let long = |path: &PathBuf| path.metadata().is_ok_and(|about| about.len() > bytes);
        files(runs, ".mcap.active").into_iter().find(long)
    })
}

/// The state of a run; `None` while there is none.
pub fn record(path: &Path) -> Option<RunRecord> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}
