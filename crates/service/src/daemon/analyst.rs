//! Who analyses a recording: a process of its own, so that what it takes and how it ends is not the service's.

use super::report::write_report;
use crate::analysis::{AnalysisLimits, Analyst, JudgedBy};
use crate::child::{Process, Unanswered, ended};
use crate::error::ServiceError;
use std::io::Read;
use std::path::Path;
use std::process::ChildStdout;
use std::thread::JoinHandle;
use tokio_util::sync::CancellationToken;
use trunnion::results::RunAnswer;
use trunnion_core::{Clock, chain};

/// The hidden command of the program that analyses one recording.
const COMMAND: &str = "analyse-run";
/// Longest answer, bytes; that of a cycle of a thousand missing poses has some hundred thousand.
const LONGEST_ANSWER: u64 = 16 << 20;

/// What is analysed, by what, within which limits.
pub(super) struct Task<'a> {
    pub(super) recording: &'a Path,
    pub(super) judged_by: &'a JudgedBy,
    pub(super) date: &'a str,
    pub(super) limits: AnalysisLimits,
}

/// Blocks until the report is written.
pub(super) fn analyse(
    analyst: &Analyst,
    task: &Task<'_>,
    clock: &dyn Clock,
    cancel: &CancellationToken,
) -> Result<RunAnswer, Unanswered> {
    match analyst {
        Analyst::Here => write_report(task.recording, task.judged_by.model.as_ref(), task.date)
            .map(|report| report.answer)
            .map_err(|failure| Unanswered::Failed(chain(&failure))),
        Analyst::Program(program) => {
            let mut process = start(program, task).map_err(|failure| Unanswered::Failed(chain(&failure)))?;
            let answer = process.take_output().map(read);
            let status = process.until(clock, cancel, ended)?;
            let answer = answer.and_then(|answer| answer.join().ok()).unwrap_or_default();
            match serde_json::from_str(&answer) {
                // 3: without a verdict.
                Ok(answer) if matches!(status.code(), Some(0 | 3)) => Ok(answer),
                _ => Err(Unanswered::Failed(process.why(status))),
            }
        }
    }
}

fn start(program: &Path, task: &Task<'_>) -> Result<Process, ServiceError> {
    Process::start(program, task.limits, |command| {
        command.arg(COMMAND).arg(task.recording).args(["--date", task.date, "--with-parent"]);
        if let Some(model) = &task.judged_by.file {
            command.arg("--model").arg(model);
        }
    })
}

fn read(out: ChildStdout) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = String::new();
        // Half an answer is none.
        if out.take(LONGEST_ANSWER).read_to_string(&mut text).is_ok() { text } else { String::new() }
    })
}
