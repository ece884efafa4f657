//! Who analyses a recording: a process of its own, so that what it takes and how it ends is not the service's.

use super::report::write_report;
use crate::analysis::{AnalysisLimits, JudgedBy};
use crate::error::{ServiceError, chain};
use nix::sys::resource::{Resource, setrlimit};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion::results::RunAnswer;
use trunnion_core::Clock;

/// The hidden command of the program that analyses one recording.
pub const COMMAND: &str = "analyse-run";
/// How often the process is looked at.
const LOOK: Duration = Duration::from_millis(50);
/// Longest answer, bytes; that of a cycle of a thousand missing poses has some hundred thousand.
const LONGEST_ANSWER: u64 = 16 << 20;
/// What the runtime says before it aborts (`std::alloc::handle_alloc_error`).
const NO_MEMORY: &str = "memory allocation of";

/// Who analyses.
#[derive(Clone, Debug)]
pub enum Analyst {
    /// This process, without limits.
    Here,
    /// This program, as a process of its own for each run.
    Program(PathBuf),
}

/// Why there is no answer.
pub(super) enum Unanswered {
    /// The service stops.
    Stopped,
    /// It failed; why.
    Failed(String),
}

/// What is analysed, by what, within which limits.
pub(super) struct Task<'a> {
    pub(super) recording: &'a Path,
    pub(super) judged_by: &'a JudgedBy,
    pub(super) date: &'a str,
    pub(super) limits: AnalysisLimits,
}

impl Analyst {
    /// Blocks until the report is written.
    pub(super) fn analyse(
        &self,
        task: &Task<'_>,
        clock: &dyn Clock,
        cancel: &CancellationToken,
    ) -> Result<RunAnswer, Unanswered> {
        match self {
            Self::Here => write_report(task.recording, task.judged_by.model.as_ref(), task.date)
                .map(|report| report.answer)
                .map_err(|failure| Unanswered::Failed(chain(&failure))),
            Self::Program(program) => Process::start(program, task)
                .map_err(|failure| Unanswered::Failed(chain(&failure)))?
                .wait(task.limits, clock, cancel),
        }
    }
}

/// The process of one analysis. It ends with the service: its input does.
struct Process {
    child: Child,
    answer: JoinHandle<String>,
    log: JoinHandle<Log>,
}

/// What a process said last, and whether it had no memory.
#[derive(Default)]
struct Log {
    last: String,
    no_memory: bool,
}

impl Process {
    fn start(program: &Path, task: &Task<'_>) -> Result<Self, ServiceError> {
        let mut command = Command::new(program);
        command.arg(COMMAND).arg(task.recording).args(["--date", task.date, "--with-parent"]);
        command.arg("--memory-mb").arg(task.limits.memory_mb.to_string());
        if let Some(model) = &task.judged_by.file {
            command.arg("--model").arg(model);
        }
        // One line an error, whatever the terminal.
        command.env("COLUMNS", "100000").process_group(0);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(ServiceError::Analyst)?;
        let (out, err) = (child.stdout.take(), child.stderr.take());
        let answer = std::thread::spawn(move || {
            let mut text = String::new();
            let read = out.map(|out| out.take(LONGEST_ANSWER).read_to_string(&mut text));
            // Half an answer is none.
            if matches!(read, Some(Ok(_))) { text } else { String::new() }
        });
        let log = std::thread::spawn(move || {
            let mut log = Log::default();
            for line in err.into_iter().flat_map(|err| BufReader::new(err).lines()).map_while(Result::ok) {
                eprintln!("{line}");
                log.no_memory |= line.starts_with(NO_MEMORY);
                log.last = line;
            }
            log
        });
        Ok(Self { child, answer, log })
    }

    fn wait(
        mut self,
        limits: AnalysisLimits,
        clock: &dyn Clock,
        cancel: &CancellationToken,
    ) -> Result<RunAnswer, Unanswered> {
        let began = clock.now();
        let failed = |why: String| Unanswered::Failed(why);
        let status = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break status,
                Ok(None) if cancel.is_cancelled() => {
                    self.end();
                    return Err(Unanswered::Stopped);
                }
                Ok(None) if clock.now() - began > limits.time => {
                    self.end();
                    let seconds = limits.time.as_secs_f64();
                    return Err(failed(format!(
                        "it took more than {seconds} s (time_s of [analysis]) and was ended"
                    )));
                }
                Ok(None) => std::thread::sleep(LOOK),
                Err(error) => {
                    self.end();
                    return Err(failed(format!("its process cannot be waited for: {error}")));
                }
            }
        };
        let answer = self.answer.join().unwrap_or_default();
        let log = self.log.join().unwrap_or_default();
        match serde_json::from_str(&answer) {
            // 3: without a verdict.
            Ok(answer) if matches!(status.code(), Some(0 | 3)) => Ok(answer),
            _ => Err(failed(why(status, &log, limits))),
        }
    }

    /// Ends the process and what it started.
    fn end(&mut self) {
        let group = i32::try_from(self.child.id()).map(Pid::from_raw);
        if let Ok(group) = group
            && let Err(error) = killpg(group, Signal::SIGKILL)
        {
            tracing::warn!(%error, "an analysis cannot be ended");
        }
        if let Err(error) = self.child.wait() {
            tracing::warn!(%error, "an analysis cannot be waited for");
        }
    }
}

fn why(status: ExitStatus, log: &Log, limits: AnalysisLimits) -> String {
    let last = log.last.trim_start_matches("trunnion: ");
    match (status.code(), status.signal()) {
        _ if log.no_memory => {
            format!("it needed more than {} MB (memory_mb of [analysis])", limits.memory_mb)
        }
        (Some(code), _) if last.is_empty() => format!("it ended with exit code {code} and said nothing"),
        (Some(_), _) => last.to_owned(),
        (None, Some(9)) => "it was killed, by a person or because the computer had no memory left".into(),
        (None, signal) => format!("it was ended by signal {}: {last}", signal.unwrap_or_default()),
    }
}

/// What the process of an analysis does first: no more memory than this, and the first to go when the computer has none left.
///
/// # Errors
/// When the system refuses.
pub fn limit_memory(memory_mb: f64) -> std::io::Result<()> {
    let bytes = (memory_mb * 1e6) as u64;
    setrlimit(Resource::RLIMIT_DATA, bytes, bytes)?;
    setrlimit(Resource::RLIMIT_CORE, 0, 0)?;
    // Without /proc nothing is lost but the order in which processes are ended.
    std::fs::write("/proc/self/oom_score_adj", "500").ok();
    Ok(())
}

/// Ends this process when its input ends: with the program that started it, however that ended.
pub fn end_with_parent() {
    std::thread::spawn(|| {
        let mut nothing = [0];
        while std::io::stdin().read(&mut nothing).is_ok_and(|read| read > 0) {}
        std::process::exit(1);
    });
}
