//! A whole static cycle, from the bytes of the devices to its points.

use crate::sessions::{AGENT, PROBE, floor_in};
use crate::shop::{LIMIT, deflection_mm, next, program};
use std::sync::Arc;
use std::time::Instant;
use trunnion_acquire::Acquisition;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_core::axis::iso::{B, C, X, Y, Z};
use trunnion_core::reading::Message;
use trunnion_core::{AxisValues, HostTime, Point, Quality};
use trunnion_cycles::cycle::{Pose, Settle};
use trunnion_hil_sim::devices::ascii::{self, IndicatorConfig, Sees};
use trunnion_hil_sim::devices::{SimulatedCell, TimeOrigin, orthogonal_nest};
use trunnion_hil_sim::motion::Step;
use trunnion_protocol::ascii::PRESETS;
use trunnion_sync::align::{AlignLimits, Aligner};
use trunnion_sync::{CycleEvent, EndReason, StaticCycle, StaticRules, TimeBase, Timed};

/// Messages to events, as the daemon does it and as a replay does it.
struct Pipeline {
    base: TimeBase,
    aligner: Aligner,
    cycle: StaticCycle,
}

impl Pipeline {
    fn new(poses: &[Pose]) -> Self {
        let settle = Settle {
            window_s: 0.5,
            drift_mm: 1e-3,
            noise_mm: 2e-3,
            standstill_mm: 2e-3,
            standstill_rad: 2e-5,
            timeout_s: 5.0,
        };
        let rules = StaticRules::new(settle);
        Self {
            base: TimeBase::new(HostTime(0)),
            aligner: Aligner::new(&[0, 1, 2], AlignLimits::default()),
            cycle: StaticCycle::new(poses.to_vec(), rules, vec![], vec![X, Y, Z, B, C], 0),
        }
    }

    fn push(&mut self, message: &Message) -> Vec<CycleEvent> {
        let (mut steps, mut events) = (Vec::new(), Vec::new());
        match self.base.translate(message) {
            Some(Timed::Probe(sample)) => self.aligner.push_probe(&sample, &mut steps),
            Some(Timed::Axes(sample)) => self.aligner.push_axes(&sample, &mut steps),
            _ => {}
        }
        steps.iter().for_each(|step| self.cycle.push(step, &mut events));
        events
    }
}

/// A cycle on three poses of C, each stood at for so long; where the poses are.
fn three_poses(dwell_s: f64) -> (Arc<SimulatedCell>, Vec<Pose>) {
    let at = |c: f64| {
        let mut position = AxisValues::default();
        (position[X], position[B], position[C]) = (100.0, 0.25, c);
        position
    };
    let stations = [0.5, 1.0, 0.25];
    let to = |c: f64| [Step::Move { target: at(c), duration_s: 0.4 }, Step::Dwell { duration_s: dwell_s }];
    let steps = [Step::Dwell { duration_s: 1.0 }].into_iter().chain(stations.into_iter().flat_map(to));
    let pose = |c: f64| Pose { setup: 0, target: 0, position: at(c), direction: AxisValues::default() };
    (program(steps.collect()), stations.map(pose).to_vec())
}

/// Reads the cycle to its end; what was recorded and what came of it.
async fn read_cycle(mut acquisition: Acquisition, poses: &[Pose]) -> (Vec<Message>, Vec<CycleEvent>) {
    let (mut live, mut recorded, mut events) = (Pipeline::new(poses), Vec::new(), Vec::new());
    let begun = Instant::now();
    while !matches!(events.last(), Some(CycleEvent::Ended { .. })) {
        assert!(begun.elapsed() < LIMIT, "{events:?} {:?}", live.aligner.counts());
        let message = next(&mut acquisition).await;
        events.extend(live.push(&message));
        recorded.push(message);
    }
    acquisition.stop().await;
    assert!(matches!(events.last(), Some(CycleEvent::Ended { reason: EndReason::Complete, .. })));
    (recorded, events)
}

/// Every pose has a good point with the reading of the nest there.
fn assert_read(events: &[CycleEvent], zero_mm: f64, within_mm: f64) -> Vec<Point> {
    let points: Vec<Point> = events
        .iter()
        .filter_map(|event| match event {
            CycleEvent::Point { point, .. } => Some(point.clone()),
            _ => None,
        })
        .collect();
    for (point, (c, direction)) in points.iter().zip([(0.5f64, 1.0), (1.0, 1.0), (0.25, -1.0)]) {
        assert_eq!((point.quality, point.state.direction[C]), (Quality::Good, direction), "{point:?}");
        let deflection = deflection_mm(c);
        for (direction, measured) in orthogonal_nest().iter().zip(point.reading_mm) {
            let expected = zero_mm + (0..3).map(|k| direction[k] * deflection[k]).sum::<f64>();
            assert!((measured - expected).abs() < within_mm, "{measured} {expected}");
        }
    }
    points
}

#[tokio::test(flavor = "multi_thread")]
async fn a_static_cycle_is_read_live_and_its_replay_gives_the_same_bytes() {
    let (world, poses) = three_poses(1.4);
    let floor = floor_in(world, |config| config.can = None).await;
    let probes: String = (1..=3).map(|k| PROBE.replace("probe-1", &format!("probe-{k}"))).collect();
    let acquisition = floor.start(&(probes + AGENT), QUEUE_LENGTH);
    let (recorded, events) = read_cycle(acquisition, &poses).await;
    // One count of a sensor of 2 mm range is 31 nm.
    assert_read(&events, 1.0, 1e-4);
    let mut replay = Pipeline::new(&poses);
    let replayed: Vec<CycleEvent> = recorded.iter().flat_map(|message| replay.push(message)).collect();
    assert_eq!(format!("{events:?}"), format!("{replayed:?}"));
}

const INDICATOR: &str = r#"
[[device]]
name = "probe-1"
driver = "ascii"
preset = "sylvac"
port = "{dir}/probe-1"
role = "probe-1"
"#;

/// The preset asks ten times a second.
#[tokio::test(flavor = "multi_thread")]
async fn a_dwell_of_three_seconds_is_read_with_indicators_at_ten_hertz() {
    let (world, poses) = three_poses(3.0);
    let floor = floor_in(world.clone(), |config| {
        config.probes.clear();
        config.can = None;
    })
    .await;
    let preset = **PRESETS.iter().find(|preset| preset.name == "sylvac").unwrap();
    let start = |k: usize| {
        let port = floor.directory.path().join(format!("probe-{}", k + 1));
        ascii::spawn(
            world.clone(),
            IndicatorConfig::new(Sees::Probe(k), preset),
            &port,
            TimeOrigin(floor.clock.0.into()),
            &[],
        )
    };
    let _indicators = [0, 1, 2].map(|k| start(k).unwrap());
    let probes: String = (1..=3).map(|k| INDICATOR.replace("probe-1", &format!("probe-{k}"))).collect();
    let (_, events) = read_cycle(floor.start(&(probes + AGENT), QUEUE_LENGTH), &poses).await;
    let points = assert_read(&events, 0.0, 2e-4);
    assert!(points.iter().all(|point| (5..=8).contains(&point.samples)), "{points:?}");
}
