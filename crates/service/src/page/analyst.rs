//! Who answers the questions of the page: a process with the limits of an analysis. It keeps the runs that it analysed; what
//! takes too long or too much memory ends it, and the next question starts another.

use super::analysed::AnalysedRuns;
use super::question::{Head, NoAnswer, Question, Reply};
use crate::analysis::{AnalysisLimits, Analyst};
use crate::child::{LOOK, Process, Unanswered, ended};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{ChildStdin, ChildStdout};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use tokio_util::sync::CancellationToken;
use trunnion_core::{Clock, chain};

/// The hidden command of the program that answers.
const COMMAND: &str = "answer-page";
/// Longest text, bytes: what-if of 10 000 poses has 9 MB.
const LONGEST_TEXT: usize = 256 << 20;

/// Who answers, within which limits.
pub struct PageAnalyst {
    analyst: Analyst,
    limits: AnalysisLimits,
    clock: Arc<dyn Clock>,
    cancel: CancellationToken,
    at_work: Mutex<AtWork>,
}

#[derive(Default)]
struct AtWork {
    here: AnalysedRuns,
    process: Option<Answering>,
}

/// A process that answers.
struct Answering {
    process: Process,
    questions: ChildStdin,
    answers: Receiver<Result<Reply, NoAnswer>>,
    answered: usize,
}

impl PageAnalyst {
    /// Nothing is started before the first question.
    pub fn new(analyst: Analyst, limits: AnalysisLimits, clock: Arc<dyn Clock>) -> Self {
        Self { analyst, limits, clock, cancel: CancellationToken::new(), at_work: Mutex::default() }
    }

    /// Blocks until there is an answer.
    pub(super) fn ask(&self, question: &Question) -> Result<Reply, NoAnswer> {
        let mut at_work = self.at_work.lock().unwrap_or_else(PoisonError::into_inner);
        match &self.analyst {
            Analyst::Here => at_work.here.answer(question),
            Analyst::Program(program) => loop {
                let mut answering = match at_work.process.take() {
                    Some(answering) => answering,
                    None => Answering::start(program, self.limits)?,
                };
                match answering.ask(question, self.clock.as_ref(), &self.cancel) {
                    Ok(answer) => {
                        answering.answered += 1;
                        at_work.process = Some(answering);
                        return answer;
                    }
                    // It held other runs too: this one has a whole process to itself then.
                    Err(Gone::Ended(status)) if answering.answered > 0 => {
                        tracing::info!("a process that answered ended: {}", answering.process.why(status));
                    }
                    Err(Gone::Ended(status)) => return Err(NoAnswer::Failed(answering.process.why(status))),
                    Err(Gone::LetGo(why)) => return Err(NoAnswer::Failed(why)),
                }
            },
        }
    }

    /// Ends what is under way.
    pub(super) fn stop(&self) {
        self.cancel.cancel();
    }
}

/// Why a process answers no more.
enum Gone {
    /// It ended.
    Ended(std::process::ExitStatus),
    /// It was ended; why.
    LetGo(String),
}

impl Answering {
    fn start(program: &Path, limits: AnalysisLimits) -> Result<Self, NoAnswer> {
        let started = Process::start(program, limits, |command| {
            command.arg(COMMAND);
        });
        let mut process = started.map_err(|failure| NoAnswer::Failed(chain(&failure)))?;
        let (questions, out) = (process.take_input(), process.take_output());
        let (Some(questions), Some(out)) = (questions, out) else {
            return Err(NoAnswer::Failed("its process cannot be spoken with".into()));
        };
        let (received, answers) = mpsc::channel();
        std::thread::spawn(move || {
            let mut out = BufReader::new(out);
            while let Some(answer) = read(&mut out) {
                if received.send(answer).is_err() {
                    break;
                }
            }
        });
        Ok(Self { process, questions, answers, answered: 0 })
    }

    fn ask(
        &mut self,
        question: &Question,
        clock: &dyn Clock,
        cancel: &CancellationToken,
    ) -> Result<Result<Reply, NoAnswer>, Gone> {
        let text = serde_json::to_string(question).map_err(|failure| Gone::LetGo(failure.to_string()))?;
        // A process that is gone is noticed below.
        let asked = writeln!(self.questions, "{text}").and_then(|()| self.questions.flush());
        tracing::debug!(?asked, "asked");
        let answers = &self.answers;
        let looked = self.process.until(clock, cancel, |child| match answers.recv_timeout(LOOK) {
            Ok(answer) => Ok(Some(Ok(answer))),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            // Its output ended, and so does it.
            Err(RecvTimeoutError::Disconnected) => Ok(ended(child)?.map(Err)),
        });
        match looked {
            Ok(Ok(answer)) => Ok(answer),
            Ok(Err(status)) => Err(Gone::Ended(status)),
            Err(Unanswered::Stopped) => Err(Gone::LetGo("the page ends".into())),
            Err(Unanswered::Failed(why)) => Err(Gone::LetGo(why)),
        }
    }
}

/// The next answer; `None` when there are no more.
fn read(out: &mut BufReader<ChildStdout>) -> Option<Result<Reply, NoAnswer>> {
    let mut head = String::new();
    out.read_line(&mut head).ok()?;
    match serde_json::from_str(&head).ok()? {
        Head::NoAnswer(no_answer) => Some(Err(no_answer)),
        Head::Reply { bytes, found } if bytes <= LONGEST_TEXT => {
            let mut text = vec![0; bytes];
            out.read_exact(&mut text).ok()?;
            Some(Ok(Reply { text: String::from_utf8(text).ok()?, found }))
        }
        Head::Reply { .. } => None,
    }
}
