//! Controllers that are asked over the network: positions with true stamps, and what each fault leads to.

use crate::shop::{PROGRAM, SinceStart, find, program, read, state, turning};
use std::sync::Arc;
use std::time::Instant;
use trunnion_acquire::{Acquisition, DeviceState, DeviceStatus};
use trunnion_core::AxisValues;
use trunnion_core::axis::iso::{B, C, X};
use trunnion_core::reading::{AxisReading, Execution, Reading, SourceGap};
use trunnion_hil_sim::devices::linuxcncrsh::ServerConfig;
use trunnion_hil_sim::devices::mtconnect::AgentConfig;
use trunnion_hil_sim::devices::{
    DeviceClock, Fault, Handle, SimulatedCell, TimeOrigin, World, linuxcncrsh, mtconnect,
};
use trunnion_hil_sim::motion::Step;
use trunnion_hil_sim::replies;

/// C goes to and fro, a block each 50 ms, for a minute.
fn many_blocks() -> Vec<Step> {
    let pose = |c_rad: f64| {
        let mut target = AxisValues::default();
        (target[X], target[B], target[C]) = (100.0, 0.25, c_rad);
        Step::Move { target, duration_s: 0.05 }
    };
    (0..600).flat_map(|k| [pose(f64::from(k % 2) * 1e-2 + 1e-3), Step::Dwell { duration_s: 0.05 }]).collect()
}

struct Bench {
    world: Arc<SimulatedCell>,
    server: Handle,
    acquisition: Acquisition,
}

/// Host time 0 is time 0 of the cell.
async fn bench(config: ServerConfig, keys: &str) -> Bench {
    bench_in(turning(), config, keys).await
}

async fn bench_in(world: Arc<SimulatedCell>, config: ServerConfig, keys: &str) -> Bench {
    let origin = Instant::now();
    let server = linuxcncrsh::spawn(world.clone(), config, TimeOrigin(origin.into()), &[]).await.unwrap();
    let port = server.address().to_string().rsplit_once(':').unwrap().1.to_owned();
    let text = format!(
        "[[device]]\nname = \"cnc\"\ndriver = \"linuxcnc\"\nhost = \"127.0.0.1\"\nport = {port}\n{keys}"
    );
    let acquisition = read(&text, Arc::new(SinceStart(origin)));
    Bench { world, server, acquisition }
}

/// The same world behind an MTConnect agent.
async fn agent_bench(world: Arc<SimulatedCell>) -> Bench {
    agent_bench_in(world, None, "").await
}

/// The same behind an agent that asks for this login, with further keys of the device.
async fn agent_bench_in(world: Arc<SimulatedCell>, login: Option<(&str, &str)>, keys: &str) -> Bench {
    let origin = Instant::now();
    let login = login.map(|(user, password)| (user.to_owned(), password.to_owned()));
    let config = AgentConfig { login, ..AgentConfig::new(1_767_225_600_000_000_000, DeviceClock::default()) };
    let server = mtconnect::spawn(world.clone(), config, TimeOrigin(origin.into()), &[]).await.unwrap();
    let url = server.address().to_string();
    let text = format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n{keys}");
    let acquisition = read(&text, Arc::new(SinceStart(origin)));
    Bench { world, server, acquisition }
}

const JOINTS: &str = "joints = \"XYZBC\"\nsilence_ms = 300\n";

impl Bench {
    async fn find<T>(&mut self, pick: impl Fn(&Reading) -> Option<T>) -> T {
        find(&mut self.acquisition, pick).await
    }

    async fn status(&self, fits: impl Fn(&DeviceStatus) -> bool) -> DeviceStatus {
        state(&self.acquisition, fits).await
    }

    async fn axes(&mut self) -> AxisReading {
        self.find(|reading| if let Reading::Axes(axes) = reading { Some(*axes) } else { None }).await
    }

    /// The first gap whose reason has this word.
    async fn gap(&mut self, word: &str) -> SourceGap {
        let gap = |reading: &Reading| match reading {
            Reading::Gap(gap) if gap.reason.contains(word) => Some(gap.clone()),
            _ => None,
        };
        self.find(gap).await
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn positions_of_linuxcnc_bear_the_time_at_which_they_appeared() {
    let cycle_s = 0.01;
    let mut bench = bench(ServerConfig { cycle_s, ..Default::default() }, JOINTS).await;
    let identity = bench.status(|status| !status.identity.is_empty()).await.identity;
    assert_eq!(identity, "linuxcncrsh EMCNETSVR 1.1, joints X Y Z B C");
    let controller = bench
        .find(|reading| match reading {
            Reading::Controller(controller) => Some(controller.clone()),
            _ => None,
        })
        .await;
    assert_eq!(controller.execution, Execution::Active);
    assert_eq!(controller.program, PROGRAM);
    // The farthest of 200 positions while C turns at 1 rad/s from where it was at the stamp.
    let (mut seen, mut farthest_rad) = (0, 0.0_f64);
    while seen < 200 {
        let axes =
            bench.find(|reading| if let Reading::Axes(axes) = reading { Some(*axes) } else { None }).await;
        let t_s = axes.stamp_ns as f64 / 1e9;
        if t_s < 1.0 {
            continue;
        }
        assert!((axes.position[X] - 100.0).abs() < 1e-5 && (axes.position[B] - 0.25).abs() < 1e-5);
        assert!(axes.present[C] && !axes.present[trunnion_core::Joint::A]);
        // A busy machine may hold a request up; then the middle of the two requests lies that far off.
        let held_up_s = (axes.arrival.0 - axes.stamp_ns) as f64 / 1e9;
        let off_rad = (bench.world.axes(t_s)[C] - axes.position[C]).abs();
        assert!(off_rad <= cycle_s + 2.0 * held_up_s + 0.004, "{off_rad} rad, {held_up_s} s");
        farthest_rad = farthest_rad.max(off_rad);
        seen += 1;
    }
    println!("farthest {:.1} ms", farthest_rad * 1e3);
    bench.acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_fault_of_linuxcnc_is_reported_recorded_and_recovered_from() {
    let cases = [
        (Fault::Silence { duration_s: 1.0 }, DeviceState::Silent, "does not answer"),
        (Fault::Unplug { duration_s: 1.0 }, DeviceState::Absent, "127.0.0.1"),
        (Fault::AgentRestart, DeviceState::Failed, "disconnected"),
        (Fault::GarbleBytes { count: 60 }, DeviceState::Failed, "asking LinuxCNC"),
    ];
    for (fault, expected, words) in cases {
        let mut bench = bench(ServerConfig::default(), JOINTS).await;
        bench.find(|reading| matches!(reading, Reading::Axes(_)).then_some(())).await;
        bench.server.inject(fault).unwrap();
        // Garbage can also end a line too late to be an answer in time.
        let ended = |status: &DeviceStatus| {
            status.state == expected
                || (expected == DeviceState::Failed && status.state == DeviceState::Silent)
        };
        bench.status(ended).await;
        let gap = bench.gap("").await;
        assert!(gap.to > gap.from && gap.source == "cnc", "{fault:?}: {gap:?}");
        let status = bench.status(|status| status.state == DeviceState::Streaming).await;
        let end = status.last_end.unwrap().to_string();
        assert!(end.contains(words) || end.contains("does not answer"), "{fault:?}: {end}");
        bench.acquisition.stop().await;
        bench.server.shutdown().await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn answers_of_linuxcnc_mixed_with_another_connections_are_asked_again() {
    let mut bench = bench(ServerConfig { mixed_every: 3, ..Default::default() }, JOINTS).await;
    for _ in 0..50 {
        let axes = bench.axes().await;
        assert!(axes.present[C] && (axes.position[X] - 100.0).abs() < 1e-5, "{axes:?}");
    }
    let status = bench.status(|status| status.state == DeviceState::Streaming).await;
    assert_eq!((status.epoch, status.last_end), (1, None), "the connection is kept");
    bench.acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn another_linuxcnc_a_wrong_password_and_another_program_are_refused_with_what_to_do() {
    let mut bench1 = bench(ServerConfig::default(), JOINTS).await;
    bench1.find(|reading| matches!(reading, Reading::Axes(_)).then_some(())).await;
    bench1.server.inject(Fault::WrongIdentity).unwrap();
    let status = bench1.status(|status| status.state == DeviceState::WrongDevice).await;
    let end = status.last_end.unwrap().to_string();
    assert!(
        end.contains("joint 3 is in MM") && end.contains("axis B") && end.contains("COORDINATES"),
        "{end}"
    );

    let bench2 = bench(ServerConfig { password: "SECRET".into(), ..Default::default() }, JOINTS).await;
    let status = bench2.status(|status| status.state == DeviceState::Refused).await;
    assert!(status.last_end.unwrap().to_string().contains("-w of linuxcncrsh"));

    let keys = "joints = \"XYZBC\"\nserver = \"MILL-2\"\n";
    let bench3 = bench(ServerConfig::default(), keys).await;
    let status = bench3.status(|status| status.state == DeviceState::WrongDevice).await;
    let end = status.last_end.unwrap().to_string();
    assert!(end.contains("EMCNETSVR") && end.contains("MILL-2"), "{end}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_agent_that_asks_for_a_user_is_read_with_its_password_and_says_what_to_do_without() {
    const LOGIN: Option<(&str, &str)> = Some(("cell", "a:b \u{fc}"));
    let refused = async |keys: &str, words: &str| {
        let bench = agent_bench_in(turning(), LOGIN, keys).await;
        let status = bench.status(|status| status.state == DeviceState::Refused).await;
        let end = status.last_end.unwrap().to_string();
        assert!(end.contains(words), "{end}");
        bench.acquisition.stop().await;
    };
    refused("", "the agent asks for a user and a password: give `user` and `password_file`").await;
    let other = "user = \"other\"\npassword = \"a:b \u{fc}\"\n";
    refused(other, "the agent refuses user other: check `user` and `password_file`").await;

    // The file is mended while the device is tried again.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("agent-password");
    std::fs::write(&file, "wrong\n").unwrap();
    let keys = format!("user = \"cell\"\npassword_file = '{}'\n", file.display());
    let mut bench = agent_bench_in(turning(), LOGIN, &keys).await;
    let status = bench.status(|status| status.state == DeviceState::Refused).await;
    let end = status.last_end.unwrap().to_string();
    assert!(end.contains("the agent refuses user cell") && !end.contains("wrong"), "{end}");
    std::fs::write(&file, "a:b \u{fc}\n").unwrap();
    bench.axes().await;
    bench.status(|status| status.state == DeviceState::Streaming).await;
    bench.acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn observations_that_an_agent_lost_are_counted_in_a_gap() {
    let mut bench = agent_bench(turning()).await;
    bench.axes().await;
    bench.server.inject(Fault::CounterJump { by: 500 }).unwrap();
    let gap = bench.gap("OUT_OF_RANGE").await;
    assert!(gap.lost_readings.unwrap() >= 500, "{gap:?}");
    bench.axes().await;
    assert_eq!(bench.acquisition.states[0].borrow().state, DeviceState::Streaming);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_controller_whose_clock_is_set_goes_on_being_read_and_a_warning_says_by_how_much() {
    for by_s in [-20.0, 20.0] {
        let mut bench = agent_bench(turning()).await;
        let before = bench.axes().await;
        bench.server.inject(Fault::ClockJump { by_s }).unwrap();
        let warning = bench
            .find(|reading| match reading {
                Reading::Log(line) if line.warning => Some(line.text.clone()),
                _ => None,
            })
            .await;
        let tens = if by_s < 0.0 { "set by -" } else { "set by +" };
        assert!(warning.contains(tens), "{warning}");
        let after = bench.axes().await;
        let shown_s = (after.stamp_ns - before.stamp_ns) as f64 / 1e9;
        let passed_s = after.arrival.seconds_since(before.arrival);
        assert!((shown_s - passed_s - by_s).abs() < 2.0, "{shown_s} s in {passed_s} s");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn another_machine_behind_the_same_address_is_not_read() {
    let mut bench = agent_bench(turning()).await;
    bench.axes().await;
    bench.server.inject(Fault::WrongIdentity).unwrap();
    let status = bench.status(|status| status.state == DeviceState::WrongDevice).await;
    let end = status.last_end.unwrap().to_string();
    assert!(end.contains("VMC-OTHER") && end.contains("first connection"), "{end}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn positions_that_stick_while_the_program_goes_on_are_reported_and_recorded() {
    let linuxcnc = bench_in(program(many_blocks()), ServerConfig::default(), JOINTS).await;
    let agent = agent_bench(program(many_blocks())).await;
    for mut bench in [linuxcnc, agent] {
        bench.axes().await;
        bench.server.inject(Fault::StuckValue { duration_s: 4.0 }).unwrap();
        bench.status(|status| status.state == DeviceState::Stuck).await;
        let gap = bench.gap("stuck").await;
        assert!(gap.to.seconds_since(gap.from) > 2.0, "{gap:?}");
        bench.status(|status| status.state == DeviceState::Streaming).await;
    }
}

/// Every reply from the first on, each late, doubled, missing and together with the next: the controller streams in the end, and no
/// answer is taken for that of the question before.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_reply_of_linuxcnc_that_is_late_doubled_lost_or_merged_disables_it_or_is_taken_for_another() {
    let mut running = tokio::task::JoinSet::new();
    for fault in replies::LINUXCNC.faults() {
        running.spawn(async move {
            let config = ServerConfig { reply_fault: Some(fault), ..ServerConfig::default() };
            // An answer of the question before is 50 ms old.
            let keys = "joints = \"XYZBC\"\nsilence_ms = 300\nrate_hz = 20\n";
            let mut bench = bench(config, keys).await;
            let mut seen = 0;
            while seen < 40 {
                let axes = bench.axes().await;
                let t_s = axes.stamp_ns as f64 / 1e9;
                let held_up_s = (axes.arrival.0 - axes.stamp_ns) as f64 / 1e9;
                // C turns forward. A position bears the middle between two questions, and is that of the later one, up to a
                // task cycle of 10 ms old; that of the question before would be 25 ms behind its stamp.
                let ahead_rad = axes.position[C] - bench.world.axes(t_s)[C];
                assert!(ahead_rad > -0.012 - held_up_s, "{fault:?}: {ahead_rad} rad, {held_up_s} s");
                seen += 1;
            }
            let status = bench.status(|status| status.state == DeviceState::Streaming).await;
            assert!(status.ends.iter().sum::<u64>() <= 1, "{fault:?}: {status:?}");
            bench.acquisition.stop().await;
        });
    }
    running.join_all().await;
}
