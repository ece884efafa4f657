//! The whole shop floor on one call.

use super::canopen::{self, BusConfig};
use super::clock::{DeviceClock, TimeOrigin};
use super::faults::ScheduledFault;
use super::handle::{DeviceError, Handle};
use super::mtconnect::{self, AgentConfig};
use super::optoncdt::{self, ProbeConfig};
use super::world::World;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tokio::time::Instant;

/// Names of the ports in the cell's directory.
const PROBE_PORTS: [&str; 3] = ["probe-1", "probe-2", "probe-3"];
const CAN_PORT: &str = "can";

/// What stands on the shop floor. `None` or an empty list leaves a device out.
#[derive(Debug, Clone, PartialEq)]
pub struct CellConfig {
    /// Directory for the ports; must exist.
    pub directory: PathBuf,
    /// Probes with an RS422 line of their own, at most three, and their faults.
    pub probes: Vec<(ProbeConfig, Vec<ScheduledFault>)>,
    /// Nodes on the CAN bus, and the faults of the adapter.
    pub can: Option<(BusConfig, Vec<ScheduledFault>)>,
    /// The CNC and its faults.
    pub controller: Option<(AgentConfig, Vec<ScheduledFault>)>,
}

impl CellConfig {
    /// Three probes at 1 kHz, a ball bar on CAN, and a CNC, all with clocks that differ by tens of ppm, no faults.
    pub fn new(directory: &Path, wall_ns_at_origin: i64) -> Self {
        let wandering = |offset_s, rate_ppm, wander_us| DeviceClock {
            wander_us,
            wander_period_s: 300.0,
            ..DeviceClock::steady(offset_s, rate_ppm)
        };
        let probe_clocks =
            [wandering(812.25, 34.0, 20.0), wandering(97.5, -21.0, 15.0), wandering(3605.75, 8.0, 30.0)];
        let probe = |(channel, clock)| (ProbeConfig::new(channel, clock), Vec::new());
        Self {
            directory: directory.to_owned(),
            probes: probe_clocks.into_iter().enumerate().map(probe).collect(),
            can: Some((BusConfig::ball_bar(wandering(41.0, -55.0, 25.0)), Vec::new())),
            controller: Some((AgentConfig::new(wall_ns_at_origin, wandering(-1.75, 12.0, 50.0)), Vec::new())),
        }
    }
}

/// A running shop floor. Dropping it switches everything off.
#[derive(Debug)]
pub struct Cell {
    /// Time 0 of all devices.
    pub origin: TimeOrigin,
    /// The probes, ports `probe-1` … in the cell's directory.
    pub probes: Vec<Handle>,
    /// The slcan adapter, port `can`.
    pub can: Option<Handle>,
    /// The agent.
    pub controller: Option<Handle>,
}

/// Starts everything; time 0 is `origin`. Must be called within a tokio runtime.
pub async fn start(world: Arc<dyn World>, config: CellConfig, origin: Instant) -> Result<Cell, DeviceError> {
    let origin = TimeOrigin(origin);
    if config.probes.len() > PROBE_PORTS.len() {
        let found = config.probes.len() as f64;
        return Err(DeviceError::Setting { device: "cell", setting: "probes", found, allowed: "0..=3" });
    }
    let mut probes = Vec::new();
    for ((probe, faults), name) in config.probes.into_iter().zip(PROBE_PORTS) {
        let port = config.directory.join(name);
        probes.push(optoncdt::spawn(Arc::clone(&world), probe, &port, origin, &faults)?);
    }
    let can = match &config.can {
        Some((bus, faults)) => {
            let port = config.directory.join(CAN_PORT);
            Some(canopen::spawn(Arc::clone(&world), bus, &port, origin, faults)?)
        }
        None => None,
    };
    let controller = match config.controller {
        Some((agent, faults)) => Some(mtconnect::spawn(world, agent, origin, &faults).await?),
        None => None,
    };
    Ok(Cell { origin, probes, can, controller })
}

impl Cell {
    /// Switches everything off and waits until the ports are gone.
    pub async fn shutdown(self) {
        for handle in self.probes.into_iter().chain(self.can).chain(self.controller) {
            handle.shutdown().await;
        }
    }
}
