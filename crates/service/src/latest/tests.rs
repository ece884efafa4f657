//! What a snapshot says of messages that a test made.

use super::*;
use std::sync::atomic::{AtomicI64, Ordering};
use trunnion_acquire::{SessionEnd, parse_devices};
use trunnion_core::AxisValues;
use trunnion_core::reading::ProbeReading;

const DEVICES: &str = r#"
device = [
    { name = "p1", driver = "optoncdt", port = "a", role = "probe-1", range_mm = 2 },
    { name = "p2", driver = "optoncdt", port = "b", role = "probe-2", range_mm = 2 },
    { name = "p3", driver = "optoncdt", port = "c", role = "probe-3", range_mm = 2 },
]
"#;

/// A clock that a test sets, ms.
struct Set(AtomicI64);

impl Clock for Set {
    fn now(&self) -> HostTime {
        HostTime(self.0.load(Ordering::Relaxed) * 1_000_000)
    }

    fn wall_ns(&self) -> i64 {
        0
    }
}

struct Bench {
    clock: Arc<Set>,
    latest: Latest,
    states: Vec<watch::Sender<DeviceStatus>>,
}

impl Bench {
    fn new() -> Self {
        let devices = parse_devices("t.toml", DEVICES).expect("the devices are good");
        let streaming = DeviceStatus { state: DeviceState::Streaming, ..DeviceStatus::default() };
        let (senders, states) = devices.iter().map(|_| watch::channel(streaming.clone())).unzip();
        let clock = Arc::new(Set(AtomicI64::new(0)));
        Self { latest: Latest::new(&devices, states, clock.clone()), clock, states: senders }
    }

    /// A reading of every probe each 10 ms.
    fn read(&self, count: u32, value_mm: impl Fn(usize, u32) -> f64) {
        for k in 0..count {
            self.clock.0.fetch_add(10, Ordering::Relaxed);
            for channel in 0..3 {
                let value_mm = value_mm(channel, k);
                let reading = ProbeReading {
                    channel: channel as u16,
                    device_ticks: 0,
                    tick_s: 1e-3,
                    sequence: 0,
                    raw: (value_mm * 1e5).round() as i64,
                    value_mm,
                    arrival: self.clock.now(),
                };
                self.latest.take(&Message {
                    device: channel as u16,
                    epoch: 1,
                    reading: Reading::Probe(reading),
                });
            }
        }
    }

    fn axes(&self, c_deg: f64) {
        let mut position = AxisValues::default();
        position[Joint::C] = c_deg.to_radians();
        let reading = AxisReading {
            stamp_ns: 0,
            arrival: self.clock.now(),
            position,
            present: AxisValues::of([Joint::X, Joint::C], |_| true),
            sequence: 0,
            held: false,
            skew_ns: 0,
        };
        self.latest.take(&Message { device: 2, epoch: 1, reading: Reading::Axes(reading) });
    }

    fn mounted(&self) {
        let machine = trunnion::files::machine("table-bc").expect("it is shipped");
        let nest = NestCalibration::orthogonal();
        self.latest.set_mounted(Mounted { nest, side: NestSide::Table, machine });
    }
}

#[test]
fn the_ball_is_shown_in_directions_of_the_machine() {
    let bench = Bench::new();
    bench.read(1, |channel, _| if channel == 0 { 1.42 } else { 1.0 });
    let live = bench.latest.snapshot();
    assert!(live.ball_offset_mm.is_none() && live.say.contains("calibrate-nest"), "{live:?}");
    bench.mounted();
    bench.axes(0.0);
    let live = bench.latest.snapshot();
    let ball = live.ball_offset_mm.expect("everything is known");
    assert!((ball.x - 0.42).abs() < 1e-9 && ball.y.abs() < 1e-9, "{ball:?}");
    assert_eq!(live.say, "Ball 0.42 mm too far in +X.");
    // The table has turned by a quarter: its X is the machine's Y, whichever way.
    bench.axes(90.0);
    let ball = bench.latest.snapshot().ball_offset_mm.expect("everything is known");
    assert!((ball.y.abs() - 0.42).abs() < 1e-9 && ball.x.abs() < 1e-9, "{ball:?}");
    assert_eq!(live.axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), ["X", "C"]);
}

#[test]
fn a_probe_near_its_end_or_without_a_value_is_said_with_what_to_do() {
    let bench = Bench::new();
    bench.mounted();
    bench.read(1, |channel, _| [1.0, 1.98, f64::NAN][channel]);
    let live = bench.latest.snapshot();
    let zones: Vec<Zone> = live.probes.iter().map(|probe| probe.zone).collect();
    assert_eq!(zones, [Zone::Centre, Zone::NearEnd, Zone::NoValue]);
    assert!(live.probes[1].say.contains("centre the ball"), "{live:?}");
    assert!(live.ball_offset_mm.is_none() && live.say.contains("p3: no value"), "{live:?}");
    bench.clock.0.fetch_add(3000, Ordering::Relaxed);
    let zone = bench.latest.snapshot().probes[0].zone;
    assert_eq!(zone, Zone::NoValue, "a value of three seconds ago is none");
}

#[test]
fn a_wrong_device_is_said_with_its_remedy_as_long_as_it_is_one() {
    let bench = Bench::new();
    let [found, expected] = ["ILD1420-50".to_owned(), "an optoNCDT with range 2 mm".to_owned()];
    let end = SessionEnd::WrongDevice { found, expected };
    // It is asked again once a minute: until it answers, what it was holds.
    for state in [DeviceState::WrongDevice, DeviceState::Connecting] {
        bench.states[2].send_modify(|status| (status.state, status.last_end) = (state, Some(end.clone())));
        let live = bench.latest.snapshot();
        assert_eq!(live.probes[2].say, end.to_string());
        assert!(
            live.say.matches("wrong device").count() == 1 && !live.say.contains("p3: no value"),
            "{live:?}"
        );
    }
    bench.states[2].send_modify(|status| status.state = DeviceState::Streaming);
    assert!(!bench.latest.snapshot().say.contains("wrong device"));
}

#[test]
fn a_probe_that_keeps_one_number_while_others_tremble_is_stuck_and_coarse_ones_are_not() {
    let bench = Bench::new();
    bench.read(300, |_, _| 1.0);
    assert!(bench.latest.snapshot().probes.iter().all(|probe| probe.zone == Zone::Centre));
    let trembling = |k: u32| 1.0 + 1e-4 * f64::from(k % 3);
    bench.read(300, |channel, k| if channel == 1 { 1.0 } else { trembling(k) });
    let live = bench.latest.snapshot();
    let zones: Vec<Zone> = live.probes.iter().map(|probe| probe.zone).collect();
    assert_eq!(zones, [Zone::Centre, Zone::Stuck, Zone::Centre]);
    assert!(live.say.contains("p2: its number has not changed for 6 s while that of p1 did"), "{live:?}");
}

#[test]
fn what_stands_against_a_cycle_is_said_once_and_again_when_it_changes() {
    let bench = Bench::new();
    let mut readiness = Readiness::default();
    let needed = [0, 1, 2];
    let mut asked = |value_mm: f64| {
        bench.read(1, |channel, k| if channel == 1 { value_mm } else { 1.0 + 1e-4 * f64::from(k) });
        let changed = readiness.changed(bench.latest.before_a_cycle(&needed));
        changed.map(|why| why.iter().map(|why| (why.source.clone(), why.zone)).collect::<Vec<_>>())
    };
    assert_eq!(asked(1.99), None, "devices may still be connecting");
    (0..2).for_each(|_| assert_eq!(asked(1.99), None));
    assert_eq!(asked(1.99), Some(vec![("p2".into(), Zone::NearEnd)]));
    assert_eq!(asked(1.98), None, "the same, with another number");
    assert_eq!(asked(1.0), Some(vec![]));
    bench.latest.set_cycle(Some(("c", Progress { done: 0, total: 3, seconds_left: None }, &[])));
    assert_eq!(asked(1.99), None, "a cycle moves the probes");
}

/// The loop that takes the values may hang while it holds them.
#[test]
fn the_recorder_is_known_while_the_values_are_locked() {
    let latest = Bench::new().latest;
    let held = latest.lock();
    assert_eq!((latest.recorder(), latest.turn()), (None, 0));
    drop(held);
}
