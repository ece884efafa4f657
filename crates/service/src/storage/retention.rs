//! Which raw recordings go.

use super::config::{DAY, StorageConfig, mb};
use super::today::{Today, WallClock};
use crate::clock::moment;
use crate::run_record::{self, Known, is_pending};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use trunnion::results::RunRecord;
use trunnion_core::chain;

/// A run whose samples are there.
#[derive(Clone, Debug)]
pub(super) struct Stored {
    recording: PathBuf,
    record: RunRecord,
    bytes: u64,
    written: SystemTime,
    is_pending: bool,
}

/// A recording that was removed.
#[derive(Clone, Debug, PartialEq)]
pub struct Removed {
    /// Name of the run.
    pub run: String,
    /// What it took, MB.
    pub mb: f64,
    /// Why.
    pub why: String,
}

impl Stored {
    /// Every run of a folder, the newest first, without those that are linked from elsewhere: they take no room here.
    pub(super) fn read(folder: &Path, tries: u32) -> Vec<Self> {
        let stored = |(recording, record): (PathBuf, RunRecord)| {
            let files = run_record::every_file(&recording, &record);
            let about: Vec<_> = files.iter().filter_map(|file| file.metadata().ok()).collect();
            let written = about.first()?.modified().ok()?;
            let bytes = about.iter().map(std::fs::Metadata::len).sum();
            let is_pending = is_pending(&record, tries);
            Some(Self { recording, record, bytes, written, is_pending })
        };
        let runs = Known::read(folder).runs.into_iter();
        runs.filter(|(recording, _)| !recording.is_symlink()).filter_map(stored).collect()
    }

    /// Removes its recordings and keeps why.
    ///
    /// # Errors
    /// When the system refuses: which file, and why, for a person.
    pub(super) fn remove(&self, why: &str, now: SystemTime) -> Result<Removed, String> {
        // Its own recording last: as long as it is there, the run is in the list and is tried again.
        for file in run_record::every_file(&self.recording, &self.record).into_iter().rev() {
            match std::fs::remove_file(&file) {
                // Gone at an earlier try that another file refused, or by hand.
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
                removed => removed.map_err(|error| format!("{}: {error}", file.display()))?,
            }
        }
        let ns = now.duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
        let at = moment(i64::try_from(ns).unwrap_or(i64::MAX));
        let record = RunRecord { removed: Some(format!("{at}: {why}")), ..self.record.clone() };
        if let Err(failure) = run_record::write(&self.recording, &record) {
            tracing::warn!("the state of a run was not written: {}", chain(&failure));
        }
        let run =
            self.recording.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let removed = Removed { run, mb: mb(self.bytes), why: why.into() };
        tracing::info!(
            run = removed.run,
            mb = removed.mb.round(),
            "the samples of a run were removed, its report stays: {why}"
        );
        Ok(removed)
    }
}

/// Why the dates of the recordings say nothing of their order, for a person: one of them is later than now. The order is that of
/// the times of the files, and a clock that was set back makes the newest look the oldest. The clock of a share that is some seconds
/// ahead is none that was set.
pub(super) fn doubt(stored: &[Stored], now: SystemTime) -> Option<String> {
    let late = stored.iter().find(|run| run.written > now + WallClock::SET)?;
    Some(format!(
        "{} is dated later than now: the clock of the computer was set, and no recording is removed until its date has come or the file is elsewhere",
        late.recording.display()
    ))
}

/// How old each is by every clock that was there; `stored` is in order, the newest first.
///
/// Time that lies between two recordings, or between the last and now, counts as none where it is longer than `keep`: a clock that
/// was set while the service did not run looks the same as a machine that was not measured.
fn ages(stored: &[Stored], keep: Duration, today: Today) -> Vec<Duration> {
    let mut later = today.proven();
    let mut lived = Duration::ZERO;
    let age = |run: &Stored| {
        let step = later.duration_since(run.written).unwrap_or_default();
        later = run.written;
        lived += if step > keep { Duration::ZERO } else { step };
        lived.min(today.proven().duration_since(run.written).unwrap_or_default())
    };
    stored.iter().map(age).collect()
}

/// Indices of what goes, with the reason; `stored` is in order, the newest first, which stays.
pub(super) fn to_remove(
    stored: &[Stored],
    config: &StorageConfig,
    missing_mb: f64,
    today: Today,
) -> Vec<(usize, String)> {
    if doubt(stored, today.wall).is_some() {
        return Vec::new();
    }
    let ages = ages(stored, config.keep.unwrap_or(Duration::MAX), today);
    let mut total_mb: f64 = stored.iter().map(|run| mb(run.bytes)).sum();
    let mut missing_mb = missing_mb;
    let mut going = Vec::new();
    for (index, run) in stored.iter().enumerate().skip(1).rev().filter(|(_, run)| !run.is_pending) {
        let why = match (config.keep, config.budget_mb) {
            (Some(keep), _) if ages[index] > keep => {
                format!("it was older than {} days (keep_days of [storage])", keep.div_duration_f64(DAY))
            }
            (_, Some(budget)) if total_mb > budget => {
                format!("the recordings took more than {budget} MB (budget_mb of [storage])")
            }
            _ if missing_mb > 0.0 => {
                "the disk had no room for the next cycle (keep_free_mb of [storage])".into()
            }
            _ => continue,
        };
        total_mb -= mb(run.bytes);
        missing_mb -= mb(run.bytes);
        going.push((index, why));
    }
    going
}

#[cfg(test)]
mod tests {
    use super::*;
    /// Runs of 100 MB, one a day, the newest first; these have no report yet.
    fn stored(count: usize, pending: &[usize]) -> (Vec<Stored>, SystemTime) {
        let now = UNIX_EPOCH + 1000 * DAY;
        let run = |k: usize| Stored {
            recording: format!("{k}.mcap").into(),
            record: RunRecord::default(),
            bytes: 100_000_000,
            written: now - DAY * u32::try_from(k).unwrap(),
            is_pending: pending.contains(&k),
        };
        ((0..count).map(run).collect(), now)
    }

    fn going(config: StorageConfig, missing_mb: f64, (stored, now): (Vec<Stored>, SystemTime)) -> Vec<usize> {
        to_remove(&stored, &config, missing_mb, Today::of(now)).into_iter().map(|(index, _)| index).collect()
    }

    #[test]
    fn the_oldest_go_first_and_never_the_newest_or_what_has_no_report() {
        let none = StorageConfig { keep_free_mb: 0.0, budget_mb: None, keep: None };
        assert_eq!(going(none, 0.0, stored(5, &[])), [0_usize; 0]);
        let budget = StorageConfig { budget_mb: Some(250.0), ..none };
        assert_eq!(going(budget, 0.0, stored(5, &[])), [4, 3, 2]);
        assert_eq!(going(budget, 0.0, stored(5, &[4, 2])), [3, 1]);
        let aged = StorageConfig { keep: Some(DAY.mul_f64(2.5)), ..none };
        assert_eq!(going(aged, 0.0, stored(5, &[])), [4, 3]);
        assert_eq!(going(aged, 150.0, stored(5, &[])), [4, 3]);
        assert_eq!(going(budget, 350.0, stored(5, &[])), [4, 3, 2, 1]);
        // A budget that one run exceeds keeps that run.
        assert_eq!(going(StorageConfig { budget_mb: Some(1.0), ..none }, 1e9, stored(1, &[])), [0_usize; 0]);
    }

    #[test]
    fn a_clock_that_was_set_ages_nothing() {
        let config = StorageConfig { keep_free_mb: 0.0, budget_mb: None, keep: Some(DAY.mul_f64(2.5)) };
        let year = DAY * 365;
        let going = |stored: &[Stored], wall: SystemTime, set_forward: Duration| {
            to_remove(stored, &config, 0.0, Today { wall, set_forward })
                .into_iter()
                .map(|(index, _)| index)
                .collect::<Vec<_>>()
        };
        let (mut runs, now) = stored(5, &[]);
        assert_eq!(going(&runs, now, Duration::ZERO), [4, 3]);
        // While the service runs: what is older goes, and nothing else.
        assert_eq!(going(&runs, now + year, year), [4, 3]);
        // Before it began, and it looks like a year without a cycle: what was old enough before goes.
        assert_eq!(going(&runs, now + year, Duration::ZERO), [4, 3]);
        // A cycle of the wrong date, with the service that saw the clock being set, and with another.
        runs[0].written = now + year;
        assert_eq!(going(&runs, now + year + DAY, year), [4]);
        assert_eq!(going(&runs, now + year + DAY, Duration::ZERO), [4, 3]);
        // The clock is right again: which recording is the newest is not known.
        assert_eq!(going(&runs, now, Duration::ZERO), [0_usize; 0]);
        let full = StorageConfig { budget_mb: Some(1.0), ..config };
        assert_eq!(to_remove(&runs, &full, 1e9, Today::of(now)), []);
        assert!(doubt(&runs, now).unwrap().contains("0.mcap is dated later than now"));
        assert_eq!(doubt(&runs, now + year), None);
        // A share whose clock is some seconds ahead.
        runs[0].written = now + Duration::from_secs(5);
        assert_eq!(doubt(&runs, now), None);
        assert_eq!(going(&runs, now, Duration::ZERO), [4, 3]);
    }
}
