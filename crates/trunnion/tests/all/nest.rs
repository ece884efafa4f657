//! The nest from recorded samples: steps of the linear axes at one pose among others, and what is too little of them.

use std::path::{Path, PathBuf};
use trunnion::gaps::Missing;
use trunnion::nest::calibrate_nest;
use trunnion::tables::Exported;
use trunnion_core::axis::iso::{C, X, Y, Z};
use trunnion_core::{AxisSample, AxisValues, Gap, Joint, ProbeSample, Stamp};
use trunnion_record::{Item, RunWriter};

const STATIC: &str = include_str!("../../../../config/cycles/demo-static.toml");
/// Unit directions of the probes, and their gains.
const DIRECTIONS: [[f64; 3]; 3] = [[0.8, 0.0, 0.6], [-0.6, 0.64, 0.48], [0.0, -0.8, 0.6]];
const GAINS: [f64; 3] = [1.0, 1.02, 0.99];
const STAND_S: f64 = 1.0;
const WAY_S: f64 = 0.1;

/// Stands at `places` one after the other (an axis, and by how much it stepped from the ball), read at 200 Hz; C stands elsewhere
/// at first.
fn record(path: &Path, places: &[(Joint, f64)]) -> PathBuf {
    record_with(path, places, None)
}

fn record_with(path: &Path, places: &[(Joint, f64)], gap: Option<Gap>) -> PathBuf {
    let mut header = crate::header("steps", STATIC);
    header.setups.truncate(1);
    let stands: Vec<AxisValues<f64>> = std::iter::once((X, 0.0, 0.5))
        .chain(places.iter().map(|(axis, by_mm)| (*axis, *by_mm, 0.0)))
        .map(|(axis, by_mm, c_rad)| {
            let mut position = AxisValues::default();
            (position[X], position[Z], position[C]) = (150.0, 60.0, c_rad);
            position[axis] += by_mm;
            position
        })
        .collect();
    let mut writer = RunWriter::create(path, &header).unwrap();
    for step in 0..(stands.len() as f64 * STAND_S * 200.0) as u64 {
        let time_s = step as f64 / 200.0;
        let stamp = Stamp { epoch: 1, ticks: step, tick_s: 0.005, arrival_s: time_s };
        let k = ((time_s / STAND_S) as usize).min(stands.len() - 1);
        let share = ((time_s - k as f64 * STAND_S) / WAY_S).min(1.0);
        let from = stands[k.saturating_sub(1)];
        let position = AxisValues::from_fn(|slot| from[slot] + share * (stands[k][slot] - from[slot]));
        let moved = [position[X] - 150.0, position[Y], position[Z] - 60.0];
        for (channel, (direction, gain)) in DIRECTIONS.iter().zip(GAINS).enumerate() {
            let value_mm = 0.7 + gain * (0..3).map(|i| direction[i] * moved[i]).sum::<f64>();
            let channel = u16::try_from(channel).unwrap();
            let sample = ProbeSample { channel, time_s, stamp, value_mm, ..ProbeSample::default() };
            writer.item(Item::Probe(sample), time_s);
        }
        writer.item(Item::Axes(AxisSample { time_s, stamp, position, ..AxisSample::default() }), time_s);
    }
    gap.into_iter().for_each(|gap| writer.item(Item::Gap(gap), 0.0));
    writer.finish().unwrap();
    path.into()
}

fn steps(axes: &[Joint]) -> Vec<(Joint, f64)> {
    axes.iter().flat_map(|&axis| [0.0, 0.2, -0.2, 0.1].map(|by_mm| (axis, by_mm))).collect()
}

#[test]
fn directions_and_gains_come_from_recorded_samples() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(&folder.path().join("steps.mcap"), &steps(&[X, Y, Z]));
    let (found, _) = calibrate_nest(&run, true).unwrap();
    assert!(found.steps >= 9, "{found:?}");
    for ((probe, direction), gain) in found.probes.iter().zip(DIRECTIONS).zip(GAINS) {
        assert!((probe.gain - gain).abs() < 1e-6, "{probe:?}");
        assert!((0..3).all(|i| (probe.direction[i] - direction[i]).abs() < 1e-6), "{probe:?}");
    }
    assert!(found.lines.starts_with("[nest]\nprobe_1 = [0.8000000, "), "{}", found.lines);
}

#[test]
fn what_is_missing_from_the_steps_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let whole = record(&folder.path().join("whole.mcap"), &steps(&[X, Y, Z]));
    assert_eq!(calibrate_nest(&whole, true).unwrap().1, Missing::default());
    let (source, from_s, to_s) = ("probe-1".to_owned(), 2.0, 2.5);
    let gap = Gap { source, from_s, to_s, lost_samples: Some(100), reason: "unplugged".into() };
    let holed = record_with(&folder.path().join("holed.mcap"), &steps(&[X, Y, Z]), Some(gap));
    let missing = calibrate_nest(&holed, true).unwrap().1;
    let [gap] = &missing.gaps[..] else { panic!("{missing:?}") };
    assert!(
        gap.ends_with("probe-1: nothing from 2.00 s to 2.50 s, 100 samples missing (unplugged)"),
        "{gap}"
    );
    assert_eq!(missing.damage, None);
    // Whatever else is made of the samples says it too.
    let (_, of_samples) = trunnion::tables::export(&holed, Exported::Samples).unwrap();
    assert_eq!(of_samples, missing);
}

#[test]
fn recorded_samples_of_two_axes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(&folder.path().join("steps.mcap"), &steps(&[X, Y]));
    let failure = calibrate_nest(&run, true).unwrap_err();
    let refused = std::error::Error::source(&failure).unwrap().to_string();
    assert!(refused.contains("do not span all three directions"), "{refused}");
}
