//! Virtual devices and controllers to try connecting with, each device on a pseudo-terminal in a folder, until Ctrl-C:
//! `cargo run -p trunnion-hil-sim --features opcua --example bench -- /tmp/bench`.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::time::Instant;
use trunnion_core::{AxisValues, Joint};
use trunnion_hil_sim::devices::ascii::{IndicatorConfig, Sees};
use trunnion_hil_sim::devices::canopen::BusConfig;
use trunnion_hil_sim::devices::{
    CycleState, DeviceClock, TimeOrigin, World, ascii, canopen, keyence, linuxcncrsh, mtconnect, opcua,
    optoncdt,
};
use trunnion_protocol::ascii::PRESETS;

/// Probes that move by a tenth of a millimetre in some seconds, and tremble.
struct Bench;

impl World for Bench {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        let mut axes = AxisValues::default();
        (axes[Joint::X], axes[Joint::C]) = (100.0, 0.5 * (0.2 * t_s).sin());
        axes
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        [0.0, 2.1, 4.2].map(|phase| 0.1 * (0.5 * t_s + phase).sin() + 0.0005 * (7e5 * t_s + phase).sin())
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        self.probe_readings_mm(t_s)[0]
    }

    fn temperature_degc(&self, t_s: f64) -> f64 {
        21.0 + 0.5 * (0.01 * t_s).sin()
    }

    fn cycle(&self, _t_s: f64) -> CycleState {
        CycleState { program: "O1".into(), block: 1, running: false }
    }
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("give the folder for the ports")?;
    std::fs::create_dir_all(&folder)?;
    let port = |name: &str| std::path::Path::new(&folder).join(name);
    let (world, origin): (Arc<dyn World>, _) = (Arc::new(Bench), TimeOrigin(Instant::now()));
    let clock = DeviceClock::steady(100.0, 30.0);
    let probe = optoncdt::ProbeConfig::new(0, clock);
    let bus = BusConfig::ball_bar_and_probes(clock);
    let mut devices = vec![
        optoncdt::spawn(world.clone(), probe, &port("optoncdt"), origin, &[])?,
        keyence::spawn(world.clone(), keyence::BoxConfig::three_gauges(), &port("dl-rs1a"), origin, &[])?,
        canopen::spawn(world.clone(), &bus, &port("slcan"), origin, &[])?,
    ];
    for preset in PRESETS {
        let config = IndicatorConfig::new(Sees::Probe(0), **preset);
        devices.push(ascii::spawn(world.clone(), config, &port(preset.name), origin, &[])?);
    }
    let wall_ns = i64::try_from(SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos())?;
    let agent = mtconnect::AgentConfig::new(wall_ns, clock);
    devices.push(mtconnect::spawn(world.clone(), agent, origin, &[]).await?);
    devices.push(linuxcncrsh::spawn(world.clone(), linuxcncrsh::ServerConfig::default(), origin, &[]).await?);
    devices.push(opcua::spawn(world, opcua::ControllerConfig::new(wall_ns, clock), origin, &[]).await?);
    for device in &devices {
        println!("{}", device.address());
    }
    tokio::signal::ctrl_c().await?;
    for device in devices {
        device.shutdown().await;
    }
    Ok(())
}
