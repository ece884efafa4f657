//! One virtual device on one port, and the acquisition that reads it.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceStatus, Message, Reading, parse_devices, start};
use trunnion_hil_sim::devices::{CycleState, TimeOrigin, World};
use trunnion_units::{AxisValues, Clock, HostTime};

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

struct SinceStart(Instant);

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
        let devices = parse_devices("trunnion.toml", &self.text(text)).unwrap();
        start(devices, self.clock.clone(), CancellationToken::new(), QUEUE_LENGTH)
    }

    pub fn text(&self, text: &str) -> String {
        text.replace("{port}", self.port.to_str().unwrap())
    }
}

pub async fn next(acquisition: &mut Acquisition) -> Message {
    timeout(LIMIT, acquisition.messages.recv()).await.expect("a message in time").expect("sessions run")
}

/// Readings up to and including the first that fits.
pub async fn until(acquisition: &mut Acquisition, fits: impl Fn(&Reading) -> bool) -> Vec<Reading> {
    let mut readings = Vec::new();
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < LIMIT, "it does not come; last: {:?}", readings.last());
        readings.push(next(acquisition).await.reading);
        if readings.last().is_some_and(&fits) {
            return readings;
        }
    }
}

/// The status of the one device once it fits.
pub async fn state(acquisition: &Acquisition, fits: impl Fn(&DeviceStatus) -> bool) -> DeviceStatus {
    let mut state = acquisition.states[0].clone();
    let found = timeout(LIMIT, state.wait_for(fits)).await.expect("the state in time");
    found.expect("the supervisor runs").clone()
}

/// A value that is one.
pub fn is_good(reading: &Reading) -> bool {
    matches!(reading, Reading::Probe(probe) if !probe.value_mm.is_nan())
}
