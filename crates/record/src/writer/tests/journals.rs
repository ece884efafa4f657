//! Journals that a folder misses for a moment, that the disk refuses, and that vanish before they are finished.

use super::*;
use std::cell::Cell;
use std::collections::VecDeque;
use std::sync::Mutex;

/// What the next syncs of all journals answer; they succeed when there is no answer left.
type Answers = Arc<Mutex<VecDeque<io::ErrorKind>>>;

fn recorder(folder: &Path, answers: &Answers) -> Recorder {
    let answers = Arc::clone(answers);
    let open: OpenJournal = Box::new(move |path| {
        let (file, answers) = (std::fs::File::create_new(path)?, Arc::clone(&answers));
        let path = path.to_owned();
        let sync = move || match answers.lock().unwrap().pop_front() {
            Some(kind) => Err(kind.into()),
            None => std::fs::metadata(&path).map(drop),
        };
        Ok((Box::new(file), Box::new(sync)))
    });
    Recorder::create_with(folder, "r", &header("r"), open).unwrap()
}

fn at_ms(raw: i64) -> HostTime {
    HostTime(raw * 1_000_000)
}

/// Samples 1 ms apart.
fn record(recorder: &mut Recorder, raws: std::ops::Range<i64>) {
    for raw in raws {
        let sample = ProbeSample { time_s: raw as f64 * 1e-3, raw, ..ProbeSample::default() };
        recorder.append(Item::Probe(sample), at_ms(raw));
    }
}

/// Names, samples and gaps of the finished files.
fn read(finished: &Finished) -> (Vec<String>, Vec<i64>, Vec<Gap>) {
    let (mut names, mut raws, mut gaps) = (Vec::new(), Vec::new(), Vec::new());
    for file in &finished.files {
        let run = read_run(&file.path, &shipped::machine).unwrap();
        names.push(file.path.file_name().unwrap().to_string_lossy().into_owned());
        raws.extend(run.probe_samples.iter().map(|sample| sample.raw));
        gaps.extend(run.gaps);
    }
    (names, raws, gaps)
}

/// The run ended with these files, in which nothing is missing.
fn assert_whole(finished: &Finished, names: &[&str], samples: std::ops::Range<i64>) {
    let (found, raws, gaps) = read(finished);
    assert_eq!(found, names);
    assert_eq!(gaps, []);
    assert_eq!(finished.lost_samples, 0);
    assert!(raws.into_iter().eq(samples));
}

#[test]
fn a_folder_that_misses_a_file_for_one_look_costs_nothing() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let mut recorder = recorder(folder.path(), &answers);
    record(&mut recorder, 0..1000);
    answers.lock().unwrap().push_back(io::ErrorKind::NotFound);
    assert!(!recorder.sync(at_ms(1000)), "what was in it may be on no disk");
    assert_eq!((recorder.failing(), recorder.lost_samples()), (None, 0));
    record(&mut recorder, 1000..2000);
    assert_whole(&recorder.finish(at_ms(2000)).unwrap(), &["r.mcap", "r-2.mcap"], 0..2000);
}

#[test]
fn a_file_that_is_there_again_when_the_next_one_begins_belongs_to_the_run() {
    let (place, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let (folder, other) = (place.path().join("runs"), place.path().join("elsewhere"));
    let mut recorder = recorder(&folder, &answers);
    record(&mut recorder, 0..1000);
    std::fs::rename(&folder, &other).unwrap();
    // No folder can be made at its place.
    std::fs::write(&folder, "").unwrap();
    answers.lock().unwrap().push_back(io::ErrorKind::NotFound);
    assert!(!recorder.sync(at_ms(1000)));
    assert!(recorder.failing().is_some() && recorder.lost_samples() == 0);
    record(&mut recorder, 1000..1500);
    std::fs::remove_file(&folder).unwrap();
    std::fs::rename(&other, &folder).unwrap();
    record(&mut recorder, 1500..3000);
    assert_whole(&recorder.finish(at_ms(3000)).unwrap(), &["r.mcap", "r-2.mcap"], 0..3000);
}

#[test]
fn a_file_that_the_disk_refuses_to_keep_is_over_and_the_next_one_begins_when_it_is_kept() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let mut recorder = recorder(folder.path(), &answers);
    record(&mut recorder, 0..1000);
    // The sync, and that of the file that is tried a second later.
    answers.lock().unwrap().extend([io::ErrorKind::StorageFull; 2]);
    assert!(!recorder.sync(at_ms(1000)));
    assert!(recorder.failing().is_some_and(|why| why.contains("cannot sync")), "{:?}", recorder.failing());
    assert!(!recorder.sync(at_ms(1040)), "what waits in memory is on no disk");
    record(&mut recorder, 1000..4000);
    assert!(recorder.failing().is_none() && recorder.sync(at_ms(4000)));
    assert_whole(&recorder.finish(at_ms(4000)).unwrap(), &["r.mcap", "r-2.mcap"], 0..4000);
}

#[test]
fn a_disk_that_refuses_the_last_sync_of_a_run_costs_no_further_file() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let mut recorder = recorder(folder.path(), &answers);
    record(&mut recorder, 0..1000);
    answers.lock().unwrap().extend([io::ErrorKind::StorageFull; 2]);
    assert_whole(&recorder.finish(at_ms(1000)).unwrap(), &["r.mcap"], 0..1000);
}

#[test]
fn a_folder_that_refuses_its_sync_keeps_the_finished_file_and_finishing_again_ends_the_run() {
    for refused in [0, 1] {
        let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
        let mut recorder = recorder(folder.path(), &answers);
        record(&mut recorder, 0..1000);
        let mut closed = recorder.close(at_ms(1000));
        let syncs = Cell::new(0);
        let sync = |_: &Path| match syncs.replace(syncs.get() + 1) == refused {
            true => Err(io::ErrorKind::StorageFull.into()),
            false => Ok(()),
        };
        if refused == 0 {
            // After the rename, with the journal still there.
            let error = closed.finish_with(&sync).unwrap_err();
            assert!(error.may_pass(), "{error}");
        }
        assert_whole(&closed.finish_with(&sync).unwrap(), &["r.mcap"], 0..1000);
        assert!(!folder.path().join("r.mcap.active").exists());
        assert_eq!(syncs.get(), 2 + (1 - refused));
    }
}

#[test]
fn a_journal_that_went_with_its_finished_file_in_place_is_not_lost() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let mut recorder = recorder(folder.path(), &answers);
    record(&mut recorder, 0..1000);
    let mut closed = recorder.close(at_ms(1000));
    closed.finish_with(&|_| Err(io::ErrorKind::StorageFull.into())).unwrap_err();
    std::fs::remove_file(folder.path().join("r.mcap.active")).unwrap();
    assert_whole(&closed.finish().unwrap(), &["r.mcap"], 0..1000);
}

#[test]
fn another_file_with_the_name_of_a_missing_journal_is_not_taken_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("r.mcap.active");
    let mut recorder = Recorder::create(folder.path(), "r", &header("r")).unwrap();
    record(&mut recorder, 0..1000);
    recorder.flush(at_ms(1000));
    std::fs::remove_file(&journal).unwrap();
    std::fs::write(&journal, "of another program").unwrap();
    assert!(!recorder.sync(at_ms(1000)));
    record(&mut recorder, 1000..2000);
    let finished = recorder.finish(at_ms(2000)).unwrap();
    let (names, raws, gaps) = read(&finished);
    assert_eq!((names, finished.lost_samples), (vec!["r-2.mcap".to_string()], 1000));
    assert!(raws.into_iter().eq(1000..2000));
    let [gap] = &gaps[..] else { panic!("{gaps:?}") };
    assert_eq!((gap.from_s, gap.to_s, gap.lost_samples), (0.0, 0.999, Some(1000)));
    assert_eq!(std::fs::read_to_string(journal).unwrap(), "of another program");
}

#[test]
fn a_missing_journal_without_samples_leaves_no_gap() {
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(folder.path(), "r", &header("r")).unwrap();
    std::fs::remove_file(folder.path().join("r.mcap.active")).unwrap();
    record(&mut recorder, 0..1000);
    assert!(!recorder.sync(at_ms(1000)));
    record(&mut recorder, 1000..2000);
    let finished = recorder.finish(at_ms(2000)).unwrap();
    let (_, raws, gaps) = read(&finished);
    assert_eq!(raws.len() as u64 + finished.lost_samples, 2000);
    assert_eq!(gaps.iter().filter_map(|gap| gap.lost_samples).sum::<u64>(), finished.lost_samples);
}

/// Three journals of two thousand samples each.
fn three(folder: &Path) -> Closed {
    let answers = Answers::default();
    let mut recorder = recorder(folder, &answers);
    for first in [0, 2000] {
        record(&mut recorder, first..first + 2000);
        answers.lock().unwrap().push_back(io::ErrorKind::StorageFull);
        assert!(!recorder.sync(at_ms(first + 2000)));
    }
    record(&mut recorder, 4000..6000);
    recorder.close(at_ms(6000))
}

#[test]
fn a_journal_that_is_gone_costs_its_own_samples_and_no_other() {
    for (gone, names, from) in [
        ("r", ["r-2.mcap", "r-3.mcap"], 0),
        ("r-2", ["r.mcap", "r-3.mcap"], 2000),
        ("r-3", ["r.mcap", "r-2.mcap"], 4000),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut closed = three(folder.path());
        std::fs::remove_file(folder.path().join(format!("{gone}.mcap.active"))).unwrap();
        let finished = closed.finish().unwrap();
        let (found, raws, gaps) = read(&finished);
        assert_eq!(found, names);
        assert_eq!((finished.lost_samples, raws.len()), (2000, 4000), "{gone}");
        let [gap] = &gaps[..] else { panic!("{gaps:?}") };
        assert!(gap.lost_samples == Some(2000) && gap.reason.contains("is not there any more"), "{gap:?}");
        assert_eq!((gap.from_s, gap.to_s), (from as f64 * 1e-3, (from + 1999) as f64 * 1e-3), "{gap:?}");
    }
}

#[test]
fn a_file_that_became_the_last_one_says_what_was_lost_behind_it() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let mut recorder = recorder(folder.path(), &answers);
    record(&mut recorder, 0..1000);
    answers.lock().unwrap().push_back(io::ErrorKind::StorageFull);
    assert!(!recorder.sync(at_ms(1000)));
    record(&mut recorder, 1000..3000);
    let mut closed = recorder.close(at_ms(3000));
    // The first file is written, and its journal cannot be removed yet.
    closed.finish_with(&|_| Err(io::ErrorKind::StorageFull.into())).unwrap_err();
    std::fs::remove_file(folder.path().join("r-2.mcap.active")).unwrap();
    let finished = closed.finish().unwrap();
    let (names, raws, gaps) = read(&finished);
    assert_eq!(names, ["r.mcap"]);
    let [gap] = &gaps[..] else { panic!("{gaps:?}") };
    assert_eq!(
        (gap.lost_samples, raws.len() as u64),
        (Some(finished.lost_samples), 3000 - finished.lost_samples)
    );
    assert!(finished.lost_samples > 0 && !folder.path().join("r.mcap.active").exists());
}

#[test]
fn the_gap_of_a_vanished_journal_begins_with_its_first_sample_whichever_channel_it_is_of() {
    let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
    let mut recorder = recorder(folder.path(), &answers);
    // The batch of the second channel is full before the first sample of the first channel is old enough to be written.
    for raw in 0..300 {
        let time_s = raw as f64 * 1e-4;
        let channel = u16::from(raw > 0);
        let sample = ProbeSample { channel, time_s, raw, ..ProbeSample::default() };
        recorder.append(Item::Probe(sample), HostTime(raw * 100_000));
    }
    recorder.flush(at_ms(30));
    std::fs::remove_file(folder.path().join("r.mcap.active")).unwrap();
    assert!(!recorder.sync(at_ms(30)));
    record(&mut recorder, 1000..2000);
    let (_, _, gaps) = read(&recorder.finish(at_ms(2000)).unwrap());
    let [gap] = &gaps[..] else { panic!("{gaps:?}") };
    assert_eq!((gap.from_s, gap.lost_samples), (0.0, Some(300)));
}

#[test]
fn a_journal_whose_finished_file_is_in_place_is_no_second_run_at_the_next_start() {
    for refused in 0..2 {
        let (folder, answers) = (tempfile::tempdir().unwrap(), Answers::default());
        let mut recorder = recorder(folder.path(), &answers);
        record(&mut recorder, 0..1000);
        let journal = folder.path().join("r.mcap.active");
        if refused == 0 {
            let mut closed = recorder.close(at_ms(1000));
            closed.finish_with(&|_| Err(io::ErrorKind::StorageFull.into())).unwrap_err();
        } else {
            // Of an earlier start: the file with the words of a recovery.
            recorder.close(at_ms(1000));
            let before = std::fs::read(&journal).unwrap();
            crate::recover_orphans(folder.path()).unwrap();
            std::fs::write(&journal, before).unwrap();
        }
        let orphans = crate::recover_orphans(folder.path()).unwrap();
        assert!(orphans.is_empty(), "what is known of a run that ended stays: {orphans:?}");
        let names: Vec<_> =
            std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(names, ["r.mcap"]);
    }
}
