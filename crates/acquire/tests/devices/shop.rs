//! What the tests share: worlds, the acquisition that reads their devices, and waiting for what it says.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceStatus, parse_devices, start};
use trunnion_core::axis::iso::{B, C, X};
use trunnion_core::reading::{Message, Reading, SourceGap};
use trunnion_core::{AxisValues, Clock, HostTime};
use trunnion_hil_sim::devices::{CycleState, SimulatedCell, TimeOrigin, World};
use trunnion_hil_sim::motion::{Follow, Program, Step, Trajectory};

/// Longest wait for anything; the build machine may be busy.
pub const LIMIT: Duration = Duration::from_secs(30);

/// How the probes move: sines of 0.3 mm, a third of a turn apart, so many rad/s.
#[derive(Clone, Copy, Debug)]
pub struct Bench(pub f64);

/// Some tenths of a millimetre per second.
pub const MOVING: Bench = Bench(1.3);
/// Less than the noise in a second.
pub const RESTING: Bench = Bench(0.001);

impl Bench {
    /// What the three probes read but for noise.
    pub fn truth_mm(self, t_s: f64) -> [f64; 3] {
        [0.0, 1.0, 2.0].map(|k: f64| 0.3 * (self.0 * t_s + k * std::f64::consts::TAU / 3.0).sin())
    }
}

/// What the thermometer reads.
pub const TRUTH_DEGC: f64 = 21.4;

impl World for Bench {
    fn axes(&self, _t_s: f64) -> AxisValues<f64> {
        AxisValues::default()
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        // A micrometre of noise: sines so quick that samples hit them anywhere.
        self.truth_mm(t_s).map(|truth_mm| truth_mm + 0.001 * (7e5 * t_s + truth_mm).sin())
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        self.probe_readings_mm(t_s)[0]
    }

    fn temperature_degc(&self, _t_s: f64) -> f64 {
        TRUTH_DEGC
    }

    fn cycle(&self, _t_s: f64) -> CycleState {
        CycleState { program: "O1".into(), block: 1, running: true }
    }
}

/// Name of the program of [`program`].
pub const PROGRAM: &str = "/home/cnc/sweep c.ngc";

/// X and B stand, C moves as `steps` say; two probes and the bar follow C.
pub fn program(steps: Vec<Step>) -> Arc<SimulatedCell> {
    let mut start = AxisValues::default();
    (start[X], start[B]) = (100.0, 0.25);
    Arc::new(SimulatedCell {
        program: PROGRAM.into(),
        deflection_mm: Box::new(|state| deflection_mm(state.position[C])),
        bar_mm: Box::new(|state| 0.5 * state.position[C].sin()),
        ..SimulatedCell::along(Trajectory::compile(&Program { start, steps }).unwrap())
    })
}

/// Deflection of the ball in [`program`] when C is there.
pub fn deflection_mm(c_rad: f64) -> [f64; 3] {
    [0.1 * c_rad.sin(), 0.05 * c_rad.cos(), 0.02]
}

/// C stands for half a second, then turns at 1 rad/s for longer than any test lasts.
pub fn turning() -> Arc<SimulatedCell> {
    let follow = Follow::new(|axes| *axes);
    let sweep = Step::Sweep { axis: C, from: 0.0, to: 600.0, feed: 1.0, ramp_s: 0.2, follow };
    program(vec![Step::Dwell { duration_s: 0.5 }, sweep])
}

/// The clock of a host that was started then.
pub struct SinceStart(pub Instant);

impl Clock for SinceStart {
    fn now(&self) -> HostTime {
        HostTime(self.0.elapsed().as_nanos() as i64)
    }

    fn wall_ns(&self) -> i64 {
        0
    }
}

/// A port in a directory of its own; host time 0 is time 0 of the device.
pub struct Shop {
    pub world: Arc<dyn World>,
    pub port: PathBuf,
    pub origin: TimeOrigin,
    clock: Arc<SinceStart>,
    _directory: tempfile::TempDir,
}

impl Shop {
    pub fn new(bench: Bench) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let now = Instant::now();
        Self {
            world: Arc::new(bench),
            port: directory.path().join("port"),
            origin: TimeOrigin(now.into()),
            clock: Arc::new(SinceStart(now)),
            _directory: directory,
        }
    }

    /// Starts what `text` configures; `{port}` stands for the port.
    pub fn start(&self, text: &str) -> Acquisition {
        read(&self.text(text), self.clock.clone())
    }

    pub fn text(&self, text: &str) -> String {
        text.replace("{port}", self.port.to_str().unwrap())
    }
}

/// Starts what the text configures.
pub fn read(text: &str, clock: Arc<SinceStart>) -> Acquisition {
    read_queued(text, clock, QUEUE_LENGTH)
}

/// The same with a queue of so many messages.
pub fn read_queued(text: &str, clock: Arc<SinceStart>, queue_length: usize) -> Acquisition {
    let devices = parse_devices("trunnion.toml", text).unwrap();
    start(devices, clock, CancellationToken::new(), queue_length)
}

pub async fn next(acquisition: &mut Acquisition) -> Message {
    timeout(LIMIT, acquisition.messages.recv()).await.expect("a message in time").expect("sessions run")
}

/// Messages up to and including the first that fits.
pub async fn until_message(acquisition: &mut Acquisition, fits: impl Fn(&Message) -> bool) -> Vec<Message> {
    let mut messages = Vec::new();
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < LIMIT, "it does not come; last: {:?}", messages.last());
        messages.push(next(acquisition).await);
        if messages.last().is_some_and(&fits) {
            return messages;
        }
    }
}

/// Readings up to and including the first that fits.
pub async fn until(acquisition: &mut Acquisition, fits: impl Fn(&Reading) -> bool) -> Vec<Reading> {
    let messages = until_message(acquisition, |message| fits(&message.reading)).await;
    messages.into_iter().map(|message| message.reading).collect()
}

/// The first thing of interest that a reading has.
pub async fn find<T>(acquisition: &mut Acquisition, pick: impl Fn(&Reading) -> Option<T>) -> T {
    let readings = until(acquisition, |reading| pick(reading).is_some()).await;
    readings.last().and_then(pick).unwrap()
}

/// The status of the first device once it fits.
pub async fn state(acquisition: &Acquisition, fits: impl Fn(&DeviceStatus) -> bool) -> DeviceStatus {
    state_of(acquisition, 0, fits).await
}

/// The status of a device once it fits.
pub async fn state_of(
    acquisition: &Acquisition,
    device: usize,
    fits: impl Fn(&DeviceStatus) -> bool,
) -> DeviceStatus {
    let mut state = acquisition.states[device].clone();
    let found = timeout(LIMIT, state.wait_for(fits)).await.expect("the state in time");
    found.expect("the supervisor runs").clone()
}

/// The gap of the connection after the first, once its first reading has come.
pub async fn gap_of_the_next_connection(
    acquisition: &mut Acquisition,
    is_reading: impl Fn(&Message) -> bool,
) -> SourceGap {
    let messages = until_message(acquisition, |message| message.epoch > 1 && is_reading(message)).await;
    let gap = messages.into_iter().find_map(|message| match message.reading {
        Reading::Gap(gap) if message.epoch > 1 => Some(gap),
        _ => None,
    });
    gap.expect("the gap comes before the first reading")
}

/// A value that is one.
pub fn is_good(reading: &Reading) -> bool {
    matches!(reading, Reading::Probe(probe) if !probe.value_mm.is_nan())
}
