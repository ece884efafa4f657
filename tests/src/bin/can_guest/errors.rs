//! Errors in time of the driver against nodes that show the time: the line of docs/measured/alignment.md.

use crate::bus::SimulatedBus;
use anyhow::{Context, bail, ensure};
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;
use trunnion_acquire::parse_devices;
use trunnion_hil_sim::devices::canopen::{BusConfig, NodeKind, Nodes};
use trunnion_hil_sim::devices::{DeviceClock, TimeOrigin};
use trunnion_tests::alignment;
use trunnion_tests::alignment::{ClockWorld, Truth, row};

/// Length of the run, s of the emulated computer.
const SECONDS: f64 = 45.0;
const SYNC_MS: u32 = 10;
/// The stamps of two cards for one frame differ by less, s.
const MOST_S: f64 = 1e-3;

/// Nodes on one interface, the driver on the other.
pub async fn line(of_nodes: &str, of_driver: &str, transport: &str) -> anyhow::Result<String> {
    let origin = TimeOrigin(Instant::now() + Duration::from_secs(1));
    let config = BusConfig::ball_bar(DeviceClock::default());
    let NodeKind::BallBar { zero_mm, .. } = config.nodes[0].kind else { bail!("node 5 is a ball bar") };
    let nodes = Nodes::new(Arc::new(ClockWorld { length_s: SECONDS }), &config)?;
    let bus = SimulatedBus::start_nodes(of_nodes, nodes, origin)?;
    let text = format!(
        "[[device]]\nname = \"bus\"\ndriver = \"canopen-socketcan\"\ninterface = \"{of_driver}\"\n\
         sync_ms = {SYNC_MS}\nsilence_ms = 1500\nnodes = [{{ id = 5, role = \"bar\" }}]\n"
    );
    let devices = parse_devices("guest.toml", &text)?;
    let messages = alignment::read(devices, origin, SECONDS).await;
    bus.stop()?;
    let errors = alignment::of(&messages, &[Truth::Reading { zero_mm }], None, SECONDS);
    let stream = errors.first().context("there is one device")?;
    ensure!(stream.samples > 1000, "only {} samples", stream.samples);
    let error_s = stream.whole.mean_s.hypot(stream.whole.rms_s);
    ensure!(error_s < MOST_S, "times are off by {:.0} µs", error_s * 1e6);
    let device = format!("CANopen CiA 406, {} Hz", 1000 / SYNC_MS);
    Ok(row(&device, transport, stream))
}
