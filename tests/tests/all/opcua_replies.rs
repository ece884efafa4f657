//! Messages of an OPC UA server that are late, doubled, lost, merged or cut: the controller is read in the end, no position is wrong,
//! and nothing is missing in silence.

use crate::opcua_controller::{AXES, LIMIT, Steady, WALL_NS};
use std::sync::Arc;
use std::time::Instant;
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, SessionEnd, parse_devices, start};
use trunnion_core::reading::{AxisReading, Reading, SourceGap};
use trunnion_hil_sim::devices::opcua::{ControllerConfig, Disturbed};
use trunnion_hil_sim::devices::{DeviceClock, Handle, ReplyFault, TimeOrigin, World, opcua};
use trunnion_hil_sim::replies;
use trunnion_service::clock::SystemClock;

/// Controllers at once: each has a server.
const AT_ONCE: usize = 4;
/// Read for so long after the disturbed message: it is late, the session ends, the next one reads.
const AFTER_S: f64 = 4.0;
/// Positions come every 10 ms: what lies farther apart is a hole, but for what a busy computer holds up.
const HOLE_S: f64 = 0.25;

struct Bench {
    controller: Handle,
    network: Disturbed,
    acquisition: Acquisition,
}

async fn bench(case: (u64, ReplyFault)) -> Bench {
    let origin = TimeOrigin(tokio::time::Instant::now());
    let config = ControllerConfig::new(WALL_NS, DeviceClock::default());
    let controller = opcua::spawn(Arc::new(Steady), config, origin, &[]).await.unwrap();
    let server =
        controller.url().unwrap().trim_start_matches("opc.tcp://").trim_end_matches('/').parse().unwrap();
    let network = Disturbed::start(server, case).await.unwrap();
    let table = format!(
        "[[device]]\nname = \"cnc\"\ndriver = \"opcua\"\nurl = \"opc.tcp://{}\"\nlayout = \"sinumerik\"\naxes = \"XYZBC\"\n\
         silence_ms = 1000\n",
        network.address
    );
    let devices = parse_devices("test.toml", &table).unwrap();
    let acquisition = start(devices, Arc::new(SystemClock::start()), CancellationToken::new(), QUEUE_LENGTH);
    Bench { controller, network, acquisition }
}

fn stamp_s(axes: &AxisReading) -> f64 {
    (axes.stamp_ns - WALL_NS) as f64 * 1e-9
}

impl Bench {
    /// Readings, each with its session, and gaps.
    async fn read_on(&mut self, case: (u64, ReplyFault)) -> (Vec<(u32, AxisReading)>, Vec<SourceGap>) {
        let (mut axes, mut gaps): (Vec<(u32, AxisReading)>, _) = (Vec::new(), Vec::new());
        let (begun, mut passed_s) = (Instant::now(), None);
        loop {
            assert!(begun.elapsed() < LIMIT, "{case:?}: {:?}", self.acquisition.states[0].borrow());
            let message = tokio::time::timeout(LIMIT, self.acquisition.messages.recv()).await;
            let message = message.unwrap().unwrap();
            match message.reading {
                Reading::Axes(reading) => axes.push((message.epoch, reading)),
                Reading::Gap(gap) => gaps.push(gap),
                _ => {}
            }
            let Some(now_s) = axes.last().map(|(_, reading)| stamp_s(reading)) else { continue };
            if self.network.passed() > case.0 && now_s > *passed_s.get_or_insert(now_s) + AFTER_S {
                return (axes, gaps);
            }
        }
    }
}

fn check(case: (u64, ReplyFault), axes: &[(u32, AxisReading)], gaps: &[SourceGap]) {
    let forward = |a: &(u32, AxisReading), b: &(u32, AxisReading)| a.0 < b.0 || a.1.stamp_ns < b.1.stamp_ns;
    assert!(axes.is_sorted_by(forward), "{case:?}: a stamp goes back");
    let axes: Vec<AxisReading> = axes.iter().map(|(_, reading)| *reading).collect();
    let farthest = |reading: &AxisReading| {
        let there = Steady.axes(stamp_s(reading));
        AXES.into_iter().map(|letter| (reading.position[letter] - there[letter]).abs()).fold(0.0, f64::max)
    };
    for reading in axes.iter().filter(|reading| !reading.held) {
        assert!(farthest(reading) < 1e-5, "{case:?}: off by {}: {reading:?}", farthest(reading));
    }
    // Both clocks run at one rate; the quickest arrival shows how far they are apart.
    let apart_s = |reading: &AxisReading| reading.arrival.0 as f64 * 1e-9 - stamp_s(reading);
    let apart_s = axes.iter().map(apart_s).fold(f64::INFINITY, f64::min);
    for pair in axes.windows(2) {
        let [from_s, to_s] = [0, 1].map(|k| stamp_s(&pair[k]) + apart_s);
        let is_in = |gap: &SourceGap| {
            gap.from.0 as f64 * 1e-9 < from_s + HOLE_S && gap.to.0 as f64 * 1e-9 > to_s - HOLE_S
        };
        let is_hole = to_s - from_s > HOLE_S;
        assert!(
            !is_hole || gaps.iter().any(is_in),
            "{case:?}: {from_s} to {to_s} s is in no gap of {gaps:?}"
        );
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_message_that_is_late_doubled_lost_merged_or_cut_disables_a_server() {
    let room = Arc::new(Semaphore::new(AT_ONCE));
    let mut running = JoinSet::new();
    for case in replies::OPCUA.faults() {
        let room = Arc::clone(&room);
        running.spawn(async move {
            let _place = room.acquire().await.unwrap();
            let mut bench = bench(case).await;
            let (axes, gaps) = bench.read_on(case).await;
            let status = bench.acquisition.states[0].borrow().clone();
            bench.acquisition.stop().await;
            bench.controller.shutdown().await;
            check(case, &axes, &gaps);
            let wrong = SessionEnd::WrongDevice { found: String::new(), expected: String::new() }.kind();
            assert_eq!(status.ends[wrong], 0, "{case:?}: {status:?}");
            assert!(status.ends.iter().sum::<u64>() <= 1, "{case:?}: {status:?}");
        });
    }
    while let Some(ended) = running.join_next().await {
        ended.unwrap();
    }
}
