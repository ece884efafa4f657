//! The story of an analysis, `NAME.story.jsonl` next to its report: what it is of, and the story.
//!
//! The page shows it at once, instead of analysing a second time, as long as recordings, model and program are what they were.

use crate::error::ServiceError;
use crate::found::found;
use crate::run_record;
use crate::stamp::{Stamp, stamp};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use tracing::warn;
use trunnion::Compared;
use trunnion::page::label;
use trunnion::results::{RunFound, to_json_line};
use trunnion_core::chain;

const ENDING: &str = "story.jsonl";

/// The first line: what the story is of, and the analysis in short.
#[derive(Serialize, Deserialize)]
struct Head {
    of: Of,
    /// SHA-256 of every file of the run, which a copy keeps and its time of writing does not; `None` for a file that was gone. Stories of
    /// earlier versions have none: of theirs the lengths alone are known to stay.
    #[serde(default)]
    contents: Vec<Option<String>>,
    found: RunFound,
}

/// What a story is of.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Of {
    /// The program that analysed.
    program: String,
    /// Of every file of the run.
    files: Vec<Stamp>,
    /// Text of the model that judged.
    model: String,
}

impl Of {
    fn now(files: &[PathBuf], model: &str) -> Self {
        Self { program: label(), files: files.iter().map(|file| stamp(file)).collect(), model: model.into() }
    }
}

fn contents(files: &[PathBuf]) -> Vec<Option<String>> {
    files.iter().map(|file| trunnion::sha256(file).ok()).collect()
}

/// The story of an analysis of these files, and the analysis in short, as text.
///
/// # Errors
/// When it is no JSON.
pub fn of(files: &[PathBuf], compared: &Compared) -> Result<String, ServiceError> {
    let of = Of::now(files, compared.diagnosed().fit().model().text());
    let head = Head { of, contents: contents(files), found: found(compared) };
    Ok(format!("{}{}", to_json_line(&head)?, to_json_line(&compared.story())?))
}

/// Keeps such a text next to the recording.
///
/// # Errors
/// When the file cannot be written.
pub fn write(recording: &Path, text: &str) -> Result<(), ServiceError> {
    Ok(trunnion::files::write_whole(&path_of(recording), text)?)
}

/// The kept story of these files by this model, as it was written; `None` where there is none, or it is of others.
pub fn read(recording: &Path, files: &[PathBuf], model: &str) -> Option<String> {
    let path = path_of(recording);
    let mut text = std::fs::read_to_string(&path).ok()?;
    let (head, story) = text.split_once('\n')?;
    let head_now = head_of(&path, head)?;
    // A file that was cut does not end its line.
    let whole = head_now.of == Of::now(files, model) && story.ends_with('\n');
    let begins = head.len() + 1;
    whole.then(|| text.split_off(begins))
}

/// What is kept of the analysis of a recording in short.
#[derive(Debug, PartialEq)]
pub enum Kept {
    /// Nothing.
    Nothing,
    /// An analysis of other contents: the recording was replaced since.
    OfOthers,
    /// An analysis of this recording, or of one that was removed since.
    Found(Box<RunFound>),
}

/// The analysis in short, by whatever model and program it was. Reads the recording where its time of writing is not that of the analysis.
pub fn found_in(recording: &Path) -> Kept {
    let Some(Head { of, contents: then, found }) = first_line(recording) else { return Kept::Nothing };
    let files = run_record::files_of(recording);
    let now: Vec<Stamp> = files.iter().map(|file| stamp(file)).collect();
    let has_contents =
        || if then.is_empty() { lengths(&of.files) == lengths(&now) } else { then == contents(&files) };
    let is_of_it = !recording.exists() || of.files == now || has_contents();
    if is_of_it { Kept::Found(found.into()) } else { Kept::OfOthers }
}

fn lengths(files: &[Stamp]) -> Vec<Option<u64>> {
    files.iter().map(|stamp| stamp.map(|(length, _)| length)).collect()
}

/// Where the story of a recording is kept.
pub fn path_of(recording: &Path) -> PathBuf {
    recording.with_extension(ENDING)
}

fn first_line(recording: &Path) -> Option<Head> {
    let path = path_of(recording);
    let mut head = String::new();
    BufReader::new(File::open(&path).ok()?).read_line(&mut head).ok()?;
    head_of(&path, &head)
}

fn head_of(path: &Path, line: &str) -> Option<Head> {
    serde_json::from_str(line)
        .inspect_err(|error| warn!(error = chain(error), file = %path.display(), "this story is not taken"))
        .ok()
}
