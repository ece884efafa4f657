//! A real file system that is full: what is in memory survives, and recording goes on when there is room.
//!
//! This test starts itself again in a mount namespace of its own, which needs no rights where user namespaces are allowed.

use super::{Monotonic, header};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trunnion_core::{Clock, ProbeSample};
use trunnion_machine::shipped;
use trunnion_record::{Finished, Item, Recorder, RecorderHandle, read_run};

const FOLDER: &str = "TRUNNION_FULL_DISK_TEST_FOLDER";
/// Longest wait for a state of the recorder.
const LIMIT: Duration = Duration::from_secs(60);

/// Runs this test again where `folder` is a file system of 4 MiB.
fn on_a_small_disk(test: &str, folder: &Path) {
    let script = "mount -t tmpfs -o size=4m none \"$0\" && exec \"$1\" --exact --nocapture \"$2\"";
    let output = Command::new("unshare")
        .args(["--map-root-user", "--mount", "sh", "-c", script])
        .arg(folder)
        .arg(std::env::current_exe().unwrap())
        .arg(test)
        .env(FOLDER, folder)
        .output()
        .unwrap();
    let said =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
}

fn start(folder: &Path) -> (Arc<Monotonic>, RecorderHandle) {
    let header = header("full", "probe-1");
    let clock = Arc::new(Monotonic(Instant::now()));
    let recorder = Recorder::create(folder, "full", &header).unwrap();
    let handle = RecorderHandle::spawn(recorder, 1 << 16, clock.clone()).unwrap();
    (clock, handle)
}

/// Sends values that no line through the counts shortens, so many at a time, until the state is this.
fn send_until(handle: &RecorderHandle, clock: &Monotonic, sent: &mut i64, is_failing: bool) {
    let begun = Instant::now();
    while handle.status().failing.is_some() != is_failing {
        assert!(begun.elapsed() < LIMIT, "{:?}", handle.status());
        send(handle, clock, sent, 20);
        // So that the disk fills over some batches, and the queue does not.
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn send(handle: &RecorderHandle, clock: &Monotonic, sent: &mut i64, count: i64) {
    for raw in *sent..*sent + count {
        let (now, value_mm) = (clock.now(), (raw as f64).sin());
        let sample = ProbeSample { time_s: raw as f64 * 1e-5, raw, value_mm, ..ProbeSample::default() };
        assert!(handle.try_send(Item::Probe(sample), now));
    }
    *sent += count;
}

/// Every sample is in a file.
fn check_whole(finished: &Finished, sent: i64) {
    let mut raws: Vec<i64> = Vec::new();
    for file in &finished.files {
        let read = read_run(&file.path, &shipped::machine).unwrap();
        assert_eq!((read.damage, read.gaps.len()), (None, 0));
        raws.extend(read.probe_samples.iter().map(|sample| sample.raw));
    }
    assert_eq!(finished.lost_samples, 0);
    assert!(raws.iter().copied().eq(0..sent), "{} of {sent}", raws.len());
}

#[test]
fn recording_goes_on_when_there_is_room_again() {
    let Some(folder) = std::env::var_os(FOLDER) else {
        let folder = tempfile::tempdir().unwrap();
        return on_a_small_disk("full_disk::recording_goes_on_when_there_is_room_again", folder.path());
    };
    let folder = Path::new(&folder);
    let other = folder.join("of another program");
    std::fs::write(&other, vec![1; (4 << 20) - (256 << 10)]).unwrap();
    let (clock, handle) = start(folder);
    let mut sent = 0;
    send_until(&handle, &clock, &mut sent, true);
    let why = handle.status().failing.unwrap();
    assert!(why.contains("No space left on device"), "{why}");
    std::fs::remove_file(&other).unwrap();
    send_until(&handle, &clock, &mut sent, false);
    send(&handle, &clock, &mut sent, 1000);
    let finished = handle.finish().unwrap();
    let names: Vec<_> = finished.files.iter().map(|file| file.path.file_name().unwrap()).collect();
    assert_eq!(names, ["full.mcap", "full-2.mcap"]);
    check_whole(&finished, sent);
}

/// A journal is read as far as it goes.
fn wait_until_written(folder: &Path, sent: i64) {
    let begun = Instant::now();
    let written =
        || read_run(&folder.join("full.mcap.active"), &shipped::machine).unwrap().probe_samples.len();
    while written() as i64 != sent {
        assert!(begun.elapsed() < LIMIT, "{} of {sent}", written());
        // As above: a state is looked at.
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_run_that_ends_on_a_full_disk_is_finished_when_there_is_room() {
    let Some(folder) = std::env::var_os(FOLDER) else {
        let folder = tempfile::tempdir().unwrap();
        let test = "full_disk::a_run_that_ends_on_a_full_disk_is_finished_when_there_is_room";
        return on_a_small_disk(test, folder.path());
    };
    let folder = Path::new(&folder);
    let other = folder.join("of another program");
    let (clock, handle) = start(folder);
    let mut sent = 0;
    send(&handle, &clock, &mut sent, 20_000);
    wait_until_written(folder, sent);
    // Whatever is left is taken: the finished file finds no byte.
    let mut filling = std::fs::File::create(&other).unwrap();
    while std::io::Write::write(&mut filling, &[1; 4096]).is_ok_and(|written| written > 0) {}
    drop(filling);
    let sender = handle.sender();
    let freeing = std::thread::spawn(move || {
        let begun = Instant::now();
        while sender.status().failing.is_none() && begun.elapsed() < LIMIT {
            // As above: a status is looked at.
            std::thread::sleep(Duration::from_millis(1));
        }
        std::fs::remove_file(other).unwrap();
    });
    let finished = handle.finish_within(LIMIT).unwrap();
    freeing.join().unwrap();
    assert_eq!(finished.files.len(), 1, "the disk filled after the last sample");
    check_whole(&finished, sent);
}
