//! A process of this program that analyses, with limits of time and memory: what it takes and how it ends is not the caller's.

use crate::analysis::AnalysisLimits;
use crate::error::ServiceError;
use nix::sys::resource::{Resource, setrlimit};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion_core::Clock;

/// How long a look at the process may take: what is wanted of it stops, or its time is over.
pub(crate) const LOOK: Duration = Duration::from_millis(50);
/// What the runtime says before it aborts (`std::alloc::handle_alloc_error`).
const NO_MEMORY: &str = "memory allocation of";
/// What the runtime says after a panic, and is no reason.
const HOW_TO_TRACE: &str = "note: run with `RUST_BACKTRACE";
/// What variables of the allocator begin with. The unit sets some so that a service of years keeps no memory; an analysis ends soon, and takes half
/// as long again with them.
const OF_THE_ALLOCATOR: &str = "MALLOC_";

/// Whether a process has ended; waits for [`LOOK`] where it has not.
pub(crate) fn ended(child: &mut Child) -> std::io::Result<Option<ExitStatus>> {
    let ended = child.try_wait()?;
    if ended.is_none() {
        // std has no wait for a process with a limit, and it is looked too whether anybody still wants it.
        std::thread::sleep(LOOK);
    }
    Ok(ended)
}

/// Why there is no answer.
pub(crate) enum Unanswered {
    /// It is no longer wanted.
    Stopped,
    /// It failed; why.
    Failed(String),
}

/// A running process. It ends with the program that started it: its input does.
pub(crate) struct Process {
    child: Child,
    limits: AnalysisLimits,
    /// What it said last.
    log: JoinHandle<String>,
    /// It had no memory.
    no_memory: Arc<AtomicBool>,
}

impl Process {
    /// Starts a command of the program within limits; its log goes to ours.
    pub(crate) fn start(
        program: &Path,
        limits: AnalysisLimits,
        arguments: impl FnOnce(&mut Command),
    ) -> Result<Self, ServiceError> {
        let mut command = Command::new(program);
        arguments(&mut command);
        command.arg("--memory-mb").arg(limits.memory_mb.to_string());
        // One line an error, whatever the terminal.
        command.env("COLUMNS", "100000").process_group(0);
        // A trace that finds no memory waits for itself for ever [std::sys::backtrace holds its lock while the report of the memory asks for it].
        command.env("RUST_BACKTRACE", "0");
        let names = std::env::vars_os().map(|(name, _)| name);
        names.filter(|name| name.to_string_lossy().starts_with(OF_THE_ALLOCATOR)).for_each(|name| {
            command.env_remove(name);
        });
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(ServiceError::Analyst)?;
        let err = child.stderr.take();
        let no_memory = Arc::new(AtomicBool::new(false));
        let seen = no_memory.clone();
        let log = std::thread::spawn(move || {
            let mut last = String::new();
            for line in err.into_iter().flat_map(|err| BufReader::new(err).lines()).map_while(Result::ok) {
                eprintln!("{line}");
                if line.starts_with(NO_MEMORY) {
                    seen.store(true, Ordering::Relaxed);
                }
                if !line.starts_with(HOW_TO_TRACE) {
                    last = line;
                }
            }
            last
        });
        Ok(Self { child, limits, log, no_memory })
    }

    /// What it reads; `None` when it was taken. Whoever takes it keeps the process alive with it.
    pub(crate) fn take_input(&mut self) -> Option<ChildStdin> {
        self.child.stdin.take()
    }

    /// What it says; `None` when it was taken.
    pub(crate) fn take_output(&mut self) -> Option<ChildStdout> {
        self.child.stdout.take()
    }

    /// Looks until there is something; ends the process when its time is over or nobody wants it any more. A look that finds nothing
    /// waits for [`LOOK`].
    pub(crate) fn until<T>(
        &mut self,
        clock: &dyn Clock,
        cancel: &CancellationToken,
        mut look: impl FnMut(&mut Child) -> std::io::Result<Option<T>>,
    ) -> Result<T, Unanswered> {
        let began = clock.now();
        loop {
            match look(&mut self.child) {
                Ok(Some(found)) => return Ok(found),
                Ok(None) if cancel.is_cancelled() => {
                    self.end();
                    return Err(Unanswered::Stopped);
                }
                Ok(None) if clock.now() - began > self.limits.time => {
                    self.end();
                    let seconds = self.limits.time.as_secs_f64();
                    return Err(Unanswered::Failed(format!(
                        "it took more than {seconds} s (time_s of [analysis]) and was ended"
                    )));
                }
                // It is at its end and may not reach it without memory. How it ended is found by the next look.
                Ok(None) if self.no_memory.load(Ordering::Relaxed) => self.kill(),
                Ok(None) => {}
                Err(error) => {
                    self.end();
                    return Err(Unanswered::Failed(format!("its process cannot be waited for: {error}")));
                }
            }
        }
    }

    /// Ends the process and what it started; waits for it.
    fn end(&mut self) {
        self.kill();
        if let Err(error) = self.child.wait() {
            tracing::warn!(%error, "an analysis cannot be waited for");
        }
    }

    fn kill(&self) {
        let group = i32::try_from(self.child.id()).map(Pid::from_raw);
        if let Ok(group) = group
            && let Err(error) = killpg(group, Signal::SIGKILL)
        {
            tracing::warn!(%error, "an analysis cannot be ended");
        }
    }

    /// Why a process that ended so gave no answer.
    pub(crate) fn why(self, status: ExitStatus) -> String {
        let log = self.log.join().unwrap_or_default();
        let last = log.trim_start_matches("trunnion: ");
        match (status.code(), status.signal()) {
            _ if self.no_memory.load(Ordering::Relaxed) => {
                format!("it needed more than {} MB (memory_mb of [analysis])", self.limits.memory_mb)
            }
            (Some(code), _) if last.is_empty() => format!("it ended with exit code {code} and said nothing"),
            (Some(_), _) => last.to_owned(),
            (None, Some(9)) => "it was killed, by a person or because the computer had no memory left".into(),
            (None, signal) => format!("it was ended by signal {}: {last}", signal.unwrap_or_default()),
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::SystemClock;

    #[test]
    fn a_process_without_memory_that_does_not_end_is_ended_and_says_which_limit_it_was() {
        let limits = AnalysisLimits { time: Duration::from_secs(60), memory_mb: 64.0, tries: 1 };
        let mut process = Process::start(Path::new("/bin/sh"), limits, |command| {
            command.args(["-c", "echo \"memory allocation of 786432 bytes failed\" >&2; sleep 600"]);
        })
        .unwrap();
        let ended = process.until(&SystemClock::start(), &CancellationToken::new(), ended);
        let Ok(status) = ended else { panic!("it was waited for until its time was over") };
        assert_eq!(process.why(status), "it needed more than 64 MB (memory_mb of [analysis])");
    }
}
