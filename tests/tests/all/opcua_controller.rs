//! The virtual controller with an OPC UA server reports where its axes were at the moments of its stamps, as our driver
//! reads it, whatever the rate of its clock; and it is found by its address.

use std::sync::Arc;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use tracing::level_filters::LevelFilter;
use trunnion_acquire::discovery::{Roles, look, servers};
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{DeviceState, parse_devices, start};
use trunnion_core::axis::iso::{B, C, X, Y, Z};
use trunnion_core::reading::{AxisReading, Execution, Reading};
use trunnion_core::{AxisValues, Joint};
use trunnion_hil_sim::devices::opcua::{ControllerConfig, WithoutLink};
use trunnion_hil_sim::devices::{CycleState, DeviceClock, Fault, Handle, TimeOrigin, World, opcua};
use trunnion_service::clock::SystemClock;
use trunnion_tests::log::Log;
use trunnion_tests::secret_forms::forms;

/// Longest wait for anything; the build machine may be busy.
pub const LIMIT: Duration = Duration::from_secs(60);
pub const AXES: [Joint; 5] = [X, Y, Z, B, C];
pub const WALL_NS: i64 = 1_767_225_600_000_000_000;

/// Axes at constant speeds, so that interpolating between samples is exact.
pub struct Steady;

impl World for Steady {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        let mut axes = AxisValues::default();
        for (k, letter) in AXES.into_iter().enumerate() {
            axes[letter] = if letter.is_rotary() { 0.1 * t_s } else { (k + 1) as f64 * 10.0 * t_s };
        }
        axes
    }

    fn probe_readings_mm(&self, _: f64) -> [f64; 3] {
        [0.0; 3]
    }

    fn bar_reading_mm(&self, _: f64) -> f64 {
        0.0
    }

    fn temperature_degc(&self, _: f64) -> f64 {
        20.0
    }

    fn cycle(&self, _: f64) -> CycleState {
        CycleState { program: "O1".into(), block: 7, running: true }
    }
}

async fn controller(clock: DeviceClock) -> (Handle, String) {
    controller_in(ControllerConfig::new(WALL_NS, clock)).await
}

async fn controller_in(config: ControllerConfig) -> (Handle, String) {
    let origin = TimeOrigin(tokio::time::Instant::now());
    let controller = opcua::spawn(Arc::new(Steady), config, origin, &[]).await.expect("a free address");
    let url = controller.url().expect("it has an address").to_owned();
    (controller, url)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn it_is_found_by_its_address_and_its_lines_read_once_the_axes_are_filled_in() {
    let (controller, url) = controller(DeviceClock::default()).await;
    let mut places = servers(&url, None).expect("an address that can be asked");
    let found = look(places.remove(0), None).await;
    let (driver, found) = found.found.unwrap_or_else(|| panic!("{:?}", found.trouble));
    assert_eq!(found.identity, "OPC UA server SINUMERIK, no encryption, SINUMERIK with 5 machine axes");
    let lines = Roles::default().table(driver, &found);
    let reported = parse_devices("pasted", &lines).expect_err("the axes are to be filled in").to_string();
    assert!(reported.contains("letters of X, Y, Z, A, B, C"), "{reported}");
    parse_devices("pasted", &lines.replace('?', "XYZBC")).expect("a configuration");
    controller.shutdown().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn positions_are_those_of_the_moment_of_the_stamp() {
    let clock = DeviceClock::steady(2.0, 50.0);
    let (controller, url) = controller(clock).await;
    let table = format!(
        "[[device]]\nname = \"cnc\"\ndriver = \"opcua\"\nurl = \"{url}\"\nlayout = \"sinumerik\"\naxes = \"XYZBC\"\n"
    );
    let devices = parse_devices("test.toml", &table).expect("the configuration is good");
    let mut acquisition =
        start(devices, Arc::new(SystemClock::start()), CancellationToken::new(), QUEUE_LENGTH);
    let (mut axes, mut programs) = (Vec::<AxisReading>::new(), Vec::new());
    let deadline = tokio::time::Instant::now() + LIMIT;
    while axes.len() < 300 || programs.is_empty() {
        let next = tokio::time::timeout_at(deadline, acquisition.messages.recv());
        let message = next.await.expect("readings come in time").expect("the acquisition runs");
        match message.reading {
            Reading::Axes(reading) => axes.push(reading),
            Reading::Controller(now) if now.execution == Execution::Active => programs.push(now),
            _ => {}
        }
    }
    acquisition.stop().await;
    controller.shutdown().await;
    let mut farthest = 0.0_f64;
    for reading in axes.iter().filter(|reading| !reading.held) {
        let t_s = clock.cell_s((reading.stamp_ns - WALL_NS) as f64 / 1e9);
        let there = Steady.axes(t_s);
        for letter in AXES {
            farthest = farthest.max((reading.position[letter] - there[letter]).abs());
        }
    }
    // 50 mm/s in the 100 ns that a stamp is rounded to.
    assert!(farthest < 10e-6, "{farthest} mm or rad");
    let skew_ns = axes.iter().map(|reading| reading.skew_ns).max();
    assert!(
        skew_ns.is_some_and(|skew_ns| skew_ns >= 1_000_000),
        "the axes are sampled 1 ms apart: {skew_ns:?} ns"
    );
    assert_eq!((programs[0].program.as_str(), programs[0].block.as_str()), ("O1", "N7"));
}

/// The readings go on as soon as the server has values again.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_value_that_was_not_measured_is_a_gap_with_its_reason_and_no_position() {
    for without_link in WithoutLink::ALL {
        let says = match without_link {
            WithoutLink::BadNull => "the server has no value for axis X (BadNoCommunication)",
            WithoutLink::BadNumber => "the server has no value for axis X (BadSensorFailure)",
            WithoutLink::Substitute => {
                "the server is not certain of the value of axis X (UncertainSubstituteValue)"
            }
            WithoutLink::Null => "the server sends Null for axis X",
            WithoutLink::NotANumber => "the server sends no number for axis X",
        };
        let config =
            ControllerConfig { without_link, ..ControllerConfig::new(WALL_NS, DeviceClock::default()) };
        let (controller, url) = controller_in(config).await;
        let table = format!(
            "[[device]]\nname = \"cnc\"\ndriver = \"opcua\"\nurl = \"{url}\"\nlayout = \"sinumerik\"\naxes = \"XYZBC\"\n\
             silence_ms = 10000\n"
        );
        let devices = parse_devices("test.toml", &table).expect("the configuration is good");
        let mut acquisition =
            start(devices, Arc::new(SystemClock::start()), CancellationToken::new(), QUEUE_LENGTH);
        let (mut axes, mut gap, mut after) = (Vec::<AxisReading>::new(), None, 0);
        let deadline = tokio::time::Instant::now() + LIMIT;
        while after < 50 {
            let next = tokio::time::timeout_at(deadline, acquisition.messages.recv());
            let message =
                next.await.unwrap_or_else(|_| panic!("{without_link:?}: no readings after {gap:?}"));
            match message.expect("the acquisition runs").reading {
                Reading::Axes(reading) => {
                    axes.push(reading);
                    after += usize::from(gap.is_some());
                    if axes.len() == 50 {
                        controller.inject(Fault::Silence { duration_s: 0.5 }).expect("it can have it");
                    }
                }
                Reading::Gap(found) => gap = Some(found),
                _ => {}
            }
        }
        let ends = acquisition.states[0].borrow().ends.iter().sum::<u64>();
        acquisition.stop().await;
        controller.shutdown().await;
        let gap = gap.expect("it was waited for");
        let is_of = |axis: &Joint| gap.reason == says.replace("axis X", &format!("axis {axis}"));
        assert!(AXES.iter().any(is_of), "{without_link:?}: {}", gap.reason);
        let length_s = (gap.to.0 - gap.from.0) as f64 * 1e-9;
        assert!((0.3..5.0).contains(&length_s), "{without_link:?}: {length_s} s");
        assert_eq!(ends, 0, "{without_link:?}: the session went on");
        // One that is carried on by our clock is off by what the axes move meanwhile.
        for reading in axes.iter().filter(|reading| !reading.held) {
            let there = Steady.axes((reading.stamp_ns - WALL_NS) as f64 * 1e-9);
            let farthest = AXES.into_iter().map(|axis| (reading.position[axis] - there[axis]).abs());
            let farthest = farthest.fold(0.0, f64::max);
            assert!(farthest < 1e-5, "{without_link:?}: off by {farthest}: {reading:?}");
        }
    }
}

/// On one thread, so that everything is logged to this test.
#[tokio::test]
async fn a_user_is_let_in_by_the_password_of_its_file_and_no_log_has_it() {
    const PASSWORD: &str = "op8Zw3xRk6Dt";
    let (log, logging) = Log::begin(LevelFilter::TRACE);
    let login = Some(("cell".into(), PASSWORD.into()));
    let config = ControllerConfig { login, ..ControllerConfig::new(WALL_NS, DeviceClock::default()) };
    let (controller, url) = controller_in(config).await;
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("opcua-password");
    std::fs::write(&file, format!("{PASSWORD}7\n")).expect("written");
    let table = format!(
        "[[device]]\nname = \"cnc\"\ndriver = \"opcua\"\nurl = \"{url}\"\nlayout = \"sinumerik\"\naxes = \"XYZBC\"\n\
         user = \"cell\"\npassword_file = '{}'\n",
        file.display()
    );
    let devices = parse_devices("test.toml", &table).expect("the configuration is good");
    let mut acquisition =
        start(devices, Arc::new(SystemClock::start()), CancellationToken::new(), QUEUE_LENGTH);
    let mut state = acquisition.states[0].clone();
    let mut is = async |wanted: DeviceState| {
        let waited = tokio::time::timeout(LIMIT, state.wait_for(|status| status.state == wanted)).await;
        waited.expect("in time").expect("it runs").clone()
    };
    let refused = is(DeviceState::Refused).await;
    let end = refused.last_end.map(|end| end.to_string()).unwrap_or_default();
    assert!(end.contains("does not let cell in") && !end.contains(PASSWORD), "{end}");
    std::fs::write(&file, format!("{PASSWORD}\n")).expect("written");
    is(DeviceState::Streaming).await;
    while let Ok(message) = acquisition.messages.try_recv() {
        assert!(!format!("{message:?}").contains(PASSWORD), "{message:?}");
    }
    acquisition.stop().await;
    controller.shutdown().await;
    drop(logging);
    let log = log.text();
    assert!(log.contains("TRACE") && log.contains("opcua"), "{log}");
    for (coding, text) in forms(PASSWORD) {
        assert!(!log.contains(&text), "{coding}: {log}");
    }
}
