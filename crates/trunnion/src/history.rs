//! The runs of one machine in order of time, each fitted with the same model.

mod change;
mod corrections;
mod forecast;
mod found;
mod keeper;
mod watch;

pub use corrections::{corrections, enter_correction, entered};
pub use forecast::{days, next_day, without};
pub use found::{Filed, filed};
pub use keeper::{Keeper, Working};

use crate::{Diagnosed, Error, Model, moment};
use found::{Found, diagnosed};
use keeper::{CHANGE, FORECAST};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trunnion_core::number::counted;
use trunnion_core::{chain, names};
use trunnion_results::{
    Alarm, AlarmsNow, CorrectionEntered, Diagnosis, HistoryRun, MachineHistory, RunChange, RunFound, RunLine,
    Verdict,
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

/// A run that can be compared.
struct Comparable {
    name: String,
    files: Vec<PathBuf>,
    /// Ids of the effects that were fitted.
    effects: Vec<String>,
    /// Where it was worked out just now.
    diagnosed: Option<Diagnosed>,
}

/// The history of one machine from runs in any order, each with the recordings that hold it. A run that cannot be read or judged is
/// listed with the reason.
///
/// # Errors
/// No recording of the machine, or no run called `since`.
pub fn history(
    runs: &[Vec<PathBuf>],
    wanted: &Wanted,
    keeper: &mut Keeper<'_>,
) -> Result<MachineHistory, Error> {
    let mut headers: Vec<Header> = runs.iter().map(|files| header(files)).collect();
    headers.sort_by(|a, b| (a.run.began_s, &a.run.run).cmp(&(b.run.began_s, &b.run.run)));
    let newest = headers.iter().rev().map(|header| header.machine.clone()).find(|name| !name.is_empty());
    let machine = wanted.machine.clone().or(newest).unwrap_or_default();
    if !headers.iter().any(|header| header.machine == machine) {
        return Err(no_runs(machine, &headers));
    }
    let notes = others(&machine, &headers).into_iter().collect();
    // What cannot be read has no machine; it is listed, lest it is missed.
    headers.retain(|header| header.machine == machine || header.machine.is_empty());
    let since = index_of(&headers, wanted.since.as_deref())?;
    let model = wanted.model.as_ref();
    let mut history = MachineHistory { machine, notes, ..MachineHistory::default() };
    let mut last_two: [Option<Comparable>; 2] = [None, None];
    let mut recordings = Vec::new();
    keeper.total = headers.len() + [CHANGE, FORECAST].len();
    for Header { files, run, .. } in headers {
        let (run, comparable) = judged(&files, run, model, keeper);
        if comparable.is_some() {
            last_two = [last_two[1].take(), comparable];
        }
        history.runs.push(run);
        recordings.push(files);
    }
    let [earlier, later] = last_two;
    history.effects = later.as_ref().map_or_else(Vec::new, |later| later.effects.clone());
    if let Some([earlier, later]) = earlier.zip(later).map(<[Comparable; 2]>::from) {
        let names = format!("{} and {}", earlier.name, later.name);
        match change_of([earlier, later], model, keeper) {
            Ok(change) => history.change = Some(change),
            // The list and its limits hold without it.
            Err(failure) => {
                history.why_no_change = format!("{names} cannot be compared: {}.", chain(&failure))
            }
        }
    }
    watched(&mut history, since, &wanted.corrections);
    history.forecast = Some(match days(&history, since) {
        Ok(days) => {
            let of_days: Vec<Vec<PathBuf>> =
                days.into_iter().map(|index| recordings[index].clone()).collect();
            next_day(&of_days, model, keeper)
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

fn no_runs(machine: String, headers: &[Header]) -> Error {
    let mut machines: Vec<&str> = headers.iter().map(|header| header.machine.as_str()).collect();
    machines.sort_unstable();
    machines.dedup();
    machines.retain(|name| !name.is_empty());
    let allowed = match machines.is_empty() {
        true => "none of them can be read".into(),
        false => format!("they are of {}", names::allowed(&machine, machines)),
    };
    Error::NoRuns { machine, allowed }
}

/// Which machines the other runs are of, and how they are asked for; `None` where there are none.
fn others(machine: &str, headers: &[Header]) -> Option<String> {
    let mut others = BTreeMap::<&str, u64>::new();
    for header in headers.iter().filter(|header| header.machine != machine && !header.machine.is_empty()) {
        *others.entry(&header.machine).or_default() += 1;
    }
    let (first, _) = others.first_key_value()?;
    let named: Vec<String> =
        others.iter().map(|(name, count)| format!("{name} ({})", counted(*count, "run"))).collect();
    Some(format!(
        "The folder also has runs of {}. Name a machine to see its runs: `trunnion history {first}` with the same --folder.",
        named.join(", ")
    ))
}

/// Index of the run of this name; of the first without one.
fn index_of(headers: &[Header], name: Option<&str>) -> Result<usize, Error> {
    let Some(name) = name else { return Ok(0) };
    let runs = || headers.iter().map(|header| header.run.run.as_str());
    let unknown = || Error::NoSuchRun { name: name.into(), runs: names::allowed(name, runs()) };
    runs().position(|run| run == name).ok_or_else(unknown)
}

/// Name of the run that these recordings hold.
fn name_of(files: &[PathBuf]) -> String {
    let stem = files.first().and_then(|path| path.file_stem());
    stem.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

fn header(files: &[PathBuf]) -> Header {
    let path = files.first().map_or(Path::new(""), PathBuf::as_path);
    let run = HistoryRun { run: name_of(files), ..HistoryRun::default() };
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
pub fn changed(runs: [Vec<PathBuf>; 2], model: &Model, keeper: &mut Keeper<'_>) -> Result<RunChange, Error> {
    let runs =
        runs.map(|files| Comparable { name: name_of(&files), files, effects: Vec::new(), diagnosed: None });
    change_of(runs, Some(model), keeper)
}

fn change_of(
    runs: [Comparable; 2],
    model: Option<&Model>,
    keeper: &mut Keeper<'_>,
) -> Result<RunChange, Error> {
    let files = runs.each_ref().map(|run| run.files.clone());
    keeper.answer(("change", CHANGE), &files, model, || {
        let [earlier, later] = runs.map(|Comparable { name, files, diagnosed: known, .. }| {
            Ok::<_, Error>((name, known.map_or_else(|| diagnosed(&files, model), Ok)?))
        });
        change::change(&earlier?, &later?)
    })
}

/// A run with what was found in it, and with the analysis where it can be compared with others.
fn judged(
    files: &[PathBuf],
    run: HistoryRun,
    model: Option<&Model>,
    keeper: &mut Keeper<'_>,
) -> (HistoryRun, Option<Comparable>) {
    if !run.trouble.is_empty() {
        keeper.done += 1;
        return (run, None);
    }
    let mut worked_out = None;
    let found = found::found(files, &run.run, model, keeper, &mut worked_out);
    match found {
        Ok(Found { effects, run: found }) => {
            let (name, files) = (run.run.clone(), files.to_vec());
            let comparable = Comparable { name, files, effects, diagnosed: worked_out };
            let run = HistoryRun { run: run.run, began_s: run.began_s, began: run.began, ..found };
            let is_judged = run.rms_um.is_some();
            (run, is_judged.then_some(comparable))
        }
        Err(failure) => (HistoryRun { trouble: failure.to_string(), ..run }, None),
    }
}
