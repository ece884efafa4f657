//! Twelve thousand readings a second on the disk of this computer: nothing is lost while a sync takes less than the 2.7 s that the queue
//! holds.

use super::{Monotonic, header};
use std::sync::Arc;
use std::time::{Duration, Instant};
use trunnion_core::{Clock, HostTime, ProbeSample};
use trunnion_record::{Item, Recorder, RecorderHandle};

#[test]
fn full_rate_overflows_no_queue_while_the_disk_is_synced() {
    // Next to the program, which is on a disk; the temporary folder may be memory.
    let disk = std::env::current_exe().unwrap();
    let folder = tempfile::tempdir_in(disk.parent().unwrap()).unwrap();
    let clock = Arc::new(Monotonic(Instant::now()));
    let recorder = Recorder::create(folder.path(), "rate", &header("rate", "probe-1")).unwrap();
    let handle = RecorderHandle::spawn(recorder, RecorderHandle::QUEUE, clock.clone()).unwrap();
    let mut raw = 0;
    while clock.now() < HostTime(3_000_000_000) {
        let due = clock.now().0 * 12_000 / 1_000_000_000;
        while raw < due {
            let (now, value_mm) = (clock.now(), (raw as f64).sin());
            let time_s = raw as f64 / 12_000.0;
            let sample = ProbeSample { time_s, raw, value_mm, ..ProbeSample::default() };
            assert!(handle.try_send(Item::Probe(sample), now), "the queue is full");
            raw += 1;
        }
        // The pace of the readings.
        std::thread::sleep(Duration::from_millis(1));
    }
    let status = handle.status();
    println!("{raw} readings, at most {} waiting, at risk {:?}", status.most_waiting, status.at_risk);
    let finished = handle.finish().unwrap();
    assert_eq!((finished.lost_samples, status.lost_samples), (0, 0));
    assert!(status.at_risk > Duration::ZERO, "nothing was synced");
}
