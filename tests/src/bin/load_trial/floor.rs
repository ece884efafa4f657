//! The devices of the load trial, and the configuration of the service that reads them.

use anyhow::Context;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use trunnion_core::AxisValues;
use trunnion_core::axis::iso::C;
use trunnion_hil_sim::devices::canopen::BusConfig;
use trunnion_hil_sim::devices::cell::{Cell, CellConfig};
use trunnion_hil_sim::devices::{
    CycleState, DeviceClock, Fault, ScheduledFault, SimulatedCell, World, cell, orthogonal_nest,
};
use trunnion_hil_sim::{Instrument, NestOn, SimSetup, Truth, VirtualMachine, scenario};
use trunnion_machine::shipped;
use trunnion_tests::SILENCE_MS;

/// Rates of the devices, Hz.
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    /// Each of three probes.
    pub probe_hz: f64,
    /// The encoder.
    pub encoder_hz: f64,
    /// The axes.
    pub axes_hz: f64,
}

impl Rates {
    /// The highest of the devices.
    pub const FULL: Self = Self { probe_hz: 4000.0, encoder_hz: 1000.0, axes_hz: 200.0 };
    /// So low that any computer reads them.
    pub const LOW: Self = Self { probe_hz: 500.0, encoder_hz: 100.0, axes_hz: 25.0 };
}

/// Feeds of C, °/min; every one forward and back.
pub const FEEDS_DEG_PER_MIN: [f64; 4] = [360.0, 720.0, 1800.0, 3600.0];
/// From switching on to the start of the program: drivers connect, clocks settle.
const WARM_UP: Duration = Duration::from_secs(5);
/// In the trial with faults the second probe is silent from here on, for so long, s: below [`SILENCE_MS`].
const SILENT_FROM_S: f64 = 4.0;
const SILENT_FOR_S: f64 = 1.0;
/// Left out at both ends when values that were sent are counted, s.
pub const EDGE_S: f64 = 1.0;

/// What the floor does.
#[derive(Clone, Copy, Debug)]
pub struct Order<'a> {
    /// About the length of the program, s.
    pub seconds: f64,
    /// How fast the devices are.
    pub rates: Rates,
    /// One probe is silent for a second.
    pub is_faulty: bool,
    /// The program begins again after so long, s; it runs once where there is none.
    pub pause_s: Option<f64>,
    /// Tables of the configuration in addition to nest and devices.
    pub tables: &'a str,
}

/// Programs that are counted apart; what is sent in later ones is judged by the clocks alone.
const MOST_PROGRAMS: usize = 1000;

/// The running shop floor.
pub struct Floor {
    cell: Cell,
    world: Arc<Counted>,
    /// Configuration of the service.
    pub config: PathBuf,
    /// From the start of the program to its end, s.
    pub duration_s: f64,
    /// From the start of the program to its next start, s; infinite where it runs once.
    pub period_s: f64,
}

/// What devices sent during one program, its edges left out. On a starved computer a simulated one may send less than its rate says.
#[derive(Clone, Copy, Debug)]
pub struct Sent {
    /// Values of the encoder.
    pub encoder: u64,
    /// Positions of the axes that the controller sampled.
    pub axes: u64,
}

impl Sent {
    /// Those of a stream by its name.
    pub fn of(self, stream: &str) -> u64 {
        match stream {
            "axes" => self.axes,
            _ => self.encoder,
        }
    }
}

/// What a device sent, program by program.
struct Tally(Vec<AtomicU64>);

impl Tally {
    fn new(programs: usize) -> Self {
        Self(std::iter::repeat_with(AtomicU64::default).take(programs).collect())
    }

    fn add(&self, program: usize) {
        if let Some(sent) = self.0.get(program) {
            sent.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn of(&self, program: usize) -> Option<u64> {
        self.0.get(program).map(|sent| sent.load(Ordering::Relaxed))
    }
}

/// A world that begins again after each period, and counts what encoder and controller ask of it, once for every value they send.
struct Counted {
    cell: SimulatedCell,
    period_s: f64,
    from_to_s: (f64, f64),
    bar: Tally,
    axes: Tally,
}

impl Counted {
    /// Which program a time belongs to, and its own time.
    fn own(&self, t_s: f64) -> (usize, f64) {
        match t_s >= self.period_s {
            true => ((t_s / self.period_s) as usize, t_s % self.period_s),
            false => (0, t_s),
        }
    }

    /// Its own time, counted where it is no edge of the program.
    fn counted_s(&self, t_s: f64, tally: &Tally) -> f64 {
        let (program, own_s) = self.own(t_s);
        if (self.from_to_s.0..self.from_to_s.1).contains(&own_s) {
            tally.add(program);
        }
        own_s
    }
}

impl World for Counted {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        self.cell.axes(self.counted_s(t_s, &self.axes))
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        self.cell.probe_readings_mm(self.own(t_s).1)
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        self.cell.bar_reading_mm(self.counted_s(t_s, &self.bar))
    }

    fn temperature_degc(&self, t_s: f64) -> f64 {
        self.cell.temperature_degc(self.own(t_s).1)
    }

    fn cycle(&self, t_s: f64) -> CycleState {
        self.cell.cycle(self.own(t_s).1)
    }
}

impl Floor {
    /// Switches on; the program starts after the warm-up.
    pub async fn start(order: Order<'_>, folder: &Path, recordings: &Path) -> anyhow::Result<Self> {
        let Order { seconds, rates, is_faulty, pause_s, tables } = order;
        let seconds_per_deg: f64 = FEEDS_DEG_PER_MIN.iter().map(|feed| 2.0 * 60.0 / feed).sum();
        let to_deg = (seconds / seconds_per_deg).floor();
        let world = world(to_deg)?;
        let duration_s = world.trajectory.duration_s();
        let from_to_s = (EDGE_S, duration_s - EDGE_S);
        let (period_s, programs) = match pause_s {
            Some(pause_s) => (duration_s + pause_s, MOST_PROGRAMS),
            None => (f64::INFINITY, 1),
        };
        let (bar, axes) = (Tally::new(programs), Tally::new(programs));
        let world = Arc::new(Counted { cell: world, period_s, from_to_s, bar, axes });

        let wall_ns = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos() as i64;
        let mut devices = CellConfig::new(folder, wall_ns);
        for (probe, _) in &mut devices.probes {
            probe.rate_hz = rates.probe_hz;
        }
        if is_faulty {
            let fault = Fault::Silence { duration_s: SILENT_FOR_S };
            devices.probes[1].1.push(ScheduledFault { at_s: SILENT_FROM_S, fault });
        }
        let mut bus = BusConfig::ball_bar(DeviceClock::steady(41.0, -55.0));
        bus.nodes[0].event_timer_ms = 0; // by SYNC alone
        devices.can = Some((bus, Vec::new()));
        if let Some((agent, _)) = &mut devices.controller {
            agent.rate_hz = rates.axes_hz;
            agent.filters_duplicates = false;
        }
        let begin = tokio::time::Instant::now() + WARM_UP;
        let cell = cell::start(Arc::clone(&world) as Arc<dyn World>, devices, begin).await?;
        let url = cell.controller.as_ref().and_then(|agent| agent.url()).context("the cell has an agent")?;
        std::fs::write(folder.join("cycle.toml"), cycle_text(to_deg))?;
        let config = folder.join("trunnion.toml");
        std::fs::write(&config, config_text(rates, folder, recordings, url) + tables)?;
        Ok(Self { cell, world, config, duration_s, period_s })
    }

    /// Waits for the start of the program.
    pub async fn until_begin(&self) {
        tokio::time::sleep_until(self.cell.origin.instant_of(0.0)).await;
    }

    /// What was sent during the program of this number; `None` where nobody counted.
    pub fn sent(&self, program: usize) -> Option<Sent> {
        let (encoder, axes) = (self.world.bar.of(program)?, self.world.axes.of(program)?);
        Some(Sent { encoder, axes })
    }

    /// Bytes nobody took in time.
    pub fn bytes_not_taken(&self) -> u64 {
        let handles = self.cell.probes.iter().chain(&self.cell.can);
        handles.map(|handle| handle.lost_bytes()).sum()
    }

    /// Switches off.
    pub async fn shutdown(self) {
        self.cell.shutdown().await;
    }
}

fn world(to_deg: f64) -> anyhow::Result<SimulatedCell> {
    let machine = shipped::machine("table-bc").context("the machine is shipped")?;
    let setup = SimSetup::new("low", NestOn::Table, [150.0, 0.0, 60.0].into(), Instrument::R_TEST);
    let truth = Truth::draw(&machine, &[setup], &[], 600.0, 1)?;
    let machine = Arc::new(VirtualMachine::new(machine, truth)?);
    let feeds = FEEDS_DEG_PER_MIN.map(|feed| (feed / 60.0).to_radians());
    let range = (0.0, to_deg.to_radians());
    let mut world = scenario::sweep_cycle(machine, "LOAD", C, range, &feeds, &AxisValues::default())?;
    world.bar_mm = Box::new(|state| 0.05 * state.position[C].sin());
    Ok(world)
}

fn cycle_text(to_deg: f64) -> String {
    format!(
        "format = \"trunnion-cycle/1\"\nname = \"load\"\nmachine = \"table-bc\"\nkind = \"on-the-fly\"\n\n\
         [[setup]]\nname = \"low\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [150.0, 0.0, 60.0]\n\n\
         [sweep]\naxis = \"C\"\nfrom_deg = 0\nto_deg = {to_deg}\nfeeds_deg_per_min = {FEEDS_DEG_PER_MIN:?}\nb_deg = 0\n"
    )
}

fn config_text(rates: Rates, ports: &Path, recordings: &Path, url: &str) -> String {
    let mut text = format!(
        "format = \"trunnion-config/1\"\nname = \"load\"\ncycle = \"cycle.toml\"\nrecordings = '{}'\n\n[nest]\n",
        recordings.display()
    );
    for (k, direction) in orthogonal_nest().iter().enumerate() {
        text += &format!("probe_{} = {direction:?}\n", k + 1);
    }
    let ports = ports.display();
    for k in 1..=3 {
        text += &format!(
            "\n[[device]]\nname = \"probe-{k}\"\ndriver = \"optoncdt\"\nport = '{ports}/probe-{k}'\nrole = \"probe-{k}\"\n\
             range_mm = 2\nrate_khz = {}\nsilence_ms = {SILENCE_MS}\n",
            rates.probe_hz / 1e3
        );
    }
    text + &format!(
        "\n[[device]]\nname = \"encoder\"\ndriver = \"canopen-slcan\"\nport = '{ports}/can'\nsync_ms = {}\n\
         silence_ms = {SILENCE_MS}\nnodes = [{{ id = 5, role = \"bar\" }}]\n\n[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n",
        1e3 / rates.encoder_hz
    )
}
