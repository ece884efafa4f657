//! From a recording to its report.

use crate::error::ServiceError;
use crate::mqtt::Board;
use crate::recording::Recorded;
use serde_json::json;
use std::path::Path;
use tracing::info;
use trunnion::results::to_json;
use trunnion::{Analysed, Compared, Model};

/// Analyses a recording as `replay` would: from the file alone.
///
/// # Errors
/// When the file cannot be read or its points cannot be analysed.
pub fn analyse_recording(path: &Path, model: &Model, date: &str) -> Result<Analysed, ServiceError> {
    let failed = |source| ServiceError::Analysis { path: path.into(), source: Box::new(source) };
    let experiment = trunnion::open(path).map_err(failed)?;
    for reduction in experiment.reductions() {
        info!("{reduction}");
    }
    experiment.analyse(model, date).map_err(failed)
}

/// Analyses what was recorded and writes page and JSON next to it.
///
/// # Errors
/// When the recording cannot be analysed or a file cannot be written.
pub fn write_report(
    recorded: &Recorded,
    model: &Model,
    date: &str,
) -> Result<(Analysed, Compared), ServiceError> {
    let path = &recorded.path;
    let analysed = analyse_recording(path, model, date)?;
    let failed = |source| ServiceError::Analysis { path: path.clone(), source: Box::new(source) };
    let losses = trunnion::page::losses(&recorded.gaps, recorded.lost_samples);
    let compared = analysed.compare().map_err(failed)?.with_losses(&losses);
    write(&path.with_extension("html"), &compared.page())?;
    write(&path.with_extension("identification.json"), &to_json(&analysed.fit().results())?)?;
    write(&path.with_extension("diagnosis.json"), &to_json(&analysed.first().results())?)?;
    Ok((analysed, compared))
}

/// Analyses what was recorded, writes page and JSON next to it, and reports on the board.
pub(super) async fn report_cycle(
    recorded: Recorded,
    model: Model,
    date: String,
    board: &Board,
) -> Result<(), ServiceError> {
    let path = recorded.path.clone();
    let (analysed, compared) = tokio::task::spawn_blocking(move || write_report(&recorded, &model, &date))
        .await
        .map_err(|_| ServiceError::Broken("analysis"))??;
    if let Some(timing) = compared.results().time_quality.last() {
        board.set("quality", &serde_json::to_value(timing)?);
    }
    let (first, added) = (analysed.first().results(), analysed.added());
    let verdict = first.verdict.as_str();
    info!(run = %path.display(), verdict, ?added, "analysed");
    board.set(
        "result",
        &json!({
            "run": path.file_name().map(|name| name.to_string_lossy()),
            "verdict": verdict,
            "why": first.why,
            "complete": first.complete,
            "missing_effects": added,
            "rms_um_before": analysed.before().results().rms_um,
            "rms_um_after": analysed.fit().results().rms_um,
            "report": path.with_extension("html").display().to_string(),
        }),
    );
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), ServiceError> {
    std::fs::write(path, text).map_err(|source| ServiceError::Write { path: path.into(), source })
}
