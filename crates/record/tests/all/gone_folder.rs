//! A folder that is removed or moved while a run is recorded: it is noticed, and recording goes on.

use super::header;
use std::path::Path;
use trunnion_core::{HostTime, ProbeSample};
use trunnion_machine::shipped;
use trunnion_record::{Item, Recorder, read_run};

/// Samples 1 ms apart, none of which waits for its batch afterwards.
fn record(recorder: &mut Recorder, raws: std::ops::Range<i64>) {
    let end = HostTime((raws.end + 100) * 1_000_000);
    for raw in raws {
        let sample = ProbeSample { time_s: raw as f64 * 1e-3, raw, ..ProbeSample::default() };
        recorder.append(Item::Probe(sample), HostTime(raw * 1_000_000));
    }
    recorder.flush_aged(end);
}

fn goes_on(take_away: impl Fn(&Path, &Path)) {
    let place = tempfile::tempdir().unwrap();
    let (folder, other) = (place.path().join("runs"), place.path().join("elsewhere"));
    let mut recorder = Recorder::create(&folder, "r", &header("r", "probe-1")).unwrap();
    record(&mut recorder, 0..2560);
    assert!(recorder.sync(HostTime(2_560_000_000)));
    take_away(&folder, &other);
    record(&mut recorder, 2560..5120);
    assert!(!recorder.sync(HostTime(5_120_000_000)), "what was in it is on no disk");
    assert_eq!((recorder.failing(), recorder.lost_samples()), (None, 5120));
    record(&mut recorder, 5120..7680);
    let finished = recorder.finish(HostTime(7_680_000_000)).unwrap();
    assert_eq!((finished.files.len(), finished.lost_samples), (1, 5120));
    let run = read_run(&folder.join("r.mcap"), &shipped::machine).unwrap();
    let raws: Vec<i64> = run.probe_samples.iter().map(|sample| sample.raw).collect();
    assert!(raws.iter().copied().eq(5120..7680), "{} samples", raws.len());
    let [gap] = &run.gaps[..] else { panic!("{:?}", run.gaps) };
    assert_eq!((gap.lost_samples, gap.source.as_str()), (Some(5120), "recorder"));
    assert!(gap.reason.contains("r.mcap.active is not there any more"), "{}", gap.reason);
    assert!(gap.from_s < 0.3 && gap.to_s > 4.8, "{gap:?}");
}

#[test]
fn what_was_in_a_removed_folder_is_a_gap_and_recording_goes_on_in_a_new_one() {
    goes_on(|folder, _| std::fs::remove_dir_all(folder).unwrap());
}

#[test]
fn a_folder_that_was_moved_is_noticed() {
    goes_on(|folder, other| std::fs::rename(folder, other).unwrap());
}

#[test]
fn a_folder_that_is_removed_right_before_the_end_is_a_gap_too() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("runs");
    let mut recorder = Recorder::create(&folder, "r", &header("r", "probe-1")).unwrap();
    record(&mut recorder, 0..2560);
    std::fs::remove_dir_all(&folder).unwrap();
    let finished = recorder.finish(HostTime(2_560_000_000)).unwrap();
    assert_eq!((finished.files.len(), finished.lost_samples), (1, 2560));
    let run = read_run(&folder.join("r.mcap"), &shipped::machine).unwrap();
    assert_eq!((run.probe_samples.len(), run.gaps[0].lost_samples), (0, Some(2560)));
}
