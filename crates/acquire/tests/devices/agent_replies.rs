//! Documents of an MTConnect agent that are late, doubled, lost, merged or cut.

use crate::shop::{LIMIT, SinceStart, next, read, turning};
use std::sync::Arc;
use std::time::Instant;
use trunnion_acquire::{Acquisition, SessionEnd};
use trunnion_core::axis::iso::{B, C, X};
use trunnion_core::reading::{AxisReading, Reading, SourceGap};
use trunnion_hil_sim::devices::mtconnect::AgentConfig;
use trunnion_hil_sim::devices::{DeviceClock, Handle, ReplyFault, TimeOrigin, World, mtconnect};
use trunnion_hil_sim::replies;

/// Agents at once; the others wait, for a busy computer makes them silent.
const AT_ONCE: usize = 6;
/// The controller's clock at time 0 of cell and host.
const WALL_NS: i64 = 1_767_225_600_000_000_000;
/// Read until the fault is over: late replies, a session given up, the next one.
const UNTIL_S: f64 = 6.0;
/// Positions come every 8 ms: what lies farther apart is a hole. A busy computer holds simulated lines up by some tens of milliseconds.
const HOLE_S: f64 = 0.2;
/// C stands until then.
const TURNS_S: f64 = 0.5;

async fn agent(world: &Arc<dyn World>, fault: (u64, ReplyFault)) -> (Handle, Acquisition) {
    let origin = Instant::now();
    let config =
        AgentConfig { reply_fault: Some(fault), ..AgentConfig::new(WALL_NS, DeviceClock::default()) };
    let agent = mtconnect::spawn(Arc::clone(world), config, TimeOrigin(origin.into()), &[]).await.unwrap();
    let text = format!(
        "[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{}\"\nsilence_ms = 500\n",
        agent.address()
    );
    (agent, read(&text, Arc::new(SinceStart(origin))))
}

fn stamp_s(axes: &AxisReading) -> f64 {
    (axes.stamp_ns - WALL_NS) as f64 * 1e-9
}

/// Readings, each with its session, and gaps until positions of [`UNTIL_S`] come.
async fn read_on(acquisition: &mut Acquisition) -> (Vec<(u32, AxisReading)>, Vec<SourceGap>) {
    let (mut axes, mut gaps): (Vec<(u32, AxisReading)>, _) = (Vec::new(), Vec::new());
    let begun = Instant::now();
    while axes.last().is_none_or(|(_, last)| stamp_s(last) < UNTIL_S) {
        assert!(begun.elapsed() < LIMIT, "it does not come back: {:?}", acquisition.states[0].borrow());
        let message = next(acquisition).await;
        match message.reading {
            Reading::Axes(reading) => axes.push((message.epoch, reading)),
            Reading::Gap(gap) => gaps.push(gap),
            _ => {}
        }
    }
    (axes, gaps)
}

fn check(world: &dyn World, case: (u64, ReplyFault), axes: &[(u32, AxisReading)], gaps: &[SourceGap]) {
    let stamps: Vec<f64> = axes.iter().map(|(_, reading)| stamp_s(reading)).collect();
    // A new session begins with the last change that the agent knows.
    let forward = |a: &(u32, AxisReading), b: &(u32, AxisReading)| a.0 < b.0 || a.1.stamp_ns < b.1.stamp_ns;
    assert!(axes.is_sorted_by(forward), "{case:?}: a stamp goes back");
    for ((_, reading), t_s) in axes.iter().zip(&stamps) {
        let truth = world.axes(*t_s);
        let off_rad = (truth[C] - reading.position[C]).abs();
        // Held positions are those before the next line of the controller.
        let allowed_rad = if reading.held { 0.05 } else { 1e-5 };
        let stands = (reading.position[X] - 100.0).abs() < 1e-3 && (reading.position[B] - 0.25).abs() < 1e-5;
        assert!(stands && off_rad < allowed_rad, "{case:?}: {off_rad} rad at {t_s} s: {reading:?}");
    }
    // While C stands, positions are held as long after their stamp as after their arrival.
    let moving: Vec<f64> =
        std::iter::once(TURNS_S).chain(stamps.into_iter().filter(|t_s| *t_s > TURNS_S)).collect();
    for hole in moving.windows(2).filter(|pair| pair[1] - pair[0] > HOLE_S) {
        let is_in = |gap: &&SourceGap| {
            let (from_s, to_s) = (gap.from.0 as f64 * 1e-9, gap.to.0 as f64 * 1e-9);
            from_s < hole[0] + HOLE_S && to_s > hole[1] - HOLE_S
        };
        assert!(gaps.iter().any(|gap| is_in(&gap)), "{case:?}: {hole:?} is in no gap of {gaps:?}");
    }
}

/// Every document, each late, doubled, missing, together with the next and cut: the agent is read in the end, no position is wrong, and
/// nothing is missing in silence.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_document_that_is_late_doubled_lost_merged_or_cut_disables_an_agent() {
    let room = Arc::new(tokio::sync::Semaphore::new(AT_ONCE));
    let mut running = tokio::task::JoinSet::new();
    for case in replies::MTCONNECT.faults() {
        let room = Arc::clone(&room);
        running.spawn(async move {
            let _place = room.acquire().await.unwrap();
            let world: Arc<dyn World> = turning();
            let (_agent, mut acquisition) = agent(&world, case).await;
            let (axes, gaps) = read_on(&mut acquisition).await;
            let status = acquisition.states[0].borrow().clone();
            acquisition.stop().await;
            check(world.as_ref(), case, &axes, &gaps);
            let wrong = SessionEnd::WrongDevice { found: String::new(), expected: String::new() }.kind();
            assert_eq!(status.ends[wrong], 0, "{case:?}: {status:?}");
            let (ends, (_, fault)) = (status.ends.iter().sum::<u64>(), case);
            let most_ends =
                u64::from(!(matches!(fault, ReplyFault::Doubled | ReplyFault::Merged) && case.0 >= 2));
            assert!(ends <= most_ends, "{case:?}: {status:?}");
        });
    }
    while let Some(ended) = running.join_next().await {
        ended.unwrap();
    }
}
