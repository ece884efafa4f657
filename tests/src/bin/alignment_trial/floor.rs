//! The devices, and what the drivers make of them.

use crate::world::ClockWorld;
use anyhow::Context;
use std::fmt::Write;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::{Message, parse_devices};
use trunnion_hil_sim::devices::canopen::{self, BusConfig};
use trunnion_hil_sim::devices::keyence::{self, BoxConfig};
use trunnion_hil_sim::devices::linuxcncrsh::{self, ServerConfig};
use trunnion_hil_sim::devices::mtconnect::{self, AgentConfig};
use trunnion_hil_sim::devices::optoncdt::{self, ProbeConfig};
use trunnion_hil_sim::devices::{DeviceClock, TimeOrigin, World};
use trunnion_units::{Clock, HostTime};

/// The simulator's time as the host's clock.
struct CellClock(TimeOrigin);

impl Clock for CellClock {
    fn now(&self) -> HostTime {
        HostTime((self.0.now_s() * 1e9).round() as i64)
    }

    fn wall_ns(&self) -> i64 {
        WALL_NS + self.now().0
    }
}

/// Wall clock at time 0, ns since 1970.
pub const WALL_NS: i64 = 1_780_000_000_000_000_000;
/// Clocks of the probes and of the controller.
pub const PROBE_CLOCKS: [(f64, f64); 2] = [(812.25, 34.0), (97.5, -21.0)];
/// What the simulated ball bar shows at no change of length, mm.
pub const BAR_ZERO_MM: f64 = 10.0;
const CNC_CLOCK: (f64, f64) = (-1.75, 12.0);

/// Name of each device in the order of the configuration, and its transport.
pub const DEVICES: [(&str, &str); 6] = [
    ("optoNCDT, 1 kHz", "serial, USB converter that delivers every 16 ms"),
    ("optoNCDT, 1 kHz", "serial, converter that delivers every 1 ms"),
    ("Keyence DL-RS1A", "serial, polled at 38 400 baud, box refreshes every 13 ms"),
    ("CANopen CiA 406, 200 Hz", "slcan adapter on a serial port, SYNC"),
    ("CNC by MTConnect, 125 Hz", "HTTP, one stamp of the controller for all axes"),
    ("CNC by LinuxCNC", "TCP, polled at 250 Hz, positions renewed every 10 ms"),
];

/// Runs everything for so long; the messages of all devices.
pub async fn run(seconds: f64) -> anyhow::Result<Vec<Message>> {
    let ports = tempfile::tempdir().context("cannot make a folder for the ports")?;
    let port = |name: &str| ports.path().join(name);
    let origin = TimeOrigin(Instant::now() + Duration::from_secs(2));
    let world: Arc<dyn World> = Arc::new(ClockWorld { length_s: seconds });
    let clock_of = |(offset_s, rate_ppm)| DeviceClock::steady(offset_s, rate_ppm);
    let probe = |channel: usize, batch_s: f64, latency_s: f64| ProbeConfig {
        batch_s,
        latency_s,
        ..ProbeConfig::new(channel, clock_of(PROBE_CLOCKS[channel]))
    };
    let mut handles = Vec::new();
    for (channel, batch_s, latency_s, name) in [(0, 0.016, 0.001, "usb"), (1, 0.001, 0.0002, "fast")] {
        let config = probe(channel, batch_s, latency_s);
        handles.push(optoncdt::spawn(world.clone(), config, &port(name), origin, &[])?);
    }
    handles.push(keyence::spawn(world.clone(), BoxConfig::three_gauges(), &port("box"), origin, &[])?);
    let bus = BusConfig::ball_bar(clock_of((41.0, -55.0)));
    handles.push(canopen::spawn(world.clone(), &bus, &port("can"), origin, &[])?);
    let mut agent = AgentConfig::new(WALL_NS, clock_of(CNC_CLOCK));
    agent.filters_duplicates = false;
    let agent = mtconnect::spawn(world.clone(), agent, origin, &[]).await?;
    let server = linuxcncrsh::spawn(world, ServerConfig::default(), origin, &[]).await?;
    let url = agent.url().context("the agent has an address")?.to_owned();
    let linuxcnc = server.address().to_string();
    let text = config_text(ports.path(), &url, &linuxcnc)?;
    handles.extend([agent, server]);

    let devices = parse_devices("alignment.toml", &text)?;
    let cancel = CancellationToken::new();
    let clock: Arc<dyn Clock> = Arc::new(CellClock(origin));
    let queue = trunnion_acquire::supervisor::QUEUE_LENGTH;
    let mut acquisition = trunnion_acquire::start(devices, clock, cancel, queue);
    let mut messages = Vec::new();
    let end = origin.instant_of(seconds);
    while let Ok(message) = tokio::time::timeout_at(end, acquisition.messages.recv()).await {
        messages.extend(message);
    }
    messages.extend(acquisition.stop().await);
    for handle in handles {
        handle.shutdown().await;
    }
    Ok(messages)
}

fn config_text(ports: &std::path::Path, url: &str, linuxcnc: &str) -> anyhow::Result<String> {
    let ports = ports.display();
    let mut text = String::new();
    for (k, name) in [(1, "usb"), (2, "fast")] {
        write!(
            text,
            "[[device]]\nname = \"{name}\"\ndriver = \"optoncdt\"\nport = '{ports}/{name}'\nrole = \"probe-{k}\"\nrange_mm = 2\n"
        )?;
    }
    write!(
        text,
        "[[device]]\nname = \"box\"\ndriver = \"keyence-dl-rs1a\"\nport = '{ports}/box'\nbaud = 38400\n\
         heads = [{{ head = 1, role = \"probe-3\" }}]\n"
    )?;
    write!(
        text,
        "[[device]]\nname = \"can\"\ndriver = \"canopen-slcan\"\nport = '{ports}/can'\nbitrate = 1000000\n\
         nodes = [{{ id = 5, role = \"bar\" }}]\n"
    )?;
    write!(text, "[[device]]\nname = \"mtconnect\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n")?;
    let (host, port) = linuxcnc
        .trim_start_matches("http://")
        .trim_start_matches("tcp://")
        .rsplit_once(':')
        .context("an address has a port")?;
    write!(
        text,
        "[[device]]\nname = \"linuxcnc\"\ndriver = \"linuxcnc\"\nhost = \"{host}\"\nport = {port}\njoints = \"XYZBC\"\n"
    )?;
    Ok(text)
}
