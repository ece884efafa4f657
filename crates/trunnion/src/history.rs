//! The runs of one machine in order of time, each fitted with the same model.

mod change;
mod corrections;
mod forecast;
mod watch;

pub use corrections::{corrections, enter_correction, entered};
pub use forecast::{days, next_day, without};

use crate::{Diagnosed, Error, Model, moment};
use std::path::{Path, PathBuf};
use trunnion_core::chain;
use trunnion_results::sentences::{is_setting, not_plausible};
use trunnion_results::{
    Alarm, AlarmsNow, CorrectionEntered, Diagnosis, HistoryRun, MachineHistory, Parameter, RunChange,
    RunFound, RunLine, Verdict,
};

/// Which runs make a history.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Name of the machine; that of the newest run without it.
    pub machine: Option<String>,
    /// The model that every run is fitted with; the base model without it.
    pub model: Option<Model>,
    /// Name of the first run after a correction or repair: limits begin with it.
    pub since: Option<String>,
    /// Corrections that were entered, of any machine: limits begin again after each.
    pub corrections: Vec<CorrectionEntered>,
}

/// A run before it is read.
struct Header {
    /// Its recordings.
    files: Vec<PathBuf>,
    machine: String,
    run: HistoryRun,
}

/// The history of one machine from runs in any order, each with the recordings that hold it. A run that cannot be read or judged is
/// listed with the reason.
///
/// # Errors
/// No recording of the machine, or no run called `since`.
pub fn history(runs: &[Vec<PathBuf>], wanted: &Wanted) -> Result<MachineHistory, Error> {
    let mut headers: Vec<Header> = runs.iter().map(|files| header(files)).collect();
    headers.sort_by(|a, b| (a.run.began_s, &a.run.run).cmp(&(b.run.began_s, &b.run.run)));
    let newest = headers.iter().rev().map(|header| header.machine.clone()).find(|name| !name.is_empty());
    let machine = wanted.machine.clone().or(newest).unwrap_or_default();
    // What cannot be read has no machine; it is listed, lest it is missed.
    headers.retain(|header| header.machine == machine || header.machine.is_empty());
    if !headers.iter().any(|header| header.machine == machine) {
        return Err(Error::NoRuns { machine });
    }
    let mut history = MachineHistory { machine, ..MachineHistory::default() };
    let mut last_two: [Option<(String, Diagnosed)>; 2] = [None, None];
    let mut recordings = Vec::new();
    for Header { files, run, .. } in headers {
        let (run, diagnosed) = judged(&files, run, wanted.model.as_ref());
        if let Some(diagnosed) = diagnosed {
            last_two = [last_two[1].take(), Some((run.run.clone(), diagnosed))];
        }
        history.runs.push(run);
        recordings.push(files);
    }
    if let [earlier, Some(later)] = &last_two {
        history.effects = later.1.fit().model().effects().into_iter().map(str::to_owned).collect();
        match earlier.as_ref().map(|earlier| (&earlier.0, change::change(earlier, later))) {
            Some((_, Ok(change))) => history.change = Some(change),
            // The list and its limits hold without it.
            Some((from, Err(failure))) => {
                history.why_no_change =
                    format!("{from} and {} cannot be compared: {}.", later.0, chain(&failure));
            }
            None => {}
        }
    }
    let since = index_of(&history.runs, wanted.since.as_deref())?;
    watched(&mut history, since, &wanted.corrections);
    history.forecast = Some(match days(&history, since) {
        Ok(days) => {
            let of_days: Vec<Vec<PathBuf>> =
                days.into_iter().map(|index| recordings[index].clone()).collect();
            next_day(&of_days, wanted.model.as_ref())
        }
        Err(why_not) => without(why_not),
    });
    Ok(history)
}

/// The same from what analyses have found already, of the machine and the model of the newest: without the effect behind a change,
/// which takes fits.
pub fn of_found(lines: &[RunLine], corrections: &[CorrectionEntered]) -> MachineHistory {
    let analysed =
        |line: &RunLine| line.found.as_ref().is_some_and(|found| found.verdict != Verdict::NotJudged);
    let lines: Vec<&RunLine> = lines.iter().filter(|line| analysed(line)).collect();
    let newest = lines.last();
    let machine = newest.map_or_else(String::new, |line| line.machine.clone());
    let found = newest.and_then(|line| line.found.as_ref());
    let effects = found.map_or_else(Vec::new, |found| found.effects.clone());
    let mut history = MachineHistory { machine, effects, ..MachineHistory::default() };
    let mut others = 0;
    for line in lines.iter().filter(|line| line.machine == history.machine) {
        match &line.found {
            Some(found) if found.effects == history.effects => history.runs.push(of_line(line, found)),
            _ => others += 1,
        }
    }
    if others > 0 {
        history
            .notes
            .push(format!("{others} further runs were analysed with another model and are not compared."));
    }
    if let [.., earlier, later] = history.runs.as_slice() {
        history.change = Some(change::of_values(earlier, later));
    }
    watched(&mut history, 0, corrections);
    history
}

/// What of the newest run lies outside its limits.
pub fn alarms(history: &MachineHistory) -> AlarmsNow {
    let Some((last, run)) = history.runs.iter().enumerate().next_back() else { return AlarmsNow::default() };
    let points = history.watched.iter().filter_map(|watched| {
        let point = watched.points.last().filter(|point| point.run == last)?;
        Some((watched, point, point.limits?))
    });
    let mut now = AlarmsNow { run: Some(run.run.clone()), ..AlarmsNow::default() };
    for (watched, point, [mean, low, high]) in points {
        now.watched += 1;
        if !point.alarm {
            continue;
        }
        let since = watched.points.iter().rev().take_while(|point| point.alarm).last();
        now.alarms.push(Alarm {
            name: watched.name.clone(),
            effect: watched.effect.clone(),
            words: watched.words.clone(),
            unit: watched.unit.clone(),
            value: point.value,
            u: point.u,
            mean,
            low,
            high,
            since: since.map_or_else(String::new, |point| history.runs[point.run].run.clone()),
        });
    }
    now
}

fn of_line(line: &RunLine, found: &RunFound) -> HistoryRun {
    HistoryRun {
        run: line.name.clone(),
        began_s: line.began_s,
        began: line.began.clone(),
        verdict: found.verdict,
        // Answers of older versions know the first only.
        candidate: Diagnosis::named_in_short(&found.named).or_else(|| found.candidate.clone()),
        rms_um: Some(found.rms_um),
        temperature_degc: found.temperature_degc,
        values: found.location_errors.clone(),
        ..HistoryRun::default()
    }
}

/// Limits begin with the run `since`, and again after every correction of this machine.
fn watched(history: &mut MachineHistory, since: usize, corrections: &[CorrectionEntered]) {
    let of_machine = corrections.iter().filter(|correction| correction.machine == history.machine);
    history.corrections = of_machine.cloned().collect();
    let mut begins = corrections::begins(&history.runs, &history.corrections);
    begins.push(since);
    history.watched = watch::watch(&mut history.runs, &begins);
    history.around_corrections = corrections::around(&history.runs, &history.corrections);
    let dated = history.runs.iter().filter(|run| run.began_s.is_some()).count();
    match history.runs.len() - dated {
        0 => {}
        _ if dated == 0 => {
            history.notes.push("No run has a date: they stand in order of their names.".into())
        }
        _ => history.notes.push("Runs without a date come first, in order of their names.".into()),
    }
}

/// The machine of the newest recording.
pub fn newest_machine(runs: &[Vec<PathBuf>]) -> Option<String> {
    let headers = runs.iter().map(|files| header(files)).filter(|header| !header.machine.is_empty());
    headers
        .max_by(|a, b| (a.run.began_s, &a.run.run).cmp(&(b.run.began_s, &b.run.run)))
        .map(|header| header.machine)
}

/// Index of the run of this name; of the first without one.
fn index_of(runs: &[HistoryRun], name: Option<&str>) -> Result<usize, Error> {
    let Some(name) = name else { return Ok(0) };
    runs.iter().position(|run| run.run == name).ok_or_else(|| Error::NoSuchRun {
        name: name.into(),
        runs: runs.iter().map(|run| run.run.as_str()).collect::<Vec<_>>().join(", "),
    })
}

fn header(files: &[PathBuf]) -> Header {
    let path = files.first().map_or(Path::new(""), PathBuf::as_path);
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let run = HistoryRun { run: name, ..HistoryRun::default() };
    match trunnion_record::read_header(path) {
        Ok(header) => Header {
            files: files.into(),
            machine: header.machine_name,
            run: HistoryRun {
                began_s: Some(header.wall_start_ns).filter(|ns| *ns > 0).map(|ns| ns / 1_000_000_000),
                began: moment::minute(header.wall_start_ns).unwrap_or_default(),
                ..run
            },
        },
        Err(failure) => Header {
            files: files.into(),
            machine: String::new(),
            run: HistoryRun { trouble: failure.to_string(), ..run },
        },
    }
}

/// What changed from one run to another, both judged by this model: what [`history`] reports of the last two.
///
/// # Errors
/// A recording that cannot be read or fitted; a diagnosis that fails.
pub fn changed([earlier, later]: &[Vec<PathBuf>; 2], model: &Model) -> Result<RunChange, Error> {
    let of = |files: &Vec<PathBuf>| Ok::<_, Error>((header(files).run.run, diagnosed(files, Some(model))?));
    change::change(&of(earlier)?, &of(later)?)
}

/// A run with what was found in it, and the analysis where it can be compared with others.
fn judged(files: &[PathBuf], run: HistoryRun, model: Option<&Model>) -> (HistoryRun, Option<Diagnosed>) {
    if !run.trouble.is_empty() {
        return (run, None);
    }
    match diagnosed(files, model) {
        Ok(diagnosed) => {
            let (fit, diagnosis) = (diagnosed.fit().results(), diagnosed.results());
            let judged = diagnosis.verdict != Verdict::NotJudged;
            let of_machine =
                |p: &&Parameter| judged && p.value.is_some() && p.u.is_some() && !is_setting(&p.effect);
            let run = HistoryRun {
                verdict: diagnosis.verdict,
                candidate: Diagnosis::named_in_short(&diagnosis.named()),
                rms_um: Some(fit.rms_um).filter(|_| judged),
                temperature_degc: diagnosed.fit().experiment().temperature_degc(),
                values: fit.parameters.iter().filter(of_machine).cloned().collect(),
                trouble: not_plausible(&fit.plausibility),
                losses: diagnosed.fit().experiment().losses(),
                ..run
            };
            (run, Some(diagnosed).filter(|_| judged))
        }
        Err(failure) => (HistoryRun { trouble: failure.to_string(), ..run }, None),
    }
}

fn diagnosed(files: &[PathBuf], model: Option<&Model>) -> Result<Diagnosed, Error> {
    let experiment = crate::open_runs(&[files.to_vec()])?;
    let base = experiment.base_model();
    let fit = experiment.fit_within_reach(model.unwrap_or(&base))?;
    Diagnosed::without_plan(&fit)
}
