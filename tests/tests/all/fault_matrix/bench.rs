//! One device, one trouble: the driver under its supervisor, and what is seen of it.

use super::matrix::{Case, Subject};
use super::seen::{Names, Seen};
use super::tape::Tape;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::time::timeout_at;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceState, SessionEnd, parse_devices, start};
use trunnion_core::axis::iso::C;
use trunnion_core::reading::{Message, Reading};
use trunnion_core::{AxisValues, Clock, HostTime};
use trunnion_hil_sim::devices::{CycleState, TimeOrigin, World};
use trunnion_sync::{TimeBase, Timed};
use trunnion_tests::course::Course;

/// Longest wait for anything; the machine may be busy.
const LIMIT: Duration = Duration::from_secs(60);
/// Name of the one device.
pub const NAME: &str = "it";

/// Probes at rest but for their noise, a machine whose C axis turns while its program goes from block to block.
struct Shop;

impl World for Shop {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        let mut axes = AxisValues::default();
        axes[C] = 0.2 * t_s;
        axes
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        // A micrometre of noise: digits far behind the point.
        [0.0, 1.0, 2.0].map(|k: f64| 0.1 * k + 0.002 * ((43_758.545 * (1e5 * t_s + k).sin()).fract() - 0.5))
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        self.probe_readings_mm(t_s)[0]
    }

    fn temperature_degc(&self, _t_s: f64) -> f64 {
        21.0
    }

    fn cycle(&self, t_s: f64) -> CycleState {
        CycleState { program: "O1".into(), block: (5.0 * t_s) as usize, running: true }
    }
}

/// Where a virtual device stands. Host time 0 is time 0 of the device.
#[derive(Clone)]
pub struct Floor {
    pub world: Arc<dyn World>,
    pub port: PathBuf,
    pub origin: TimeOrigin,
}

pub struct SinceStart(Instant);

impl Clock for SinceStart {
    fn now(&self) -> HostTime {
        HostTime(self.0.elapsed().as_nanos() as i64)
    }

    fn wall_ns(&self) -> i64 {
        0
    }
}

/// Looks at what a device does.
struct Watch {
    timebase: TimeBase,
    tape: Tape,
    course: Course,
    /// First and last moment of a reading.
    read: Option<(HostTime, HostTime)>,
    readings: u64,
    seen: Seen,
    names: Names,
}

/// Runs a cell; the error says what is missing and what was seen instead.
pub async fn run(subject: &Subject, case: &Case) -> Result<(), String> {
    let directory = tempfile::tempdir().map_err(|error| error.to_string())?;
    let now = Instant::now();
    let port = directory.path().join("port");
    let floor = Floor { world: Arc::new(Shop), port: port.clone(), origin: TimeOrigin(now.into()) };
    let listen = free_address().map_err(|error| error.to_string())?;
    let switch_on = || (subject.start)(floor.clone(), listen);
    let already_on = if case.fault.is_some() { Some(switch_on().await) } else { None };
    let table = format!("[[device]]\nname = \"{NAME}\"\ndriver = \"{}\"\n{}", subject.driver, subject.keys);
    let table = table.replace("{port}", &port.to_string_lossy()).replace("{tcp}", &listen.port().to_string());
    let devices = parse_devices("trunnion.toml", &table).map_err(|problems| problems.to_string())?;
    let clock = Arc::new(SinceStart(now));
    let mut acquisition = start(devices, clock.clone(), CancellationToken::new(), QUEUE_LENGTH);
    let names = [(port.to_string_lossy().into(), "PORT"), (listen.to_string(), "ADDRESS")];
    let mut watch = Watch::new(names, Tape::start(directory.path(), clock)?);
    let fault_s = floor.origin.now_s();
    let (device, fault_s) = match (already_on, case.fault) {
        (Some(device), Some(fault)) => {
            watch.until(&mut acquisition, |watch| watch.has_been_read(case)).await?;
            watch.seen = Seen::default();
            watch.course.states.clear();
            let fault_s = floor.origin.now_s();
            device.inject(fault).map_err(|error| error.to_string())?;
            (device, fault_s)
        }
        _ => {
            let absent = SessionEnd::Absent { address: String::new(), remedy: "" };
            watch.until(&mut acquisition, |watch| watch.course.ends(&absent) > 0).await?;
            (switch_on().await, fault_s)
        }
    };
    let waited = watch.until(&mut acquisition, |watch| watch.has_all(case)).await;
    for message in acquisition.stop().await {
        watch.take(&message);
    }
    device.shutdown().await;
    waited?;
    let seen = tokio::task::block_in_place(|| watch.recorded(fault_s))?;
    if std::env::var_os("TRUNNION_FAULT_CELLS").is_some() {
        println!("{seen:#?}");
    }
    seen.check(case)
}

fn free_address() -> std::io::Result<SocketAddr> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr()
}

impl Watch {
    fn new(names: Names, tape: Tape) -> Self {
        let timebase = TimeBase::new(HostTime(0));
        Self {
            timebase,
            tape,
            course: Course::default(),
            read: None,
            readings: 0,
            seen: Seen::default(),
            names,
        }
    }

    /// Takes what comes until it is so.
    async fn until(
        &mut self,
        acquisition: &mut Acquisition,
        is_so: impl Fn(&Self) -> bool,
    ) -> Result<(), String> {
        let deadline = tokio::time::Instant::now() + LIMIT;
        let mut state = acquisition.states[0].clone();
        let first = state.borrow_and_update().clone();
        self.course.take(&first);
        while !is_so(self) {
            let next = async {
                tokio::select! {
                    message = acquisition.messages.recv() => message,
                    _ = state.changed() => None,
                }
            };
            let Ok(message) = timeout_at(deadline, next).await else {
                return Err(format!(
                    "not within {LIMIT:?}; seen: {:?}, {:#?}",
                    self.course.states, self.seen
                ));
            };
            match message {
                Some(message) => self.take(&message),
                None => {
                    let status = state.borrow_and_update().clone();
                    self.course.take(&status);
                }
            }
        }
        Ok(())
    }

    fn take(&mut self, message: &Message) {
        let arrival = match &message.reading {
            Reading::Probe(probe) => Some(probe.arrival),
            Reading::Axes(axes) => Some(axes.arrival),
            _ => None,
        };
        if let Some(arrival) = arrival {
            let (first, _) = *self.read.get_or_insert((arrival, arrival));
            self.read = Some((first, arrival));
            self.readings += 1;
        }
        let timed = self.timebase.translate(message);
        let jumps = self.timebase.take_jumps();
        let jumps = jumps.iter().map(|(_, jump)| Timed::Gap(self.timebase.jump_gap(NAME, jump)));
        for timed in jumps.chain(timed).collect::<Vec<_>>() {
            self.tape.record(&timed);
            match timed {
                Timed::Gap(gap) => self.seen.gap_of(gap, &self.names),
                Timed::Event(event) => self.seen.line_of(&event, &self.names),
                _ => {}
            }
        }
    }

    /// What the recording holds from the fault on.
    fn recorded(self, fault_s: f64) -> Result<Seen, String> {
        let (gaps, events) = self.tape.read_back()?;
        let mut seen = Seen { states: self.course.states, ..Seen::default() };
        for gap in gaps.into_iter().filter(|gap| gap.to_s >= fault_s) {
            seen.gap_of(gap, &self.names);
        }
        for event in events.iter().filter(|event| event.time_s >= fault_s) {
            seen.line_of(event, &self.names);
        }
        Ok(seen)
    }

    fn has_been_read(&self, case: &Case) -> bool {
        let long = self.read.is_some_and(|(first, last)| last.seconds_since(first) >= case.after_s);
        long && self.readings >= case.after_readings
    }

    /// True when nothing more is to be waited for. The gap of a device that is not read again comes with the end.
    fn has_all(&self, case: &Case) -> bool {
        let last = self.course.states.last();
        let ends_badly = case.course.last().is_some_and(|state| *state != DeviceState::Streaming);
        last == case.course.last()
            && self.seen.has_reported(case)
            && (ends_badly || case.gap.as_ref().is_none_or(|gap| self.seen.gap(gap).is_some()))
    }
}
