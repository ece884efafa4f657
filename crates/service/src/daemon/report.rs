//! From a recording to its report.

use crate::clock::{day, moment};
use crate::error::ServiceError;
use crate::recording::Recorded;
use crate::{kept_story, run_record};
use std::path::{Path, PathBuf};
use tracing::{info, warn};
use trunnion::results::{RunAnswer, RunRecord, RunResult, RunState, Verdict, to_json};
use trunnion::{Analysed, Compared, Experiment, Model, Notation, history};
use trunnion_core::chain;

/// Analyses a recording as `replay` would: from the file alone.
///
/// # Errors
/// When the file cannot be read or its points cannot be analysed.
pub fn analyse_recording(path: &Path, model: &Model, date: &str) -> Result<Analysed, ServiceError> {
    let failed = |source| ServiceError::Analysis { path: path.into(), source: Box::new(source) };
    opened(vec![path.into()]).map_err(failed)?.analyse(model, date).map_err(failed)
}

/// One run from its files.
fn opened(files: Vec<PathBuf>) -> Result<Experiment, trunnion::Error> {
    let experiment = trunnion::open_runs(&[files])?;
    for reduction in experiment.reductions() {
        info!("{reduction}");
    }
    Ok(experiment)
}

/// A report that is written.
pub struct Report {
    /// The analysis.
    pub analysed: Analysed,
    /// What its page shows.
    pub compared: Compared,
    /// Both in short.
    pub answer: RunAnswer,
}

/// Analyses what was just recorded in this process, and keeps its state.
///
/// # Errors
/// When the recording cannot be analysed or a file cannot be written.
pub fn report_at_once(
    recorded: &Recorded,
    cycle: &str,
    model: &Model,
    wall_ns: i64,
) -> Result<Report, ServiceError> {
    let record = run_record::of_recorded(recorded, cycle, moment(wall_ns));
    run_record::write(&recorded.path, &record)?;
    let record = RunRecord { tries: 1, ..record };
    let report = match write_report(&recorded.path, Some(model), &day(wall_ns)) {
        Ok(report) => report,
        Err(failure) => {
            let failed = RunRecord { state: RunState::Failed, why: chain(&failure), ..record };
            run_record::write(&recorded.path, &failed)?;
            return Err(failure);
        }
    };
    run_record::write(&recorded.path, &run_record::reported(record, report.answer.clone()))?;
    Ok(report)
}

/// Analyses a recording, with what its state says is missing, and writes page and JSON next to it; the base model where none is given.
/// Page and identification are those of this model, with the best candidate on trial: effects are proposed here, a person adds them.
///
/// # Errors
/// When the recording cannot be analysed or a file cannot be written.
pub fn write_report(recording: &Path, model: Option<&Model>, date: &str) -> Result<Report, ServiceError> {
    let failed = |source| ServiceError::Analysis { path: recording.into(), source: Box::new(source) };
    let state = run_record::read(recording).unwrap_or_default();
    let files = run_record::files(recording, &state);
    let filed = history::filed(&files, model);
    let experiment = opened(files.clone()).map_err(failed)?;
    let model = model.map_or_else(|| experiment.base_model(), Model::clone);
    let analysed = experiment.analyse(&model, date).map_err(failed)?;
    let compared = analysed.first().compare().with_losses(&state.losses).with_left_out(analysed.left_out());
    let story = kept_story::of(&files, &compared)?;
    let compared = compared.with_best();
    let answers = [
        ("html", compared.page()),
        ("identification.json", to_json(&analysed.before().identified())?),
        // Last: where it is, everything is.
        ("diagnosis.json", to_json(&analysed.first().results())?),
    ];
    for (ending, text) in answers {
        trunnion::files::write_whole(&recording.with_extension(ending), &text)?;
    }
    // It saves an analysis, no more.
    if let Err(failure) = kept_story::write(recording, &story) {
        warn!("the story is not kept: {}; the page analyses again", chain(&failure));
    }
    if let Err(failure) = filed.keep(analysed.first()) {
        warn!("the run is not kept for its history: {}; the history analyses again", chain(&failure));
    }
    let quality = compared.results().time_quality.last().cloned();
    let answer = RunAnswer { result: in_short(recording, &analysed), quality };
    info!(run = %recording.display(), verdict = answer.result.verdict.as_str(), missing = ?answer.result.missing_effects, "analysed");
    Ok(Report { analysed, compared, answer })
}

/// What an analysis found in this recording, for the topic `result`.
pub fn in_short(recording: &Path, analysed: &Analysed) -> RunResult {
    let first = analysed.first().results();
    let is_judged = first.verdict != Verdict::NotJudged;
    RunResult {
        run: recording.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        verdict: first.verdict,
        why: first.why,
        complete: first.complete,
        missing_effects: analysed.added().into_iter().map(String::from).collect(),
        location_errors: is_judged.then(|| analysed.before().location_errors(Notation::Absolute)),
        rms_um_before: analysed.before().results().rms_um,
        rms_um_after: analysed.fit().results().rms_um,
        report: recording.with_extension("html").display().to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_analysis_that_fails_leaves_its_reason_in_the_state_of_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        std::fs::write(&path, b"no recording").unwrap();
        let recorded =
            Recorded { path, parts: Vec::new(), ended: String::new(), gaps: Vec::new(), lost_samples: 0 };
        let failed = report_at_once(&recorded, "low", &Model::base("table-bc"), 0).err().unwrap();
        let state = run_record::read(&recorded.path).unwrap();
        assert_eq!((state.state, state.tries, state.cycle.as_str()), (RunState::Failed, 1, "low"));
        assert_eq!(state.why, chain(&failed));
    }
}
