//! Analysed recordings, which answer the questions of the page; in a process of their own unless a test has them here.

use super::question::{Asks, Head, NoAnswer, Question, Reply, Step, Typed};
use super::stamp::{Stamps, files_of, own_model};
use crate::found::found;
use crate::run_record;
use std::collections::VecDeque;
use std::io::{BufRead, Write};
use std::path::PathBuf;
use std::sync::mpsc;
use trunnion::history::{Keeper, changed, next_day};
use trunnion::page::label;
use trunnion::report::{Language, findings_html, report_html};
use trunnion::results::{RunFound, sentences, to_json_line};
use trunnion::{Compared, Filing, FormulaText, MethodOptions, Model};
use trunnion_core::chain;

/// Analysed runs that are kept; a run of 10 000 points needs some 30 MB.
const MOST_OPEN: usize = 4;

/// Analysed recordings, the latest last.
#[derive(Default)]
pub struct AnalysedRuns {
    open: VecDeque<Open>,
}

/// An analysed run.
struct Open {
    recording: PathBuf,
    /// The answer, with everything behind it.
    compared: Compared,
    /// In short.
    found: RunFound,
    stamps: Stamps,
}

impl AnalysedRuns {
    /// Answers a question; analyses first where a recording, its state or a model changed since.
    pub fn answer(&mut self, question: &Question) -> Result<Reply, NoAnswer> {
        let open = self.current(question)?;
        let open = match &question.asks {
            Asks::Add(step) => {
                open.trusted()?.add(step)?;
                self.analyse(question)?
            }
            Asks::Remove(step) => {
                open.trusted()?.remove(step)?;
                self.analyse(question)?
            }
            _ => open,
        };
        Ok(Reply { text: open.text(&question.asks)?, found: open.found.clone() })
    }

    fn current(&mut self, question: &Question) -> Result<&Open, NoAnswer> {
        let known = self
            .open
            .iter()
            .position(|open| open.recording == question.recording && open.stamps == stamps(question));
        match known {
            Some(at) => Ok(&self.open[at]),
            None => self.analyse(question),
        }
    }

    fn analyse(&mut self, question: &Question) -> Result<&Open, NoAnswer> {
        let recording = &question.recording;
        // Room before the next one is in memory.
        self.open.retain(|open| open.recording != *recording);
        self.open.drain(..self.open.len().saturating_sub(MOST_OPEN - 1));
        let (stamps, model_path) = (stamps(question), own_model(recording));
        let state = run_record::read(recording).unwrap_or_default();
        let experiment = trunnion::open_runs(&[run_record::files(recording, &state)])?;
        let model = match &question.model {
            _ if model_path.exists() => Model::load(&model_path)?,
            Some(path) => Model::load(path)?,
            None => experiment.base_model(),
        };
        let compared = experiment.fit(&model)?.compare().with_losses(&state.losses);
        let found = found(&compared);
        self.open.push_back(Open { recording: recording.clone(), compared, found, stamps });
        Ok(&self.open[self.open.len() - 1])
    }
}

fn stamps(question: &Question) -> Stamps {
    Stamps::of(files_of(&question.recording, question.model.clone()))
}

/// It saves fits, no more.
fn say_not_kept(keeper: &Keeper<'_>) {
    if let Some(failure) = keeper.not_kept() {
        tracing::warn!("what was worked out for the history is not kept: {}", chain(failure));
    }
}

impl Open {
    /// A run that a person may act on.
    fn trusted(&self) -> Result<&Self, NoAnswer> {
        let doubts = self.compared.diagnosed().fit().experiment().plausibility();
        match doubts.is_empty() {
            true => Ok(self),
            false => Err(NoAnswer::NotTrusted(sentences::not_plausible(&doubts))),
        }
    }

    fn add(&self, Step { effect, by, date }: &Step) -> Result<(), NoAnswer> {
        let step = self.compared.diagnosed().add(effect)?.dated(date)?.by(by)?;
        self.save(step.model())?;
        tracing::info!(run = %self.recording.display(), effect, by, "added from the page");
        Ok(())
    }

    fn remove(&self, Step { effect, by, date }: &Step) -> Result<(), NoAnswer> {
        let smaller = self.compared.diagnosed().fit().remove(effect, date, Some(by))?;
        self.save(smaller.model())?;
        tracing::info!(run = %self.recording.display(), effect, by, "removed from the page");
        Ok(())
    }

    fn save(&self, model: &Model) -> Result<(), NoAnswer> {
        Ok(model.save(own_model(&self.recording))?)
    }

    fn text(&self, asks: &Asks) -> Result<String, NoAnswer> {
        let compared = &self.compared;
        let (diagnosed, fit) = (compared.diagnosed(), compared.diagnosed().fit());
        let text = match asks {
            Asks::Story | Asks::Add(_) | Asks::Remove(_) => to_json_line(&compared.story()),
            Asks::Identification => to_json_line(&fit.identified()),
            Asks::Diagnosis => to_json_line(&diagnosed.results()),
            Asks::Comparison => to_json_line(&compared.results()),
            Asks::Ladder => to_json_line(&compared.results().ladder),
            Asks::Linear => to_json_line(&diagnosed.linear()?),
            Asks::Change { earlier } => {
                let files = [earlier, &self.recording].map(|path| run_record::files_of(path));
                let mut keeper = Keeper::default();
                let change = changed(files, fit.model(), &mut keeper)?;
                say_not_kept(&keeper);
                to_json_line(&change)
            }
            Asks::NextDay { recordings } => {
                let runs: Vec<_> = recordings.iter().map(|path| run_record::files_of(path)).collect();
                let mut keeper = Keeper::default();
                let forecast = next_day(&runs, Some(fit.model()), &mut keeper);
                say_not_kept(&keeper);
                to_json_line(&forecast)
            }
            Asks::Methods => to_json_line(&fit.experiment().methods()),
            Asks::Report => Ok(compared.page()),
            Asks::Filed { by, language, date } => {
                let filing = Filing { operator: by.clone(), written: date.clone(), ..Filing::default() };
                let filed = fit.compare().with_losses(&compared.results().losses).with_best();
                let report = filed.report(&run_record::files_of(&self.recording), &filing)?;
                let known = Language::NAMES.into_iter().find(|(code, _)| code == language);
                Ok(report_html(&report, known.map_or(Language::English, |(_, language)| language)))
            }
            Asks::Trial { effect } => Ok(fit.try_effect(effect, &FormulaText::default())?.page()),
            Asks::Method { name } => {
                let found = fit.experiment().clone().by_method(name, &MethodOptions::default())?;
                Ok(findings_html(&found, &label()))
            }
            Asks::Formula(typed) => to_json_line(&fit.experiment().check_formula(&as_text(typed))),
            Asks::LinearWith(typed) => to_json_line(&diagnosed.linear_with(&as_text(typed))?),
        };
        text.map_err(|failure| NoAnswer::Failed(format!("an answer cannot be written: {failure}")))
    }
}

fn as_text(Typed { site, component, expression }: &Typed) -> FormulaText {
    let [site, component, expression] = [site, component, expression].map(|text| Some(text.clone()));
    FormulaText { site, component, expression, grid: Vec::new() }
}

/// The work of the process: a question a line, a head and a text for each, until the questions end.
///
/// # Errors
/// When an answer cannot be written.
pub fn answer_questions(mut answers: impl Write) -> std::io::Result<()> {
    let (asked, questions) = mpsc::channel();
    // Read next to the work: who asks may be gone while a question is worked on.
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if asked.send(line).is_err() {
                break;
            }
        }
        std::process::exit(0);
    });
    let mut runs = AnalysedRuns::default();
    for line in questions {
        let answer = match serde_json::from_str::<Question>(&line) {
            Ok(question) => runs.answer(&question),
            Err(failure) => Err(NoAnswer::Failed(format!("a question cannot be read: {failure}"))),
        };
        let (head, text) = match answer {
            Ok(Reply { text, found }) => (Head::Reply { bytes: text.len(), found }, text),
            Err(no_answer) => (Head::NoAnswer(no_answer), String::new()),
        };
        let head = serde_json::to_string(&head).map_err(std::io::Error::other)?;
        writeln!(answers, "{head}")?;
        answers.write_all(text.as_bytes())?;
        answers.flush()?;
    }
    Ok(())
}
