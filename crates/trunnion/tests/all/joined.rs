//! A cycle recorded in parts is one cycle: the same poses and the same zero as if nothing had been in between.

use std::ops::Range;
use std::path::{Path, PathBuf};
use trunnion::cycles::Cycle;
use trunnion::join::join;
use trunnion_core::{AxisSample, AxisValues, HostTime, Point, ProbeSample, Quality, Stamp};
use trunnion_machine::shipped;
use trunnion_record::{Item, RunHeader, RunWriter};
use trunnion_sync::EndReason;
use trunnion_sync::forming::Forming;

const STATIC: &str = include_str!("../../../../config/cycles/demo-static.toml");
/// From one pose to the next, and of that the way, s.
const STEP_S: f64 = 0.6;
const WAY_S: f64 = 0.2;

/// A machine that goes through poses, each at `STEP_S` times its place, and three probes that read the number of the pose.
pub struct World {
    text: String,
    poses: Vec<AxisValues<f64>>,
}

impl World {
    pub fn new() -> Self {
        let text = STATIC.replace("step_deg = 30", "step_deg = 90");
        let cycle = Cycle::parse("c.toml", &text).unwrap();
        let poses = cycle.poses(&shipped::machine("table-bc").unwrap()).unwrap();
        Self { text, poses: poses.into_iter().map(|pose| pose.position).collect() }
    }

    pub fn ends_s(&self) -> f64 {
        self.poses.len() as f64 * STEP_S
    }

    /// The program began at `began_s`.
    fn position(&self, time_s: f64, began_s: f64) -> (usize, AxisValues<f64>) {
        let since_s = (time_s - began_s).max(0.0);
        let k = ((since_s / STEP_S) as usize).min(self.poses.len() - 1);
        let share = ((since_s - k as f64 * STEP_S) / WAY_S).min(1.0);
        let from = self.poses[k.saturating_sub(1)];
        (k, AxisValues::from_fn(|slot| from[slot] + share * (self.poses[k][slot] - from[slot])))
    }

    /// What was recorded from when to when of a program that began at `began_s`, as the live run does it.
    pub fn record(&self, path: &Path, recorded_s: Range<f64>, began_s: f64) -> PathBuf {
        let wall_start_ns = 1_790_000_000_000_000_000 + (recorded_s.start * 1e9) as i64;
        let header =
            RunHeader { wall_start_ns, host_start: HostTime(5), ..crate::header("part", &self.text) };
        let mut forming = Forming::new(&trunnion::recorded::plan_of(&header).unwrap(), 0).unwrap();
        let mut writer = RunWriter::create(path, &header).unwrap();
        let mut formed = Vec::new();
        let steps = ((recorded_s.end - recorded_s.start) * 200.0) as u64;
        for step in 0..steps {
            let time_s = step as f64 / 200.0;
            let stamp = Stamp { epoch: 1, ticks: step, tick_s: 0.005, arrival_s: time_s };
            let (k, position) = self.position(recorded_s.start + time_s, began_s);
            for channel in 0..3 {
                let value_mm = 1e-3 * (k as f64 + 0.1 * f64::from(channel)) + 0.2;
                let sample = ProbeSample { channel, time_s, stamp, value_mm, ..ProbeSample::default() };
                forming.probe(&sample, &mut formed);
                writer.item(Item::Probe(sample), time_s);
            }
            let sample = AxisSample { time_s, stamp, position, ..AxisSample::default() };
            forming.axes(&sample, &mut formed);
            writer.item(Item::Axes(sample), time_s);
        }
        forming.finish(EndReason::Stopped, &mut formed);
        formed.into_iter().filter_map(|event| event.into_point().ok()).for_each(|point| writer.point(point));
        writer.finish().unwrap();
        path.into()
    }
}

fn points(path: &Path) -> Vec<Point> {
    trunnion_record::read_run(path, &shipped::machine).unwrap().run.points
}

#[test]
fn parts_have_the_poses_and_the_zero_of_the_whole_cycle() {
    let (world, folder) = (World::new(), tempfile::tempdir().unwrap());
    let path = |name: &str| folder.path().join(name);
    let whole = points(&world.record(&path("whole.mcap"), 0.0..world.ends_s(), 0.0));
    assert!(whole.iter().all(|point| point.quality == Quality::Good));
    // Cut while the machine stands at pose 30; back on the way to pose 34, and once more at pose 60.
    let first = world.record(&path("first.mcap"), 0.0..30.9 * STEP_S, 0.0);
    let second = world.record(&path("second.mcap"), 34.1 * STEP_S..40.5 * STEP_S, 0.0);
    let third = world.record(&path("third.mcap"), 40.6 * STEP_S..world.ends_s(), 0.0);
    let alone = points(&second).iter().filter(|point| point.quality == Quality::Good).count();
    let joined = join(&[first, second, third], &path("joined.mcap")).unwrap();
    assert_eq!(
        joined.parts.iter().map(|part| part.run.as_str()).collect::<Vec<_>>(),
        ["first.mcap", "second.mcap", "third.mcap"]
    );
    assert_eq!(joined.parts[1].read, alone);
    let together = points(&path("joined.mcap"));
    assert_eq!(together.len(), whole.len());
    let read: Vec<usize> = (0..whole.len()).filter(|&k| together[k].quality == Quality::Good).collect();
    let missing: Vec<usize> = (0..whole.len()).filter(|k| !read.contains(k)).collect();
    assert_eq!(missing, [31, 32, 33]);
    assert_eq!(joined.read, read.len());
    for k in read {
        let (found, expected) = (&together[k], &whole[k]);
        assert_eq!(found.state.setup, expected.state.setup);
        for slot in 0..3 {
            let off_mm = found.reading_mm[slot] - expected.reading_mm[slot];
            assert!(off_mm.abs() < 1e-9, "pose {k}: {off_mm} mm");
        }
    }
    let recording = trunnion_record::read_run(&path("joined.mcap"), &shipped::machine).unwrap();
    let gaps: Vec<&str> = recording.gaps.iter().map(|gap| gap.source.as_str()).collect();
    assert_eq!(gaps.iter().filter(|source| **source == "controller").count(), 2, "{gaps:?}");
    assert_eq!(gaps.iter().filter(|source| **source == "probe-2").count(), 2, "{gaps:?}");
    let outage = recording.gaps.iter().find(|gap| gap.source == "controller").unwrap();
    assert!((outage.from_s - 30.9 * STEP_S).abs() < 0.02 && (outage.to_s - 34.1 * STEP_S).abs() < 0.02);
    assert_eq!(recording.probe_samples.iter().map(|sample| sample.stamp.epoch).max(), Some(5));
}

#[test]
fn what_is_no_part_of_the_same_run_of_the_program_is_not_joined() {
    let (world, folder) = (World::new(), tempfile::tempdir().unwrap());
    let path = |name: &str| folder.path().join(name);
    let output = path("joined.mcap");
    let first = world.record(&path("first.mcap"), 0.0..30.9 * STEP_S, 0.0);
    // The program was begun again while nothing was recorded.
    let again_s = 32.0 * STEP_S;
    let again = world.record(&path("again.mcap"), again_s + 4.0 * STEP_S..again_s + world.ends_s(), again_s);
    let why = |parts: &[&PathBuf]| {
        let parts: Vec<PathBuf> = parts.iter().map(|path| (*path).clone()).collect();
        let refused = join(&parts, &output).unwrap_err().to_string();
        assert!(!output.exists() && !output.with_extension("mcap.active").exists());
        refused
    };
    let refused = why(&[&first, &again]);
    assert!(refused.contains("the program began again in between"), "{refused}");
    let refused = why(&[&again, &first]);
    assert!(refused.contains("give the parts in order of time"), "{refused}");
    let other = World { text: world.text.replace("window_s = 0.03", "window_s = 0.04"), ..World::new() };
    let other = other.record(&path("other.mcap"), 34.1 * STEP_S..40.0 * STEP_S, 0.0);
    let refused = why(&[&first, &other]);
    assert!(refused.contains("its cycle file is not that of first.mcap"), "{refused}");
    assert!(why(&[&first]).contains("give two or more"));
}

#[test]
fn events_of_forming_stand_once() {
    let (world, folder) = (World::new(), tempfile::tempdir().unwrap());
    let path = |name: &str| folder.path().join(name);
    let first = world.record(&path("first.mcap"), 0.0..30.9 * STEP_S, 0.0);
    let second = world.record(&path("second.mcap"), 34.1 * STEP_S..world.ends_s(), 0.0);
    join(&[first, second], &path("joined.mcap")).unwrap();
    let events = trunnion_record::read_run(&path("joined.mcap"), &shipped::machine).unwrap().events;
    assert_eq!(events.iter().filter(|event| event.kind == "joined").count(), 1, "{events:?}");
    assert!(events.iter().all(|event| event.kind != "unknown-dwell"), "{events:?}");
}
