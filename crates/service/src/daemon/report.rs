//! From a recording to its report.

use crate::error::ServiceError;
use crate::mqtt::Board;
use crate::recording::Recorded;
use serde_json::json;
use std::path::Path;
use tracing::info;
use trunnion::analysis;
use trunnion::analysis::Analysis;
use trunnion::results::{Diagnosis, Identification, TimeQuality, Verdict, to_json};
use trunnion_effects::Model;
use trunnion_engine::Experiment;
use trunnion_machine::Machine;

/// Analyses a recording as `replay` would: from the file alone.
///
/// # Errors
/// When the file cannot be read or its points cannot be analysed.
pub fn analyse_recording(
    path: &Path,
    machine: &Machine,
    model: &Model,
    date: &str,
) -> Result<(Experiment, Analysis, Option<TimeQuality>), ServiceError> {
    let limits = Some(trunnion_sync::blocks::Limits::default());
    let recording = trunnion::recording::read(path, &|_| Some(machine.clone()), limits)?;
    if let Some(reduction) = &recording.reduction {
        info!(run = %path.display(), "{}", reduction.summary());
    }
    let experiment = Experiment::new(std::slice::from_ref(&recording.run))
        .map_err(|source| ServiceError::Experiment { path: path.into(), source })?;
    let analysis = analysis::climb(&experiment, model, date)
        .map_err(|source| ServiceError::Analysis { path: path.into(), source: Box::new(source) })?;
    let mut timing = recording.timing.as_ref().map(TimeQuality::from);
    if let Some(timing) = &mut timing {
        let told = trunnion::timing::delay_by_feeds(&experiment).map_err(|source| {
            ServiceError::Analysis { path: path.into(), source: Box::new(source.into()) }
        })?;
        timing.notes.extend(told);
    }
    Ok((experiment, analysis, timing))
}

/// Analyses what was recorded, writes page and JSON beside it, and tells the board.
pub(super) async fn report_cycle(
    recorded: Recorded,
    model: Model,
    machine: Machine,
    date: String,
    board: &Board,
) -> Result<(), ServiceError> {
    let path = recorded.path.clone();
    let losses = trunnion::page::losses(&recorded.gaps, recorded.lost_samples);
    let analysed = tokio::task::spawn_blocking(move || {
        let (experiment, analysis, timing) = analyse_recording(&path, &machine, &model, &date)?;
        let html = trunnion::page::compare_page(&experiment, &analysis, &losses, timing.as_slice());
        write(&path.with_extension("html"), &html)?;
        write(
            &path.with_extension("identification.json"),
            &to_json(&Identification::from(analysis.identification()))?,
        )?;
        write(&path.with_extension("diagnosis.json"), &to_json(&Diagnosis::from(&analysis.diagnoses[0]))?)?;
        Ok::<_, ServiceError>((path, analysis, timing))
    })
    .await
    .map_err(|_| ServiceError::Broken("analysis"))??;
    let (path, analysis, timing) = analysed;
    if let Some(timing) = timing {
        board.set("quality", &serde_json::to_value(&timing)?);
    }
    let added: Vec<&str> = analysis.steps.iter().map(|step| step.entry.id.as_str()).collect();
    info!(run = %path.display(), verdict = Verdict::from(analysis.diagnoses[0].verdict).as_str(), ?added, "analysed");
    board.set(
        "result",
        &json!({
            "run": path.file_name().map(|name| name.to_string_lossy()),
            "verdict": Verdict::from(analysis.diagnoses[0].verdict).as_str(),
            "missing_effects": added,
            "rms_um_before": trunnion_core::convert::um_from_mm(analysis.before.rms_mm),
            "rms_um_after": trunnion_core::convert::um_from_mm(analysis.identification().rms_mm),
            "report": path.with_extension("html").display().to_string(),
        }),
    );
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), ServiceError> {
    std::fs::write(path, text).map_err(|source| ServiceError::Write { path: path.into(), source })
}
