//! What was left when the program ended: journals become recordings, recordings without a report are analysed.

use super::analyses::{Analyses, publish};
use crate::analysis::JudgedBy;
use crate::clock::moment;
use crate::cycles::Cycles;
use crate::run_record::{self, Known, is_pending};
use std::path::{Path, PathBuf};
use tokio::sync::OwnedSemaphorePermit;
use tracing::{info, warn};
use trunnion::results::{RunRecord, RunState};
use trunnion_core::chain;

impl Analyses {
    /// Publishes the last report again.
    pub(super) fn publish_last(&self, known: &Known) {
        if let Some(answer) = known.newest_report().and_then(|record| record.answer.as_ref()) {
            publish(&self.board, answer);
        }
    }

    /// Recovers and analyses what was left, one run after the other, until the service stops. `known` is from before the first
    /// cycle; `usual` judges a run whose cycle is not configured any more; nothing is analysed before `turn` is given up.
    pub(super) async fn resume(
        self,
        folder: PathBuf,
        known: Known,
        cycles: Cycles,
        usual: JudgedBy,
        turn: Option<OwnedSemaphorePermit>,
    ) {
        let this = self.clone();
        let recovered = tokio::task::spawn_blocking(move || this.recover(&folder)).await.unwrap_or_default();
        drop(turn);
        for (recording, record) in recovered.into_iter().chain(known.runs) {
            if self.cancel.is_cancelled() {
                return;
            }
            self.keep_parts(&recording, &record);
            match is_pending(&record, self.limits.tries) {
                true => {
                    let (run, state) = (recording.display(), record.state.as_str());
                    info!(%run, state, tries = record.tries, "analysed now: it has no report");
                    let record =
                        if record.at.is_empty() { self.looked_at(&recording, record) } else { record };
                    let judged_by = cycles.judged_by(&record.cycle).unwrap_or_else(|| usual.clone());
                    self.report(recording, record, judged_by).await;
                }
                false => self.leave(&recording, record),
            }
        }
    }

    /// A recording that has no state yet.
    fn looked_at(&self, recording: &Path, record: RunRecord) -> RunRecord {
        run_record::of_recording(recording, record.state, moment(self.clock.wall_ns()))
    }

    /// What was tried too often says so.
    fn leave(&self, recording: &Path, record: RunRecord) {
        let run = recording.display();
        match record.state {
            RunState::Analysing => {
                let why = format!("the program ended while it was analysed, {} times", record.tries);
                warn!(%run, "not analysed again: {why}");
                self.keep(recording, &RunRecord { state: RunState::Failed, why, ..record });
            }
            RunState::Failed => info!(%run, tries = record.tries, "not analysed again: {}", record.why),
            RunState::Recorded
            | RunState::Recovered
            | RunState::Done
            | RunState::NotJudged
            | RunState::Joined => {}
        }
    }

    /// Finishes recordings that a kill left behind. What cannot be recovered stays where it is, and its state says why.
    fn recover(&self, folder: &Path) -> Vec<(PathBuf, RunRecord)> {
        let orphans = match trunnion_record::recover_orphans(folder) {
            Ok(orphans) => orphans,
            Err(failure) => {
                warn!("cannot look for unfinished recordings: {}", chain(&failure));
                return Vec::new();
            }
        };
        let at = moment(self.clock.wall_ns());
        let mut recovered = Vec::new();
        for orphan in orphans {
            match orphan.finished {
                Ok(file) => {
                    warn!(file = %file.path.display(), "recovered a recording that was not finished");
                    let why = "the program ended while it was recorded".into();
                    let record = run_record::of_recording(&file.path, RunState::Recovered, at.clone());
                    let record = RunRecord { why, ..record };
                    self.keep(&file.path, &record);
                    recovered.push((file.path, record));
                }
                Err(failure) => {
                    let why = chain(&failure);
                    warn!("cannot recover a recording: {why}");
                    let record = RunRecord { state: RunState::Failed, why, ..RunRecord::default() };
                    self.keep(&orphan.recording, &record);
                }
            }
        }
        recovered
    }
}
