//! Disks that are full, and a computer that loses its power.

mod journals;
mod power;

use super::*;
use crate::reader::read_run;
use std::io::{self, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use trunnion_cycles::RunKind;
use trunnion_machine::shipped;

/// A disk with so many bytes left; a write that does not fit is cut short, as a real one is.
struct SmallDisk {
    file: std::fs::File,
    left: Arc<AtomicI64>,
}

impl Write for SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = usize::try_from(self.left.load(Ordering::SeqCst)).unwrap_or(0);
        if left == 0 {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let written = self.file.write(&bytes[..bytes.len().min(left)])?;
        self.left.fetch_sub(written as i64, Ordering::SeqCst);
        Ok(written)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for SmallDisk {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// A recorder whose journals all lie on a disk with so many bytes left.
fn on_disk(folder: &Path, left: &Arc<AtomicI64>) -> Recorder {
    let left = Arc::clone(left);
    on_disks(folder, move || Arc::clone(&left))
}

/// A recorder each of whose journals lies on a disk of its own.
fn on_disks(folder: &Path, mut left: impl FnMut() -> Arc<AtomicI64> + Send + 'static) -> Recorder {
    let open: OpenJournal = Box::new(move |path| {
        let file = std::fs::File::create_new(path)?;
        Ok((Box::new(SmallDisk { file, left: left() }), Box::new(|| Ok(()))))
    });
    Recorder::create_with(folder, "full", &header("full"), open).unwrap()
}

/// One of the values that no line through the counts shortens, so that the ring overflows.
fn sample(raw: i64, period_s: f64) -> Item {
    let (time_s, value_mm) = (raw as f64 * period_s, (raw as f64).sin());
    Item::Probe(ProbeSample { time_s, raw, value_mm, ..ProbeSample::default() })
}

#[test]
fn a_full_disk_costs_only_what_the_ring_cannot_hold_and_that_is_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    let left = Arc::new(AtomicI64::new(60_000));
    let mut recorder = on_disk(folder.path(), &left);
    let samples = 1_200_000_i64;
    let mut failed = false;
    for raw in 0..samples {
        recorder.append(sample(raw, 1e-5), HostTime(raw * 10_000));
        failed |= recorder.failing().is_some_and(|why| why.contains("cannot write"));
        if raw == samples - 150_000 {
            left.store(i64::MAX, Ordering::SeqCst);
        }
    }
    assert!(failed && recorder.failing().is_none());
    let finished = recorder.finish(HostTime(samples * 10_000)).unwrap();
    let names: Vec<_> = finished.files.iter().map(|file| file.path.file_name().unwrap()).collect();
    assert_eq!(names, ["full.mcap", "full-2.mcap"]);

    let read = finished.files.iter().map(|file| read_run(&file.path, &shipped::machine).unwrap());
    let [first, second] = read.collect::<Vec<_>>().try_into().unwrap();
    let lost = finished.lost_samples;
    assert!(lost > 1000, "{lost}");
    assert_eq!((first.damage, second.damage), (None, None));
    let mut raws: Vec<i64> =
        first.probe_samples.iter().chain(&second.probe_samples).map(|sample| sample.raw).collect();
    raws.dedup();
    assert_eq!(raws.len() as u64 + lost, samples as u64);
    let [gap] = &second.gaps[..] else { panic!("{:?}", second.gaps) };
    assert_eq!(gap.lost_samples, Some(lost));
    assert!(gap.from_s >= first.probe_samples.last().unwrap().time_s && gap.reason.contains("cannot write"));
    assert_eq!(second.events[0].kind, "recording-resumed");
}

#[test]
fn what_was_lost_stays_counted_when_the_next_file_is_refused_too() {
    let folder = tempfile::tempdir().unwrap();
    // The second and third file have room for their beginning, which ends before what was lost; the last has room for all.
    let beginning = bytes_until_recording_resumed();
    let mut rooms = VecDeque::from([60_000, beginning, beginning]);
    let mut recorder =
        on_disks(folder.path(), move || Arc::new(AtomicI64::new(rooms.pop_front().unwrap_or(i64::MAX))));
    let samples = 1_200_000_i64;
    for raw in 0..samples {
        recorder.append(sample(raw, 1e-5), HostTime(raw / 400_000 * 1_000_000_000));
    }
    let finished = recorder.finish(HostTime(10_000_000_000)).unwrap();
    let read = finished.files.iter().map(|file| read_run(&file.path, &shipped::machine).unwrap());
    let gaps: Vec<Gap> = read.flat_map(|run| run.gaps).collect();
    assert!(finished.lost_samples > 1000 && finished.files.len() == 4, "{finished:?}");
    assert_eq!(
        gaps.iter().filter_map(|gap| gap.lost_samples).sum::<u64>(),
        finished.lost_samples,
        "{gaps:?}"
    );
}

#[test]
fn a_file_that_vanishes_with_the_gap_of_a_full_disk_loses_none_of_its_count() {
    let folder = tempfile::tempdir().unwrap();
    let left = Arc::new(AtomicI64::new(60_000));
    let mut recorder = on_disk(folder.path(), &left);
    let samples = 1_200_000_i64;
    for raw in 0..samples {
        recorder.append(sample(raw, 1e-5), HostTime(raw * 10_000));
        if raw == samples - 150_000 {
            left.store(i64::MAX, Ordering::SeqCst);
        }
    }
    let mut closed = recorder.close(HostTime(samples * 10_000));
    std::fs::remove_file(folder.path().join("full-2.mcap.active")).unwrap();
    let finished = closed.finish().unwrap();
    let [file] = &finished.files[..] else { panic!("{finished:?}") };
    let run = read_run(&file.path, &shipped::machine).unwrap();
    let [gap] = &run.gaps[..] else { panic!("{:?}", run.gaps) };
    assert_eq!(gap.lost_samples, Some(finished.lost_samples));
    assert_eq!(run.probe_samples.len() as u64 + finished.lost_samples, samples as u64);
    assert!(gap.from_s > 0.0 && gap.to_s > 11.9, "{gap:?}");
}

#[test]
fn a_disk_that_stays_full_leaves_a_gap_in_what_was_finished() {
    let folder = tempfile::tempdir().unwrap();
    let left = Arc::new(AtomicI64::new(20_000));
    let mut recorder = on_disk(folder.path(), &left);
    let samples = 20_000_i64;
    for raw in 0..samples {
        recorder.append(sample(raw, 1e-4), HostTime(raw * 100_000));
    }
    assert!(!recorder.sync(HostTime(samples * 100_000)), "what waits in memory is on no disk");
    let finished = recorder.finish(HostTime(samples * 100_000)).unwrap();
    let [file] = &finished.files[..] else { panic!("{finished:?}") };
    let read = read_run(&file.path, &shipped::machine).unwrap();
    let [gap] = &read.gaps[..] else { panic!("{:?}", read.gaps) };
    assert_eq!(read.probe_samples.len() as u64 + finished.lost_samples, samples as u64);
    assert_eq!(gap.lost_samples, Some(finished.lost_samples));
    assert!(finished.lost_samples > 1000 && gap.reason.contains("no storage space"), "{gap:?}");
    let last_s = read.probe_samples.last().unwrap().time_s;
    assert!(gap.from_s >= last_s && gap.to_s > 1.9, "{gap:?} after {last_s}");
}

#[test]
fn a_journal_that_vanishes_after_its_last_sync_is_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let recorder = Recorder::create(folder.path(), "r", &header("r")).unwrap();
    let mut closed = recorder.close(HostTime(0));
    std::fs::remove_file(folder.path().join("r.mcap.active")).unwrap();
    let error = closed.finish().unwrap_err();
    assert!(matches!(error, RecordError::Gone { .. }) && !error.may_pass(), "{error}");
}

/// With room for a reason, and less than the schema of the next message takes.
fn bytes_until_recording_resumed() -> i64 {
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(folder.path(), "full", &header("full")).unwrap();
    let resumed = Event { time_s: 0.0, kind: "recording-resumed".into(), text: String::new() };
    recorder.append(Item::Event(resumed), HostTime(0));
    let bytes = std::fs::metadata(folder.path().join("full.mcap.active")).unwrap().len();
    bytes as i64 + 1000
}

fn header(name: &str) -> RunHeader {
    RunHeader::new(name, RunKind::OnTheFly, "table-bc")
}
