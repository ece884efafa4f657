//! The calls of a report to be filed (docs/use/page.md): written next to the recording, printed, and handed out.

use super::answer::{Refusal, json_of, pdf, report};
use super::context::{Answer, Page, person, wrong};
use super::question::Asks;
use crate::clock::day;
use crate::print::{self, PrintError};
use axum::body::HttpBody;
use axum::extract::{FromRequest, Path, Request, State};
use axum::routing::post;
use axum::{Json, Router};
use serde::Deserialize;
use std::io::ErrorKind;
use std::path::{Path as FilePath, PathBuf};
use std::sync::{Mutex, PoisonError};
use trunnion::files::write_whole;
use trunnion::report::Language;
use trunnion::results::Filed;
use trunnion_core::chain;
use trunnion_core::names::allowed;

/// Ending of the page next to its recording, as `trunnion report` calls it.
const PAGE: &str = "report.html";
const PDF: &str = "report.pdf";

/// Their routes.
pub(super) fn routes() -> Router<Page> {
    Router::new()
        .route("/api/runs/{name}/filed", post(file).get(filed))
        .route("/api/runs/{name}/filed/pdf", post(print_filed).get(printed))
}

/// What a person says of a report; nothing where the call has no body.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ToFile {
    #[serde(default)]
    by: String,
    #[serde(default)]
    language: String,
}

async fn file(State(page): State<Page>, Path(name): Path<String>, request: Request) -> Answer {
    let ToFile { by, language } = match request.body().is_end_stream() {
        true => ToFile::default(),
        false => Json::from_request(request, &()).await.map_err(wrong)?.0,
    };
    let by = if by.trim().is_empty() { None } else { Some(person(&by, "who measured?")?) };
    let language = if language.is_empty() { Language::English.code().into() } else { language };
    if !Language::NAMES.iter().any(|(code, _)| *code == language) {
        let known = allowed(&language, Language::NAMES.map(|(code, _)| code));
        return Err(Refusal::Wrong(format!("there is no language \"{language}\"; allowed: {known}")));
    }
    let date = day(page.shared.clock.wall_ns());
    let text = page.runs.ask(&name, Asks::Filed { by, language, date }).await?;
    let run = name.clone();
    let html = at_a_file("writing of a report", move || {
        let (html, old) = (page.place(&name, PAGE)?, page.place(&name, PDF)?);
        let _alone = page.filing.lock().unwrap_or_else(PoisonError::into_inner);
        // One of an earlier page is none of this.
        remove(&old).map_err(Refusal::NotWritten)?;
        write_whole(&html, &text).map_err(|failure| Refusal::NotWritten(chain(&failure)))?;
        Ok(html.display().to_string())
    })
    .await?;
    json_of(&Filed { run, html, ..Filed::default() })
}

async fn filed(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(report(page.file(name, PAGE).await?.into()))
}

async fn print_filed(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    // One browser at a time: the computer also measures.
    let turn = page.printer.clone().try_acquire_owned().map_err(|_| Refusal::Busy)?;
    let run = name.clone();
    let (html, pdf, pdf_lacks) = at_a_file("printing of a report", move || {
        let printed = page.print(&name);
        drop(turn);
        printed
    })
    .await?;
    let [html, pdf] = [html, pdf].map(|path| path.display().to_string());
    json_of(&Filed { run, html, pdf: Some(pdf), pdf_lacks, ..Filed::default() })
}

async fn printed(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(pdf(page.file(name, PDF).await?.into()))
}

/// Work that waits for a disk: calls of others are answered meanwhile.
async fn at_a_file<T: Send + 'static>(
    what: &'static str,
    work: impl FnOnce() -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    tokio::task::spawn_blocking(work).await.map_err(|_| Refusal::Broken(what))?
}

fn remove(file: &FilePath) -> Result<(), String> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(format!("cannot remove {}: {error}", file.display()))
        }
        _ => Ok(()),
    }
}

/// Prints a filed page, and keeps the PDF where it is of the page that is there then.
fn keep_pdf(
    html: &FilePath,
    pdf: &FilePath,
    filing: &Mutex<()>,
    print: impl FnOnce(&FilePath) -> Result<Vec<u8>, PrintError>,
) -> Result<(), Refusal> {
    let first = |_| Refusal::NotNow("file the report first: the PDF is printed from its page");
    let text = std::fs::read(html).map_err(first)?;
    let printed = print(html).map_err(|failure| Refusal::NotWritten(chain(&failure)))?;
    let _alone = filing.lock().unwrap_or_else(PoisonError::into_inner);
    // Somebody else may have filed another language or name while the browser worked.
    if std::fs::read(html).ok() != Some(text) {
        return Err(Refusal::NotNow("the report was filed again while it was printed: print it again"));
    }
    write_whole(pdf, &printed).map_err(|failure| Refusal::NotWritten(chain(&failure)))
}

impl Page {
    /// Where a file of a run is that is called as its recording, also of a run whose samples were removed.
    fn place(&self, name: &str, ending: &str) -> Result<PathBuf, Refusal> {
        let unknown = || Refusal::Unknown { what: "run", name: name.into() };
        Ok(self.runs.place_of(name).ok_or_else(unknown)?.with_extension(ending))
    }

    /// Prints the filed page of a run: page, PDF, and what the PDF lacks.
    fn print(&self, name: &str) -> Result<(PathBuf, PathBuf, Option<String>), Refusal> {
        let (html, pdf) = (self.place(name, PAGE)?, self.place(name, PDF)?);
        let print = |html: &FilePath| print::pdf(html, &|| self.cancel.is_cancelled());
        keep_pdf(&html, &pdf, &self.filing, print)?;
        let lacks = print::lacks(&html, &|| self.cancel.is_cancelled());
        let lacks = lacks.map_err(|failure| Refusal::NotWritten(chain(&failure)))?;
        Ok((html, pdf, lacks))
    }

    async fn file(&self, name: String, ending: &'static str) -> Result<Vec<u8>, Refusal> {
        let page = self.clone();
        let read = move || {
            let missing = |_| Refusal::Unknown { what: "filed report of the run", name: name.clone() };
            std::fs::read(page.place(&name, ending)?).map_err(missing)
        };
        at_a_file("reading of a report", read).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pdf_of_a_page_that_was_filed_again_meanwhile_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let [html, pdf] = [PAGE, PDF].map(|ending| folder.path().join(format!("run.{ending}")));
        let filing = Mutex::default();
        let names = || std::fs::read_dir(folder.path()).unwrap().count();
        let print = |_: &FilePath| Ok(b"printed".to_vec());
        assert!(matches!(keep_pdf(&html, &pdf, &filing, print), Err(Refusal::NotNow(_))), "nothing is filed");
        std::fs::write(&html, "of Ada").unwrap();
        keep_pdf(&html, &pdf, &filing, print).unwrap();
        assert_eq!((std::fs::read_to_string(&pdf).unwrap().as_str(), names()), ("printed", 2));
        std::fs::remove_file(&pdf).unwrap();
        let filed_again = |from: &FilePath| {
            std::fs::write(from, "of Bea").unwrap();
            print(from)
        };
        let refused = keep_pdf(&html, &pdf, &filing, filed_again).unwrap_err();
        assert!(refused.to_string().contains("filed again"), "{refused}");
        assert!(keep_pdf(&html, &pdf, &filing, |_| Err(PrintError::Stopped)).is_err());
        assert_eq!(names(), 1, "the page alone");
    }
}
