//! What the page asks of a recording, and what it gets: one line of JSON to the process that analyses, a head and a text back.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use trunnion::results::RunFound;
use trunnion_core::chain;

/// A question about one recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Question {
    /// The recording.
    pub recording: PathBuf,
    /// The model of a recording without one of its own; the base model without it.
    pub model: Option<PathBuf>,
    /// What is asked.
    pub asks: Asks,
}

/// What is asked of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Asks {
    /// What the page shows.
    Story,
    /// `trunnion identify`.
    Identification,
    /// `trunnion diagnose`.
    Diagnosis,
    /// `trunnion compare`.
    Comparison,
    /// `trunnion ladder`.
    Ladder,
    /// The report, a page of its own.
    Report,
    /// The report to be filed, a page of its own.
    Filed {
        /// Who measured.
        by: Option<String>,
        /// Code of its language.
        language: String,
        /// Today.
        date: String,
    },
    /// Columns for what-if.
    Linear,
    /// What the day after these runs is expected to show; the recording of the question is of the last of them.
    NextDay {
        /// A recording of each run, oldest first.
        recordings: Vec<PathBuf>,
    },
    /// What changed from another recording to that of the question, and which effect.
    Change {
        /// The earlier one.
        earlier: PathBuf,
    },
    /// What each named method lacks.
    Methods,
    /// An effect on trial, a page of its own.
    Trial {
        /// Its id.
        effect: String,
    },
    /// A named method, a page of its own.
    Method {
        /// Its name.
        name: String,
    },
    /// An expression as far as it is typed.
    Formula(Typed),
    /// Columns for what-if of an expression as it is typed.
    LinearWith(Typed),
    /// Puts an effect into the model.
    Add(Step),
    /// Takes an effect out of the model.
    Remove(Step),
}

/// An expression that was typed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Typed {
    /// Where it acts.
    pub site: String,
    /// What of it.
    pub component: String,
    /// The expression.
    pub expression: String,
}

/// A change of the model of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Id of the effect.
    pub effect: String,
    /// Who does it.
    pub by: String,
    /// When.
    pub date: String,
}

impl Asks {
    /// Whether the answer stays the same as long as recordings and models do, and is worth keeping.
    pub fn is_kept(&self) -> bool {
        let changes = matches!(self, Self::Add(_) | Self::Remove(_));
        !changes && !matches!(self, Self::Formula(_) | Self::LinearWith(_) | Self::Filed { .. })
    }

    /// Recordings that the answer comes from, next to that of the question.
    pub fn others(&self) -> &[PathBuf] {
        match self {
            Self::NextDay { recordings } => recordings,
            Self::Change { earlier } => std::slice::from_ref(earlier),
            _ => &[],
        }
    }
}

/// JSON or a page.
#[derive(Clone, Debug, PartialEq)]
pub struct Reply {
    /// The text.
    pub text: String,
    /// The analysis in short, for the list.
    pub found: RunFound,
}

/// Why a question got no answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoAnswer {
    /// The analysis failed.
    Failed(String),
    /// Nothing is done with runs that cannot be judged.
    NotTrusted(String),
}

impl From<trunnion::Error> for NoAnswer {
    fn from(failure: trunnion::Error) -> Self {
        Self::Failed(chain(&failure))
    }
}

/// What comes before the text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Head {
    /// Length of the text that follows.
    Reply {
        /// Bytes.
        bytes: usize,
        /// The analysis in short.
        found: RunFound,
    },
    /// No text follows.
    NoAnswer(NoAnswer),
}
