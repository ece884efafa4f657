//! No file, however damaged, panics the reader or makes it allocate without bound; damage is reported.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};
use std::time::Duration;
use trunnion_core::{HostTime, ProbeSample};
use trunnion_machine::shipped;
use trunnion_record::{Item, RecordError, Recorder, RunHeader, points_csv, read_run, recover_orphans};

const SAMPLES: usize = 4000;

/// The same run as a finished file and as a journal that lost its writer.
fn recordings(folder: &Path) -> (PathBuf, PathBuf) {
    let run = points_csv::import_files(
        "gravity",
        ("points.csv", include_str!("../../../../tests/data/points-gravity/points.csv")),
        ("setup.toml", include_str!("../../../../tests/data/points-gravity/setup.toml")),
        &shipped::machine,
    )
    .unwrap();
    let header = RunHeader { probes: vec!["px".into()], ..RunHeader::of_run(&run, "", "0.1.0", 0) };
    let mut recorder = Recorder::create(folder, "run", &header).unwrap();
    for point in run.points {
        recorder.append(Item::Point(point), HostTime(0));
    }
    for i in 0..SAMPLES {
        let time_s = i as f64 * 1e-3;
        let sample = ProbeSample { time_s, raw: i as i64, value_mm: time_s, ..ProbeSample::default() };
        recorder.append(Item::Probe(sample), HostTime(0) + Duration::from_millis(i as u64));
    }
    recorder.flush_aged(HostTime(i64::MAX));
    let journal = folder.join("copy.mcap.active");
    std::fs::copy(folder.join("run.mcap.active"), &journal).unwrap();
    recorder.finish(HostTime(0)).unwrap();
    (folder.join("run.mcap"), journal)
}

#[test]
fn a_truncated_file_is_read_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let (finished, journal) = recordings(folder.path());
    let cut = folder.path().join("cut.mcap");
    for path in [finished, journal] {
        let bytes = std::fs::read(&path).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut most = 0;
        for _ in 0..150 {
            let keep = rng.random_range(0..bytes.len());
            std::fs::write(&cut, &bytes[..keep]).unwrap();
            match read_run(&cut, &shipped::machine) {
                Ok(read) => {
                    let damage = read.damage.expect("a cut file is damaged");
                    assert!(damage.offset <= keep as u64);
                    let whole: Vec<i64> = (0..read.probe_samples.len() as i64).collect();
                    assert_eq!(read.probe_samples.iter().map(|s| s.raw).collect::<Vec<_>>(), whole);
                    most = most.max(whole.len());
                }
                Err(RecordError::NotARecording { .. }) => assert!(keep < 40_000, "header lost at {keep}"),
                Err(other) => panic!("{other}"),
            }
        }
        assert!(most > 0);
    }
}

/// One chunk with all points, five minutes long, whose end is missing.
#[test]
fn what_is_whole_of_a_cut_chunk_is_read_and_the_rest_named() {
    let folder = tempfile::tempdir().unwrap();
    let (finished, _) = recordings(folder.path());
    let bytes = std::fs::read(&finished).unwrap();
    let whole = read_run(&finished, &shipped::machine).unwrap();
    let chunks: Vec<(usize, usize)> = chunks(&bytes);
    let &(at, length) = chunks.iter().max_by_key(|(_, length)| length).unwrap();
    let cut = folder.path().join("cut.mcap");
    let read = |keep: usize| {
        std::fs::write(&cut, &bytes[..keep]).unwrap();
        read_run(&cut, &shipped::machine).unwrap()
    };
    // All but the last bytes: blocks of 128 KiB are whole, some of several.
    let read_most = read(at + length - 100);
    let left = read_most.run.points.len() + read_most.probe_samples.len();
    let all = whole.run.points.len() + whole.probe_samples.len();
    assert!(left > all / 4 && left < all, "{left} of {all}");
    assert!(read_most.run.points.iter().all(|point| whole.run.points.contains(point)));
    assert!(read_most.probe_samples.iter().all(|sample| sample.value_mm == sample.raw as f64 * 1e-3));
    let lost = read(at + 60).damage.unwrap().lost;
    assert!(lost.starts_with("everything after 0.0 s of the run, which went on to "), "{lost}");
}

/// Begin and length of every chunk.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let (mut at, mut found) = (8, Vec::new());
    while at + 9 < bytes.len() - 8 {
        let length = 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        if bytes[at] == 6 {
            found.push((at, length));
        }
        at += length;
    }
    found
}

#[test]
fn any_flipped_byte_of_a_finished_file_is_reported_and_never_changes_a_value() {
    let folder = tempfile::tempdir().unwrap();
    let (finished, _) = recordings(folder.path());
    let bytes = std::fs::read(&finished).unwrap();
    let whole = read_run(&finished, &shipped::machine).unwrap();
    assert_eq!((whole.damage, whole.run.points.len(), whole.probe_samples.len()), (None, 336, SAMPLES));
    let flipped = folder.path().join("flipped.mcap");
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for _ in 0..1000 {
        let mut bytes = bytes.clone();
        let at = rng.random_range(0..bytes.len());
        bytes[at] ^= 1 << rng.random_range(0..8);
        std::fs::write(&flipped, &bytes).unwrap();
        let Ok(read) = read_run(&flipped, &shipped::machine) else { continue };
        assert!(read.damage.is_some(), "the flip at {at} went unseen");
        assert!(read.run.points.iter().all(|point| whole.run.points.contains(point)));
        assert!(read.probe_samples.iter().all(|sample| sample.value_mm == sample.raw as f64 * 1e-3));
    }
}

#[test]
fn a_mangled_journal_never_panics_and_recovery_keeps_what_it_cannot_read() {
    let folder = tempfile::tempdir().unwrap();
    let (_, journal) = recordings(folder.path());
    let bytes = std::fs::read(&journal).unwrap();
    std::fs::remove_file(&journal).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for i in 0..100 {
        let dir = folder.path().join(i.to_string());
        std::fs::create_dir(&dir).unwrap();
        let mut bytes = bytes.clone();
        for _ in 0..rng.random_range(1..20) {
            let at = rng.random_range(0..bytes.len());
            bytes[at] = rng.random();
        }
        bytes.truncate(rng.random_range(0..=bytes.len()));
        std::fs::write(dir.join("x.mcap.active"), &bytes).unwrap();
        // A value inside an uncompressed message may change unseen; nothing else may happen.
        read_run(&dir.join("x.mcap.active"), &shipped::machine).err();
        let orphans = recover_orphans(&dir).unwrap();
        match &orphans.iter().map(|orphan| &orphan.finished).collect::<Vec<_>>()[..] {
            [Ok(file)] => {
                let read = read_run(&file.path, &shipped::machine).ok();
                assert!(read.is_none_or(|read| read.events.iter().any(|event| event.kind == "recovered")));
            }
            [Err(_)] => assert!(dir.join("x.mcap.active").exists()),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn short_and_boastful_files_are_refused_with_offset_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.mcap");
    let magic = mcap::MAGIC;
    // docs/design/numerics.md §2.3: a 17-byte file panics mcap 0.26: magic and the frame of an empty attachment.
    let attachment = [magic, &[9], &0_u64.to_le_bytes()].concat();
    assert_eq!(attachment.len(), 17);
    let boastful = [magic, &[6], &u64::MAX.to_le_bytes(), &[0; 40]].concat();
    let chunk_head = [&[0; 16][..], &u64::MAX.to_le_bytes(), &[0; 16]].concat();
    let chunk = [magic, &[6], &(chunk_head.len() as u64).to_le_bytes(), &chunk_head].concat();
    for (bytes, reason) in [
        (attachment, "claims 8 bytes"),
        (boastful, "claims 18446744073709551615 bytes"),
        (chunk, "a chunk claims 18446744073709551615 bytes"),
        (b"time_s,x_mm\n".to_vec(), "does not begin like a recording"),
        (Vec::new(), "does not begin like a recording"),
    ] {
        std::fs::write(&path, bytes).unwrap();
        let error = read_run(&path, &shipped::machine).err().unwrap().to_string();
        assert!(error.contains(reason), "{error}");
    }
}
