//! The calls of a report to be filed (docs/use/page.md): written next to the recording, printed, and handed out.

use super::answer::{Refusal, json_of, pdf, report};
use super::context::{Answer, Page, person, wrong};
use super::question::Asks;
use crate::clock::day;
use crate::print;
use axum::extract::rejection::JsonRejection;
use axum::extract::{Path, State};
use axum::routing::post;
use axum::{Json, Router};
use serde::Deserialize;
use std::path::PathBuf;
use trunnion::files::write_whole;
use trunnion::report::Language;
use trunnion::results::Filed;
use trunnion_core::chain;

/// Ending of the page next to its recording, as `trunnion report` calls it.
const PAGE: &str = "report.html";
const PDF: &str = "report.pdf";

/// Their routes.
pub(super) fn routes() -> Router<Page> {
    Router::new()
        .route("/api/runs/{name}/filed", post(file).get(filed))
        .route("/api/runs/{name}/filed/pdf", post(print_filed).get(printed))
}

/// What a person says of a report.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ToFile {
    #[serde(default)]
    by: String,
    #[serde(default)]
    language: String,
}

async fn file(
    State(page): State<Page>,
    Path(name): Path<String>,
    body: Result<Json<ToFile>, JsonRejection>,
) -> Answer {
    let ToFile { by, language } = body.map_err(wrong)?.0;
    let by = if by.trim().is_empty() { None } else { Some(person(&by, "who measured?")?) };
    let language = if language.is_empty() { Language::English.code().into() } else { language };
    if !Language::NAMES.iter().any(|(code, _)| *code == language) {
        let known = Language::NAMES.map(|(code, _)| code).join(", ");
        return Err(Refusal::Wrong(format!("there is no language \"{language}\"; allowed: {known}")));
    }
    let date = day(page.shared.clock.wall_ns());
    let text = page.runs.ask(&name, Asks::Filed { by, language, date }).await?;
    let (html, old) = (page.place(&name, PAGE)?, page.place(&name, PDF)?);
    let path = html.clone();
    let written = tokio::task::spawn_blocking(move || {
        // One of an earlier page is none of this.
        match std::fs::remove_file(&old) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(format!("cannot remove {}: {error}", old.display()));
            }
            _ => {}
        }
        write_whole(&path, &String::from_utf8_lossy(&text)).map_err(|failure| chain(&failure))
    });
    written.await.map_err(|_| Refusal::Broken("writing of a report"))?.map_err(Refusal::NotWritten)?;
    json_of(&Filed { run: name, html: html.display().to_string(), ..Filed::default() })
}

async fn filed(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(report(page.file(&name, PAGE).await?.into()))
}

async fn print_filed(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    let (html, pdf) = (page.place(&name, PAGE)?, page.place(&name, PDF)?);
    if !html.is_file() {
        return Err(Refusal::NotNow("file the report first: the PDF is printed from its page"));
    }
    // One browser at a time: the computer also measures.
    let turn = page.printer.clone().try_acquire_owned().map_err(|_| Refusal::Busy)?;
    let (of, to, cancel) = (html.clone(), pdf.clone(), page.cancel.clone());
    let printing = tokio::task::spawn_blocking(move || {
        let printed = print::pdf(&of, &to, &|| cancel.is_cancelled());
        drop(turn);
        printed.map_err(|failure| Refusal::NotWritten(chain(&failure)))
    });
    printing.await.map_err(|_| Refusal::Broken("printing of a report"))??;
    let [html, pdf] = [html, pdf].map(|path| path.display().to_string());
    json_of(&Filed { run: name, html, pdf: Some(pdf), ..Filed::default() })
}

async fn printed(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(pdf(page.file(&name, PDF).await?.into()))
}

impl Page {
    /// Where a file of a run is that is called as its recording, also of a run whose samples were removed.
    fn place(&self, name: &str, ending: &str) -> Result<PathBuf, Refusal> {
        let unknown = || Refusal::Unknown { what: "run", name: name.into() };
        Ok(self.runs.place_of(name).ok_or_else(unknown)?.with_extension(ending))
    }

    async fn file(&self, name: &str, ending: &str) -> Result<Vec<u8>, Refusal> {
        let path = self.place(name, ending)?;
        let read = tokio::task::spawn_blocking(move || std::fs::read(path)).await;
        let missing = |_| Refusal::Unknown { what: "filed report of the run", name: name.into() };
        read.map_err(|_| Refusal::Broken("reading of a report"))?.map_err(missing)
    }
}
