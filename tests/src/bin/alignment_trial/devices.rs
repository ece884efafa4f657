//! The devices of the floor, one after the other: how each is put up, how it is read, and how the truth is known.

use anyhow::Context;
use std::path::Path;
use std::sync::Arc;
use tokio::runtime::{Builder, Runtime};
use trunnion_hil_sim::devices::ascii::{IndicatorConfig, Sees};
use trunnion_hil_sim::devices::canopen::{BusConfig, NodeKind};
use trunnion_hil_sim::devices::keyence::BoxConfig;
use trunnion_hil_sim::devices::linuxcncrsh::ServerConfig;
use trunnion_hil_sim::devices::mtconnect::AgentConfig;
use trunnion_hil_sim::devices::opcua::ControllerConfig;
use trunnion_hil_sim::devices::optoncdt::ProbeConfig;
use trunnion_hil_sim::devices::{
    Address, DeviceClock, DeviceError, Handle, TimeOrigin, World, ascii, canopen, keyence, linuxcncrsh,
    mtconnect, opcua, optoncdt,
};
use trunnion_protocol::ascii::Preset;
use trunnion_tests::alignment::Truth;

/// Wall clock of the controllers at time 0, ns since 1970.
const WALL_NS: i64 = 1_780_000_000_000_000_000;

/// One device.
pub struct Device {
    /// What it is.
    pub name: &'static str,
    /// How it is read.
    pub transport: &'static str,
    /// How the truth of its samples is known.
    pub truth: Truth,
    /// Its table in a configuration.
    pub config: String,
    running: Running,
}

impl Device {
    /// Switches it off.
    pub fn stop(self) {
        self.running.runtime.block_on(self.running.handle.shutdown());
    }
}

/// A device on a thread of its own: it waits for no other device and for no driver, as a real one does not.
struct Running {
    handle: Handle,
    runtime: Runtime,
}

impl Running {
    fn start(device: impl Future<Output = Result<Handle, DeviceError>>) -> anyhow::Result<Self> {
        let runtime = Builder::new_multi_thread().worker_threads(1).enable_all().build();
        let runtime = runtime.context("cannot start the runtime of a device")?;
        let handle = runtime.block_on(device)?;
        Ok(Self { handle, runtime })
    }
}

/// What every device is put up with.
pub struct Stand<'a> {
    /// What there is to see.
    pub world: Arc<dyn World>,
    /// Time 0.
    pub origin: TimeOrigin,
    /// Folder of the ports.
    pub ports: &'a Path,
}

impl Stand<'_> {
    fn world(&self) -> Arc<dyn World> {
        Arc::clone(&self.world)
    }

    /// An optoNCDT with a clock of its own, by which it stamps.
    pub fn probe(
        &self,
        number: usize,
        batch_s: f64,
        latency_s: f64,
        transport: &'static str,
    ) -> anyhow::Result<Device> {
        let clock = [DeviceClock::steady(812.25, 34.0), DeviceClock::steady(97.5, -21.0)][number - 1];
        let probe = ProbeConfig { batch_s, latency_s, ..ProbeConfig::new(number - 1, clock) };
        let port = self.ports.join(format!("probe-{number}"));
        Ok(Device {
            name: "optoNCDT, 1 kHz",
            transport,
            truth: Truth::Clock(clock),
            config: serial_table("optoncdt", &port, &format!("role = \"probe-{number}\"\nrange_mm = 2")),
            running: Running::start(async { optoncdt::spawn(self.world(), probe, &port, self.origin, &[]) })?,
        })
    }

    /// Three gauges on a box.
    pub fn gauge_box(&self) -> anyhow::Result<Device> {
        let port = self.ports.join("box");
        let keys = "baud = 38400\nheads = [{ head = 1, role = \"probe-3\" }]";
        Ok(Device {
            name: "Keyence DL-RS1A",
            transport: "serial, polled at 38 400 baud, box refreshes every 13 ms",
            truth: Truth::Reading { zero_mm: 0.0 },
            config: serial_table("keyence-dl-rs1a", &port, keys),
            running: Running::start(async {
                keyence::spawn(self.world(), BoxConfig::three_gauges(), &port, self.origin, &[])
            })?,
        })
    }

    /// A display that latches at the request.
    pub fn heidenhain(&self) -> anyhow::Result<Device> {
        let transport =
            "serial (driver `ascii`), 16 times a second; latched at the request, answered 50 ms later";
        let change = |config| IndicatorConfig { answer_s: 0.05, ..config };
        self.indicator("Heidenhain ND 28x", transport, "heidenhain-nd28x", 60, change)
    }

    /// An indicator that does not say when it takes a value.
    pub fn mahr(&self) -> anyhow::Result<Device> {
        let transport =
            "serial (driver `ascii`), 25 times a second; taken anywhere in the 30 ms until the answer";
        let change = |config| IndicatorConfig { taken: (0.0, 1.0), ..config };
        self.indicator("Mahr C 1202", transport, "mahr-c1202", 40, change)
    }

    fn indicator(
        &self,
        name: &'static str,
        transport: &'static str,
        preset: &str,
        poll_ms: u32,
        change: impl Fn(IndicatorConfig) -> IndicatorConfig,
    ) -> anyhow::Result<Device> {
        let port = self.ports.join(preset);
        let known = Preset::named(preset).with_context(|| format!("{preset} is a preset"))?;
        let config = change(IndicatorConfig::new(Sees::Bar, *known));
        let keys = format!("preset = \"{preset}\"\nrole = \"bar\"\npoll_ms = {poll_ms}");
        Ok(Device {
            name,
            transport,
            truth: Truth::Reading { zero_mm: 0.0 },
            config: serial_table("ascii", &port, &keys),
            running: Running::start(async { ascii::spawn(self.world(), config, &port, self.origin, &[]) })?,
        })
    }

    /// An encoder on a bus behind a serial adapter.
    pub fn ball_bar(&self) -> anyhow::Result<Device> {
        let port = self.ports.join("can");
        let bus = BusConfig::ball_bar(DeviceClock::steady(41.0, -55.0));
        let NodeKind::BallBar { zero_mm, .. } = bus.nodes[0].kind else {
            anyhow::bail!("node 5 is a ball bar")
        };
        Ok(Device {
            name: "CANopen CiA 406, 200 Hz",
            transport: "slcan adapter on a serial port, SYNC",
            truth: Truth::Reading { zero_mm },
            config: serial_table(
                "canopen-slcan",
                &port,
                "bitrate = 1000000\nnodes = [{ id = 5, role = \"bar\" }]",
            ),
            running: Running::start(async { canopen::spawn(self.world(), &bus, &port, self.origin, &[]) })?,
        })
    }

    /// A controller by MTConnect.
    pub fn mtconnect(&self) -> anyhow::Result<Device> {
        let mut agent = AgentConfig::new(WALL_NS, DeviceClock::steady(-1.75, 12.0));
        agent.filters_duplicates = false;
        let running = Running::start(mtconnect::spawn(self.world(), agent, self.origin, &[]))?;
        Ok(Device {
            name: "CNC by MTConnect, 125 Hz",
            transport: "HTTP, one stamp of the controller for all axes",
            truth: Truth::AngleOfC,
            config: table("mtconnect", &format!("url = \"{}\"", running.handle.address())),
            running,
        })
    }

    /// A controller by OPC UA.
    pub fn opcua(&self) -> anyhow::Result<Device> {
        let config = ControllerConfig::new(WALL_NS, DeviceClock::steady(0.6, -17.0));
        let running = Running::start(opcua::spawn(self.world(), config, self.origin, &[]))?;
        let keys =
            format!("url = \"{}\"\nlayout = \"sinumerik\"\naxes = \"XYZBC\"", running.handle.address());
        Ok(Device {
            name: "CNC by OPC UA, 100 Hz",
            transport: "TCP, each axis with its stamp of the controller, sampled 1 ms apart",
            truth: Truth::AngleOfC,
            config: table("opcua", &keys),
            running,
        })
    }

    /// A controller by linuxcncrsh.
    pub fn linuxcnc(&self) -> anyhow::Result<Device> {
        let server = linuxcncrsh::spawn(self.world(), ServerConfig::default(), self.origin, &[]);
        let running = Running::start(server)?;
        let Address::Tcp(address) = running.handle.address() else {
            anyhow::bail!("linuxcncrsh listens on TCP")
        };
        let keys = format!("host = \"{}\"\nport = {}\njoints = \"XYZBC\"", address.ip(), address.port());
        Ok(Device {
            name: "CNC by LinuxCNC",
            transport: "TCP, polled at 250 Hz, positions renewed every 10 ms",
            truth: Truth::AngleOfC,
            config: table("linuxcnc", &keys),
            running,
        })
    }
}

fn serial_table(driver: &str, port: &Path, keys: &str) -> String {
    table(driver, &format!("port = '{}'\n{keys}", port.display()))
}

fn table(driver: &str, keys: &str) -> String {
    format!("[[device]]\nname = \"device\"\ndriver = \"{driver}\"\n{keys}\n")
}
