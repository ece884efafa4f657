//! Corrections that were entered into the control: kept next to the recordings, one a line, and what the runs around each show.

use super::change::{between, none_in_common};
use crate::{Error, moment};
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use trunnion_results::number::{justified, um, unit_on_screen};
use trunnion_results::sentences::{effect_name, error_in_words};
use trunnion_results::{AroundCorrection, ChangedParameter, CorrectionEntered, HistoryRun, to_json_line};

/// Name of the file in a folder of recordings.
const FILE: &str = "corrections.jsonl";
/// Characters of a name and of what was entered.
const LONGEST: usize = 60;
/// Parameters that a sentence names.
const MOST_NAMED: usize = 4;

/// The corrections of a folder, oldest first; none where nobody entered any.
///
/// # Errors
/// A file that cannot be read, or a line that is no correction.
pub fn corrections(folder: &Path) -> Result<Vec<CorrectionEntered>, Error> {
    let path = folder.join(FILE);
    let text = match std::fs::read_to_string(&path) {
        Err(missing) if missing.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        read => read.map_err(|source| Error::Read { path: path.clone(), source })?,
    };
    let mut found = CorrectionEntered::of_lines(&text).map_err(|(line, why)| Error::NoCorrectionLine {
        path,
        line,
        why: why.to_string(),
    })?;
    found.sort_by_key(|correction| correction.at_s);
    Ok(found)
}

/// A correction that a person entered at this moment of the wall clock.
///
/// # Errors
/// A name or a text that is empty or too long.
pub fn entered(machine: String, wall_ns: i64, by: &str, what: &str) -> Result<CorrectionEntered, Error> {
    let plain = |text: &str| -> Option<String> {
        let text = text.trim();
        let fits = !text.is_empty() && text.chars().count() <= LONGEST && !text.chars().any(char::is_control);
        fits.then(|| text.to_owned())
    };
    let (by, what) = plain(by).zip(plain(what)).ok_or(Error::NotSaid { longest: LONGEST })?;
    let at = moment::minute(wall_ns).unwrap_or_default();
    Ok(CorrectionEntered { machine, at_s: wall_ns.div_euclid(1_000_000_000), at, by, what })
}

/// Keeps that a correction was entered; the file.
///
/// # Errors
/// A folder that cannot be written to.
pub fn enter_correction(folder: &Path, correction: &CorrectionEntered) -> Result<PathBuf, Error> {
    let path = folder.join(FILE);
    let failed = |source| Error::Write { path: path.clone(), source };
    let line = to_json_line(correction).map_err(|why| failed(why.into()))?;
    let mut file = OpenOptions::new().append(true).create(true).open(&path).map_err(failed)?;
    // One call, so that two who write at once mix no lines.
    file.write_all(line.as_bytes()).and_then(|()| file.sync_all()).map_err(failed)?;
    Ok(path)
}

/// Index of the first run after each correction, for those that have one.
pub(super) fn begins(runs: &[HistoryRun], corrections: &[CorrectionEntered]) -> Vec<usize> {
    corrections.iter().filter_map(|correction| first_after(runs, correction)).collect()
}

/// What the runs around each correction show, the latest first.
pub(super) fn around(runs: &[HistoryRun], corrections: &[CorrectionEntered]) -> Vec<AroundCorrection> {
    corrections.iter().rev().map(|correction| of_one(runs, correction)).collect()
}

fn first_after(runs: &[HistoryRun], correction: &CorrectionEntered) -> Option<usize> {
    runs.iter()
        .position(|run| run.rms_um.is_some() && run.began_s.is_some_and(|at_s| at_s >= correction.at_s))
}

fn of_one(runs: &[HistoryRun], correction: &CorrectionEntered) -> AroundCorrection {
    let is_before =
        |run: &&HistoryRun| run.rms_um.is_some() && run.began_s.is_some_and(|at_s| at_s < correction.at_s);
    let before = runs.iter().rev().find(is_before);
    let after = first_after(runs, correction).map(|index| &runs[index]);
    let parameters = before.zip(after).map_or_else(Vec::new, |(before, after)| between(before, after));
    AroundCorrection {
        correction: correction.clone(),
        before: before.map(|run| run.run.clone()),
        after: after.map(|run| run.run.clone()),
        words: words(correction, before, after, &parameters, undated(runs)),
        parameters,
    }
}

/// Analysed runs of which nobody knows when they were measured.
fn undated(runs: &[HistoryRun]) -> usize {
    runs.iter().filter(|run| run.rms_um.is_some() && run.began_s.is_none()).count()
}

fn words(
    correction: &CorrectionEntered,
    before: Option<&HistoryRun>,
    after: Option<&HistoryRun>,
    parameters: &[ChangedParameter],
    undated: usize,
) -> Vec<String> {
    let CorrectionEntered { at, by, what, .. } = correction;
    let mut words = vec![format!("{by} entered a correction on {at}: {what}.")];
    let (Some(before), Some(after)) = (before, after) else {
        words.push(match after {
            None => "No run was analysed after it: measure the same cycle again.".into(),
            Some(_) => "No run was analysed before it, so nothing shows what it did.".to_string(),
        });
        if undated > 0 {
            words.push(format!(
                "{undated} analysed {} no date, as imported tables have none, and may be of before or after: compare them by hand.",
                if undated == 1 { "run has" } else { "runs have" }
            ));
        }
        return words;
    };
    let changed: Vec<String> =
        parameters.iter().filter(|one| one.changed).take(MOST_NAMED).map(from_to).collect();
    words.push(match changed.is_empty() {
        _ if parameters.is_empty() => none_in_common(&before.run, &after.run),
        true => format!(
            "From {} to {} no value changed significantly: the correction does not show.",
            before.run, after.run
        ),
        false => format!("From {} to {}: {}.", before.run, after.run, changed.join("; ")),
    });
    if let Some((was, is)) = before.rms_um.zip(after.rms_um) {
        words.push(format!("The model left {} rms before and leaves {} after.", um(was), um(is)));
    }
    words
}

/// `place of axis C along X from −12.3 to 0.40 µm (EX0C)`.
fn from_to(one: &ChangedParameter) -> String {
    // u of the difference: no less than that of either value.
    let [was, is] = [one.before, one.after].map(|value| justified(value, one.u));
    let unit = unit_on_screen(&one.unit);
    match error_in_words(&one.name) {
        Some(name) => format!("{name} from {was} to {is} {unit} ({})", one.name),
        None => format!("{} of {} from {was} to {is} {unit}", one.name, effect_name(&one.effect)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_results::Parameter;

    const DAY_S: i64 = 86_400;

    fn run(name: &str, day: i64, ex0c_um: f64) -> HistoryRun {
        let value = Parameter {
            name: "EX0C".into(),
            effect: "location-errors".into(),
            unit: "um".into(),
            value: Some(ex0c_um),
            u: Some(0.1),
            observable: true,
            ..Parameter::default()
        };
        let began_s = Some(day * DAY_S);
        HistoryRun {
            run: name.into(),
            began_s,
            rms_um: Some(0.4),
            values: vec![value],
            ..HistoryRun::default()
        }
    }

    fn correction(day: i64) -> CorrectionEntered {
        let wall_ns = (day * DAY_S + DAY_S / 2) * 1_000_000_000;
        entered("mill".into(), wall_ns, " Ada ", "lines of B and C").unwrap()
    }

    #[test]
    fn the_runs_before_and_after_a_correction_are_compared_and_limits_begin_again() {
        let runs = [run("mon", 1, 12.0), run("tue", 2, 12.1), run("wed", 3, 0.2), run("thu", 4, 0.1)];
        let found = around(&runs, &[correction(2)]);
        assert_eq!((found[0].before.as_deref(), found[0].after.as_deref()), (Some("tue"), Some("wed")));
        let words = found[0].words.join(" ");
        assert!(
            words.contains("From tue to wed: place of axis C along X from 12.1 to 0.20 µm (EX0C)"),
            "{words}"
        );
        assert!(
            words.starts_with("Ada entered a correction on 1970-01-03 12:00 UTC: lines of B and C."),
            "{words}"
        );
        assert_eq!(begins(&runs, &[correction(2), correction(9)]), [2]);
    }

    #[test]
    fn a_correction_that_nothing_shows_is_not_praised() {
        let runs = [run("mon", 1, 12.0), run("wed", 3, 12.1)];
        let said = |day| around(&runs, &[correction(day)])[0].words.join(" ");
        assert!(said(2).contains("the correction does not show"), "{}", said(2));
        assert!(said(5).contains("measure the same cycle again"), "{}", said(5));
        assert!(said(0).contains("No run was analysed before it"), "{}", said(0));
    }

    #[test]
    fn runs_that_share_no_value_are_not_said_to_have_kept_theirs() {
        let mut other = run("wed", 3, 12.0);
        other.values[0].name = "EX0B".into();
        let said = around(&[run("mon", 1, 12.0), other], &[correction(2)])[0].words.join(" ");
        assert!(said.contains("No value can be compared: mon and wed determine none in common"), "{said}");
        assert!(!said.contains("changed significantly"), "{said}");
    }

    #[test]
    fn what_was_entered_is_read_back_and_a_torn_line_is_named() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(corrections(folder.path()).unwrap(), []);
        enter_correction(folder.path(), &correction(5)).unwrap();
        let path = enter_correction(folder.path(), &correction(2)).unwrap();
        assert_eq!(corrections(folder.path()).unwrap(), [correction(2), correction(5)], "in order of time");
        std::fs::write(&path, "{\"machine\":\"mill\"\n").unwrap();
        let error = corrections(folder.path()).unwrap_err().to_string();
        assert!(error.contains("corrections.jsonl:1 is no correction"), "{error}");
        assert!(entered("mill".into(), 0, " ", "all").is_err());
    }
}
