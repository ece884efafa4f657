//! Recordings become reports, one at a time: the computer also measures.
//!
//! Before an analysis begins, the state of the run on disk counts it: what ends the program each time is not tried for ever.

use super::analyst::{Task, analyse};
use super::joining;
use super::states::States;
use crate::analysis::{AnalysisLimits, Analyst, JudgedBy};
use crate::board::Board;
use crate::child::Unanswered;
use crate::clock::{day, moment};
use crate::error::ServiceError;
use crate::page::Runs;
use crate::run_record;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use tracing::{error, info, warn};
use trunnion::results::{CycleProgress, CycleState, ResultNow, RunAnswer, RunFailed, RunRecord, RunState};
use trunnion_core::{Clock, chain};

/// Analyses of a running service.
#[derive(Clone)]
pub(super) struct Analyses {
    pub(super) analyst: Analyst,
    pub(super) limits: AnalysisLimits,
    pub(super) board: Board,
    pub(super) states: States,
    pub(super) clock: Arc<dyn Clock>,
    pub(super) cancel: CancellationToken,
    pub(super) one: Arc<Semaphore>,
    /// The runs of the folder, for what each is compared with.
    pub(super) runs: Arc<Runs>,
}

impl Analyses {
    /// Analyses a recording and reports on the board; its state on disk says how far it is.
    pub(super) async fn report(&self, recording: PathBuf, record: RunRecord, judged_by: JudgedBy) {
        let part = run_name(&recording);
        // A semaphore that is never closed.
        let turn = self.one.acquire().await;
        if self.cancel.is_cancelled() {
            return;
        }
        let at = moment(self.clock.wall_ns());
        let kept = (recording.clone(), record.clone());
        let joining = tokio::task::spawn_blocking(move || joining::whole(recording, record, at));
        let (recording, record) = joining.await.unwrap_or(kept);
        let name = run_name(&recording);
        if name != part {
            self.states.joined(&part, &name, run_record::file_name(&recording));
        }
        let before = record.clone();
        let begun = RunRecord {
            state: RunState::Analysing,
            tries: record.tries + 1,
            // A part is a run of its own again where the joined one is gone.
            joined_into: None,
            ..record
        };
        self.keep(&recording, &begun);
        self.keep_parts(&recording, &begun);
        let (this, path) = (self.clone(), recording.clone());
        let analysing = tokio::task::spawn_blocking(move || {
            let date = day(this.clock.wall_ns());
            let task = Task { recording: &path, judged_by: &judged_by, date: &date, limits: this.limits };
            analyse(&this.analyst, &task, this.clock.as_ref(), &this.cancel)
        });
        let broken = |_| Err(Unanswered::Failed(ServiceError::Broken("analysis").to_string()));
        match analysing.await.unwrap_or_else(broken) {
            Ok(answer) => {
                self.done(&recording, &name, begun, answer);
                drop(turn);
                self.publish_alarms().await;
            }
            Err(Unanswered::Failed(why)) => self.failed(&recording, &name, RunRecord { why, ..begun }),
            Err(Unanswered::Stopped) => {
                info!(run = name, "the service stops; it is analysed at the next start");
                self.keep(&recording, &before);
            }
        }
    }

    fn done(&self, recording: &Path, name: &str, begun: RunRecord, answer: RunAnswer) {
        publish(&self.board, &answer);
        self.keep(recording, &run_record::reported(begun, answer));
        self.states.go_on(CycleState::Done, name, CycleProgress::default());
    }

    /// What of the newest run lies outside its limits, on the board, unless the service stops: a folder that hangs holds nobody up.
    pub(super) async fn publish_alarms(&self) {
        let (runs, board) = (self.runs.clone(), self.board.clone());
        let publishing = tokio::task::spawn_blocking(move || runs.publish_alarms(&board));
        let published = tokio::select! {
            () = self.cancel.cancelled() => return,
            published = publishing => published,
        };
        match published {
            Ok(Ok(())) => {}
            Ok(Err(refusal)) => warn!("limits of the values are not known: {}", chain(&refusal)),
            Err(_) => {
                warn!("limits of the values are not known: {}", ServiceError::Broken("limits of the values"))
            }
        }
    }

    fn failed(&self, recording: &Path, name: &str, begun: RunRecord) {
        let (tries, most) = (begun.tries, self.limits.tries);
        let again =
            if tries < most { "it is tried again at the next start" } else { "it is not tried again" };
        error!(run = name, tries, "the analysis failed: {}; {again}", begun.why);
        self.report_failure(name, &begun.why);
        self.keep(recording, &RunRecord { state: RunState::Failed, ..begun });
    }

    /// A run that has no report.
    pub(super) fn report_failure(&self, name: &str, why: &str) {
        let failed = RunFailed { run: name.into(), why: why.into(), ..RunFailed::default() };
        self.board.publish(&ResultNow::Failed(failed));
        let now = CycleProgress { why: Some(why.into()), ..CycleProgress::default() };
        self.states.go_on(CycleState::Failed, name, now);
    }

    /// The states of what a run was joined from say so, in place of what they were alone.
    pub(super) fn keep_parts(&self, recording: &Path, record: &RunRecord) {
        let joined_into = run_record::file_name(recording);
        for part in record.joined_from.iter().map(|name| recording.with_file_name(name)) {
            match run_record::read(&part) {
                Some(part) if part.joined_into == joined_into => {}
                // What was removed by hand has no state.
                None if !part.exists() => {}
                alone => {
                    let alone = alone.unwrap_or_default();
                    let why = "the service ended while its cycle was recorded".into();
                    let joined_into = joined_into.clone();
                    self.keep(&part, &RunRecord { state: RunState::Joined, why, joined_into, ..alone });
                }
            }
        }
    }

    /// Writes the state of a run; a disk that refuses costs no report.
    pub(super) fn keep(&self, recording: &Path, record: &RunRecord) {
        let record = RunRecord { at: moment(self.clock.wall_ns()), ..record.clone() };
        if let Err(failure) = run_record::write(recording, &record) {
            warn!("the state of a run was not written: {}", chain(&failure));
        }
    }
}

fn run_name(recording: &Path) -> String {
    recording.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// What an analysis found, on the board.
pub(super) fn publish(board: &Board, answer: &RunAnswer) {
    board.publish(&ResultNow::Found(Box::new(answer.result.clone())));
    if let Some(quality) = &answer.quality {
        board.publish(quality);
    }
}
