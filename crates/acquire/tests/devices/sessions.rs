//! Sessions under their supervisor, time bases and alignment on a floor of virtual devices.

use crate::shop::{
    LIMIT, PROGRAM, SinceStart, deflection_mm, gap_of_the_next_connection, next, read_queued, state,
    state_of, turning, until_message,
};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceState, SessionEnd};
use trunnion_core::HostTime;
use trunnion_core::axis::iso::{B, C, X};
use trunnion_core::reading::{Execution, Message, ProbeReading, Reading};
use trunnion_hil_sim::devices::canopen::BusConfig;
use trunnion_hil_sim::devices::cell::{Cell, CellConfig};
use trunnion_hil_sim::devices::{DeviceClock, Fault, SimulatedCell, World, cell, orthogonal_nest};
use trunnion_hil_sim::replies;
use trunnion_sync::align::{AlignLimits, Aligner};
use trunnion_sync::{TimeBase, Timed};

/// A whole floor of virtual devices.
pub struct Floor {
    world: Arc<SimulatedCell>,
    cell: Cell,
    pub directory: tempfile::TempDir,
    pub clock: Arc<SinceStart>,
}

async fn floor(change: impl FnOnce(&mut CellConfig)) -> Floor {
    floor_in(turning(), change).await
}

pub async fn floor_in(world: Arc<SimulatedCell>, change: impl FnOnce(&mut CellConfig)) -> Floor {
    let directory = tempfile::tempdir().unwrap();
    let mut config = CellConfig::new(directory.path(), 1_767_225_600_000_000_000);
    change(&mut config);
    let origin = Instant::now();
    let cell = cell::start(world.clone(), config, origin.into()).await.unwrap();
    Floor { world, cell, directory, clock: Arc::new(SinceStart(origin)) }
}

impl Floor {
    pub fn start(&self, text: &str, queue_length: usize) -> Acquisition {
        let text = text.replace("{dir}", self.directory.path().to_str().unwrap());
        let url = self.cell.controller.as_ref().and_then(|agent| agent.url()).unwrap_or_default();
        read_queued(&text.replace("{url}", url), self.clock.clone(), queue_length)
    }
}

pub const PROBE: &str = r#"
[[device]]
name = "probe-1"
driver = "optoncdt"
port = "{dir}/probe-1"
role = "probe-1"
range_mm = 2
"#;

pub const AGENT: &str = r#"
[[device]]
name = "cnc"
driver = "mtconnect"
url = "{url}"
"#;

fn is_probe(message: &Message) -> bool {
    matches!(message.reading, Reading::Probe(_))
}

fn only_probe(config: &mut CellConfig) {
    config.probes.truncate(1);
    (config.can, config.controller) = (None, None);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pulled_cable_is_a_gap_and_the_device_is_read_again_when_it_is_back() {
    let floor = floor(only_probe).await;
    let mut acquisition = floor.start(PROBE, QUEUE_LENGTH);
    until_message(&mut acquisition, is_probe).await;
    let streaming = state(&acquisition, |status| status.state == DeviceState::Streaming).await;
    assert!(streaming.identity.contains("ILD1420-2 serial 21050001"), "{}", streaming.identity);

    floor.cell.probes[0].inject(Fault::Unplug { duration_s: 1.0 }).unwrap();
    let gap = gap_of_the_next_connection(&mut acquisition, is_probe).await;
    let seconds = (gap.to - gap.from).as_secs_f64();
    assert!((0.9..10.0).contains(&seconds), "{gap:?}");
    let status = state(&acquisition, |status| status.state == DeviceState::Streaming).await;
    let disconnected = SessionEnd::Disconnected(String::new()).kind();
    assert_eq!(status.ends[disconnected], 1, "{status:?}");
    let states = acquisition.states[0].clone();
    acquisition.stop().await;
    assert_eq!(states.borrow().state, DeviceState::Stopped);
}

#[tokio::test(flavor = "multi_thread")]
async fn garbage_is_counted_lost_values_are_a_gap_and_silence_ends_the_session() {
    let floor = floor(only_probe).await;
    let mut acquisition = floor.start(PROBE, QUEUE_LENGTH);
    until_message(&mut acquisition, is_probe).await;
    floor.cell.probes[0].inject(Fault::GarbleBytes { count: 40 }).unwrap();
    let messages = until_message(&mut acquisition, |m| matches!(m.reading, Reading::Gap(_))).await;
    let Some(Message { reading: Reading::Gap(gap), .. }) = messages.last() else { unreachable!() };
    assert!(gap.lost_readings.is_some_and(|lost| (1..40).contains(&lost)), "{gap:?}");
    let counted = |m: &Message| matches!(m.reading, Reading::Counters(c) if c.damaged + c.dropped_bytes > 0);
    until_message(&mut acquisition, counted).await;

    floor.cell.probes[0].inject(Fault::Silence { duration_s: 1.5 }).unwrap();
    let silent = SessionEnd::Silent { who: String::new(), waited: Duration::ZERO }.kind();
    state(&acquisition, |status| status.ends[silent] > 0).await;
    until_message(&mut acquisition, |message| message.epoch > 1 && is_probe(message)).await;
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_device_is_not_asked_again_at_once_and_an_absent_one_is_waited_for() {
    let floor = floor(only_probe).await;
    let text = PROBE.replace("range_mm = 2", "range_mm = 10")
        + &PROBE.replace("probe-1", "probe-2").replace("range_mm = 2", "range_mm = 2\nsilence_ms = 300");
    let acquisition = floor.start(&text, QUEUE_LENGTH);
    let wrong = state(&acquisition, |status| status.state == DeviceState::WrongDevice).await;
    let Some(SessionEnd::WrongDevice { found, expected }) = &wrong.last_end else { panic!("{wrong:?}") };
    assert!(found.contains("range 2 mm") && expected.contains("range 10 mm"), "{found} {expected}");
    // Three attempts on the absent one take 0.75 s and more: time enough to retry the wrong one.
    // The state may be seen before or after an attempt has ended, so not more than the order of the two is sure.
    let absent = state_of(&acquisition, 1, |status| status.ends[0] >= 3).await;
    assert_eq!(absent.state, DeviceState::Absent);
    assert_eq!(absent.ends.iter().sum::<u64>(), absent.ends[0], "nothing else ended a session: {absent:?}");
    assert!((0..=1).contains(&(u64::from(absent.epoch) - absent.ends[0])), "{absent:?}");
    assert_eq!(acquisition.states[0].borrow().epoch, 1);
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_nobody_takes_is_counted_and_becomes_a_gap() {
    let floor = floor(only_probe).await;
    let mut acquisition = floor.start(PROBE, 64);
    state(&acquisition, |status| status.lost_messages > 100).await;
    let messages = until_message(&mut acquisition, |m| matches!(m.reading, Reading::Gap(_))).await;
    assert_eq!(messages.len(), 65);
    let Some(Message { reading: Reading::Gap(gap), .. }) = messages.last() else { unreachable!() };
    assert!(gap.lost_readings.is_some_and(|lost| lost > 100), "{gap:?}");
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn channels_of_one_bus_share_the_moment_of_their_sync() {
    let floor = floor(|config| {
        config.probes.clear();
        config.controller = None;
        config.can = Some((BusConfig::ball_bar_and_probes(DeviceClock::steady(41.0, -55.0)), Vec::new()));
    })
    .await;
    let text = r#"
[[device]]
name = "bus"
driver = "canopen-slcan"
port = "{dir}/can"
sync_ms = 10
nodes = [{ id = 1, role = "probe-1" }, { id = 2, role = "probe-2" }, { id = 3, role = "probe-3", serial = 1003 },
         { id = 5, role = "bar" }]
"#;
    let mut acquisition = floor.start(text, QUEUE_LENGTH);
    // A busy computer may end a connection; the next one counts its SYNCs again.
    let mut by_sync = BTreeMap::<(u32, u64), Vec<ProbeReading>>::new();
    let (mut whole, mut reported, mut last) = (0, 0, Instant::now());
    while whole < 60 {
        assert!(last.elapsed() < LIMIT, "{whole} of {} SYNCs are whole, then none", by_sync.len());
        let message = next(&mut acquisition).await;
        match message.reading {
            Reading::Probe(reading) => {
                let values = by_sync.entry((message.epoch, reading.sequence)).or_default();
                values.push(reading);
                if values.len() == 4 {
                    (whole, last) = (whole + 1, Instant::now());
                }
            }
            Reading::Gap(gap) => reported += gap.lost_readings.unwrap_or(0),
            _ => {}
        }
    }
    acquisition.stop().await;
    // Of the last SYNC of a connection not all may have come.
    let is_last =
        |&(epoch, sync): &(u32, u64)| by_sync.range((epoch, sync + 1)..(epoch + 1, 0)).next().is_none();
    let missing =
        by_sync.iter().filter(|(sync, _)| !is_last(sync)).map(|(_, values)| 4 - values.len() as u64);
    assert!(
        missing.sum::<u64>() <= reported,
        "values are missing in silence: {reported} reported, {by_sync:?}"
    );
    for ((epoch, sync), values) in &by_sync {
        let moment = values[0].device_ticks;
        assert!(values.iter().all(|value| value.device_ticks == moment), "SYNC {sync}: {values:?}");
        // Zero of the device's time, late by the fastest answer.
        let of_connection = by_sync.range((*epoch, 0)..(*epoch + 1, 0)).flat_map(|(_, values)| values);
        let zero = of_connection.map(|value| value.arrival.0 - value.device_ticks.cast_signed() * 1000).min();
        let sync_s = (zero.unwrap() + moment.cast_signed() * 1000) as f64 * 1e-9;
        for value in values.iter().filter(|value| value.channel < 3) {
            // It was latched between the SYNC and its arrival, and changes by at most 0.1 mm/s.
            let arrival_s = value.arrival.0 as f64 * 1e-9;
            let truths = [sync_s, 0.5 * (sync_s + arrival_s), arrival_s]
                .map(|t_s| floor.world.probe_readings_mm(t_s)[usize::from(value.channel)]);
            let (least, most) = (
                truths.iter().copied().fold(f64::INFINITY, f64::min),
                truths.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            );
            let allowed = least - 0.005..=most + 0.005;
            assert!(allowed.contains(&value.value_mm), "SYNC {sync}: {value:?}, {allowed:?}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn axes_arrive_with_one_stamp_standing_or_moving_and_a_restarted_agent_is_asked_again() {
    let floor = floor(|config| {
        config.probes.clear();
        config.can = None;
    })
    .await;
    let mut acquisition = floor.start(AGENT, QUEUE_LENGTH);
    let moved = |m: &Message| matches!(m.reading, Reading::Axes(a) if a.position[C] > 0.5);
    let messages = until_message(&mut acquisition, moved).await;
    let axes: Vec<_> = messages
        .iter()
        .filter_map(|message| match message.reading {
            Reading::Axes(axes) => Some(axes),
            _ => None,
        })
        .collect();
    for axes in axes.iter().filter(|axes| !axes.held) {
        assert!(
            (axes.position[X] - 100.0).abs() < 1e-3
                && axes.present[B]
                && !axes.present[trunnion_core::Joint::A]
        );
    }
    assert!(axes.windows(2).all(|pair| pair[0].stamp_ns < pair[1].stamp_ns), "stamps go forward");
    let active = |m: &Message| matches!(&m.reading, Reading::Controller(c) if c.execution == Execution::Active && c.program == PROGRAM);
    assert!(messages.iter().any(active));

    floor.cell.controller.as_ref().unwrap().inject(Fault::AgentRestart).unwrap();
    until_message(&mut acquisition, |m| m.epoch > 1 && matches!(m.reading, Reading::Axes(_))).await;
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn probes_and_axes_of_different_clocks_meet_at_one_instant() {
    let floor = floor(|config| config.can = None).await;
    let probes: String = (1..=3).map(|k| PROBE.replace("probe-1", &format!("probe-{k}"))).collect();
    let mut acquisition = floor.start(&(probes + AGENT), QUEUE_LENGTH);
    let mut base = TimeBase::new(HostTime(0));
    let mut aligner = Aligner::new(&[0, 1, 2], AlignLimits::default());
    let mut samples = Vec::new();
    while samples.len() < 3000 {
        let message = next(&mut acquisition).await;
        let mut steps = Vec::new();
        match base.translate(&message) {
            Some(Timed::Probe(sample)) => aligner.push_probe(&sample, &mut steps),
            Some(Timed::Axes(sample)) => aligner.push_axes(&sample, &mut steps),
            _ => {}
        }
        samples.extend(steps.into_iter().filter_map(|step| Some((step.state, step.channels_mm?))));
    }
    acquisition.stop().await;
    // The instants of probes and axes differ by their least delays, some ms: at 1 rad/s some mrad, 0.1 mm/rad.
    let mut errors: Vec<f64> = Vec::new();
    for (state, channels_mm) in samples.iter().skip(1500) {
        let c = state.position[C];
        let deflection = deflection_mm(c);
        for (direction, &measured) in orthogonal_nest().iter().zip(channels_mm) {
            // Reading 0 lies in the middle of the range of 2 mm.
            let expected = 1.0 + (0..3).map(|k| direction[k] * deflection[k]).sum::<f64>();
            errors.push((measured - expected).abs());
        }
    }
    errors.sort_by(f64::total_cmp);
    let worst_of_95 = errors[errors.len() * 95 / 100];
    assert!(worst_of_95 < 0.003, "{worst_of_95} mm");
}

/// Every reply of the start, each late, doubled, missing and together with the next: the probe streams in the end.
#[tokio::test(flavor = "multi_thread")]
async fn no_reply_that_is_late_doubled_lost_or_merged_disables_a_probe() {
    let mut cases = tokio::task::JoinSet::new();
    for fault in replies::OPTONCDT.faults() {
        cases.spawn(async move {
            let floor = floor(|config| {
                only_probe(config);
                config.probes[0].0.reply_fault = Some(fault);
            })
            .await;
            let mut acquisition = floor.start(PROBE, QUEUE_LENGTH);
            until_message(&mut acquisition, is_probe).await;
            let status = state(&acquisition, |status| status.state == DeviceState::Streaming).await;
            let ends: u64 = status.ends.iter().sum();
            assert_eq!(ends, 0, "reply {fault:?}: {status:?}");
            acquisition.stop().await;
        });
    }
    while let Some(ended) = cases.join_next().await {
        ended.unwrap();
    }
}
