//! The devices, and what the drivers make of them.

use crate::devices::{Device, Stand};
use anyhow::Context;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::Runtime;
use tokio::time::Instant;
use trunnion_acquire::parse_devices;
use trunnion_core::reading::Message;
use trunnion_hil_sim::devices::{TimeOrigin, World};
use trunnion_tests::alignment;
use trunnion_tests::alignment::ClockWorld;

/// Until the devices are up, s.
const START_S: f64 = 2.0;

/// All devices.
pub struct Floor {
    /// In the order of the table.
    pub devices: Vec<Device>,
    /// Index of the controller whose axes the synchronisation moves are looked for in.
    pub reference: usize,
    seconds: f64,
    origin: TimeOrigin,
    _ports: tempfile::TempDir,
}

/// Switches everything on.
pub fn start(seconds: f64) -> anyhow::Result<Floor> {
    let ports = tempfile::tempdir().context("cannot make a folder for the ports")?;
    let origin = TimeOrigin(Instant::now() + Duration::from_secs_f64(START_S));
    let world: Arc<dyn World> = Arc::new(ClockWorld { length_s: seconds });
    let stand = Stand { world, origin, ports: ports.path() };
    let devices = vec![
        stand.probe(1, 0.016, 0.001, "serial, USB converter that delivers every 16 ms")?,
        stand.probe(2, 0.001, 0.0002, "serial, converter that delivers every 1 ms")?,
        stand.gauge_box()?,
        stand.heidenhain()?,
        stand.mahr()?,
        stand.ball_bar()?,
        stand.mtconnect()?,
        stand.opcua()?,
        stand.linuxcnc()?,
    ];
    let reference = devices.iter().position(|device| device.config.contains("\"mtconnect\""));
    let reference = reference.context("MTConnect is on the floor")?;
    Ok(Floor { devices, reference, seconds, origin, _ports: ports })
}

impl Floor {
    /// Reads all devices to the end; their messages.
    pub fn read(&self) -> anyhow::Result<Vec<Message>> {
        let mut devices = Vec::new();
        for device in &self.devices {
            // One by one: a role may be given twice here, where no instrument is made of them.
            devices.extend(parse_devices("alignment.toml", &device.config)?);
        }
        let runtime = Runtime::new().context("cannot start the runtime of the drivers")?;
        Ok(runtime.block_on(alignment::read(devices, self.origin, self.seconds)))
    }

    /// Switches everything off.
    pub fn stop(self) {
        self.devices.into_iter().for_each(Device::stop);
    }
}
