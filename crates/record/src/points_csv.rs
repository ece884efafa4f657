//! Import of points measured elsewhere, at rest or on the fly: `points.csv` and `setup.toml` (docs/design/contracts.md §2).
//!
//! Columns in any order, units in their names. Every problem of the file is reported at once, with line,
//! column, what was found and what is allowed.

use crate::column::{Column, on_the_fly, readings};
use crate::motion::{Motion, Taken, Wanted};
use crate::rows::{Cell, Row, rows};
use std::collections::HashSet;
use trunnion_core::names::nearest;
use trunnion_core::setup::parse_setup_file;
use trunnion_core::{
    AxisSample, InstrumentKind, Joint, Point, Problem, Problems, Quality, Setup, State, convert,
};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::Machine;

/// Problems kept of a file that is wrong everywhere; the same one in many rows is printed once with its count, so only the
/// memory of this list is a reason for a limit (some 30 MB).
const MOST_PROBLEMS: usize = 100_000;

/// Receives the run without its points, a point, and what the encoders read there.
pub type OnRow<'v> = &'v mut dyn FnMut(&Run, Point, Option<AxisSample>);

/// Reads a points file into a run called `name`; `file` is shown in problems.
///
/// # Errors
/// Every problem of the file.
pub fn import(
    name: &str,
    file: &str,
    text: &str,
    setups: Vec<Setup>,
    machine: Machine,
) -> Result<Run, Problems> {
    let mut run = empty(name, RunKind::Static, setups, machine);
    let mut points = Vec::new();
    run.channels =
        read(file, text, Known::of(&run), &mut |_, point, _| points.push(point)).map_err(Problems)?;
    Ok(Run { points, ..run })
}

/// Reads both files of a run at rest, each given as its name and its text, and reports the problems of both at once.
/// `machine_by_name` knows the machine that the setup file names.
///
/// # Errors
/// Every problem of either file.
pub fn import_files(
    name: &str,
    points: (&str, &str),
    setup: (&str, &str),
    machine_by_name: &dyn Fn(&str) -> Option<Machine>,
) -> Result<Run, Problems> {
    let mut taken = Vec::new();
    let run = visit_files(RunKind::Static, name, points, setup, machine_by_name, &mut |_, point, _| {
        taken.push(point);
    })?;
    Ok(Run { points: taken, ..run })
}

/// The same, at rest or on the fly, row by row: no more than two rows are in memory. Gives the run without its points.
///
/// # Errors
/// Every problem of either file; rows before the first problem have then been handed out.
pub fn visit_files(
    kind: RunKind,
    name: &str,
    (points_file, points_text): (&str, &str),
    (setup_file, setup_text): (&str, &str),
    machine_by_name: &dyn Fn(&str) -> Option<Machine>,
    on_row: OnRow<'_>,
) -> Result<Run, Problems> {
    let mut problems = Vec::new();
    let setup = parse_setup_file(setup_file, setup_text).map_err(|wrong| problems.extend(wrong.0)).ok();
    let machine = setup.as_ref().and_then(|setup| {
        let machine = machine_by_name(&setup.machine);
        if machine.is_none() {
            problems.push(unknown_machine(setup_file, setup_text, &setup.machine));
        }
        machine
    });
    let setups = setup.map(|setup| setup.setups);
    let (Some(setups), Some(machine)) = (&setups, &machine) else {
        let known = Known { kind, run: None, setups: setups.as_deref(), machine: machine.as_ref() };
        problems.extend(read(points_file, points_text, known, &mut |_, _, _| {}).err().into_iter().flatten());
        return Err(Problems(problems));
    };
    let run = empty(name, kind, setups.clone(), machine.clone());
    let channels = read(points_file, points_text, Known::of(&run), on_row).map_err(Problems)?;
    Ok(Run { channels, ..run })
}

fn empty(name: &str, kind: RunKind, setups: Vec<Setup>, machine: Machine) -> Run {
    Run { name: name.into(), machine, kind, setups, channels: Vec::new(), points: Vec::new() }
}

fn unknown_machine(file: &str, text: &str, name: &str) -> Problem {
    let line = text.lines().position(|line| line.trim_start().starts_with("machine")).map_or(0, |at| at + 1);
    Problem {
        file: file.into(),
        line,
        column: usize::from(line > 0),
        found: format!("machine = \"{name}\" is not known"),
        allowed: "the name of a machine file in config/machines, or a path".into(),
        advice: String::new(),
    }
}

/// Names of targets listed in a problem.
const NAMES_SHOWN: usize = 12;

/// What is known of the run before its points are read; without setups or machine only what can be checked without them.
#[derive(Clone, Copy)]
struct Known<'a> {
    kind: RunKind,
    run: Option<&'a Run>,
    setups: Option<&'a [Setup]>,
    machine: Option<&'a Machine>,
}

impl<'a> Known<'a> {
    fn of(run: &'a Run) -> Self {
        Self { kind: run.kind, run: Some(run), setups: Some(&run.setups), machine: Some(&run.machine) }
    }
}

/// Reads the points; gives the names of the temperature channels.
fn read(file: &str, text: &str, known: Known<'_>, on_row: OnRow<'_>) -> Result<Vec<String>, Vec<Problem>> {
    let mut notes = Notes { file, list: Vec::new(), more: 0 };
    let mut rows = rows(text);
    let Some(Row { line: header_line, cells: header }) = rows.next() else {
        notes.add(0, 0, "the file is empty", "a header row and a row for each point", "");
        return Err(notes.finish());
    };
    let columns = read_header(&mut notes, header_line, &header, known);
    let channels: Vec<String> = columns
        .iter()
        .flatten()
        .filter_map(|column| match column {
            Column::Temperature(name) => Some(name.clone()),
            _ => None,
        })
        .collect();
    let head = known.run.map(|run| Run { channels: channels.clone(), ..run.clone() });
    let mut motion = Motion::new(wanted(&columns, known));
    let (mut points, mut last_s) = (0_u64, f64::NEG_INFINITY);
    for Row { line, cells } in rows {
        if cells.len() != columns.len() {
            let found = format!("{} cells", cells.len());
            let advice = "A decimal mark must be a point; cells are separated by commas.";
            notes.add(line, 1, &found, &format!("{}, as in the header", columns.len()), advice);
            continue;
        }
        let Some(taken) = read_row(&mut notes, line, &columns, &cells, known.setups) else { continue };
        if let (RunKind::OnTheFly, Some(time_s)) = (known.kind, taken.point.state.time_s) {
            if time_s < last_s {
                let advice = "Sort the rows by time, and give each run a file of its own.";
                notes.add(
                    line,
                    1,
                    &format!("time_s = {time_s} after {last_s}"),
                    "rows in order of time",
                    advice,
                );
            }
            last_s = time_s;
        }
        points += 1;
        if let (Some(head), true, Some(Taken { point, actual, .. })) =
            (&head, notes.list.is_empty(), motion.push(taken))
        {
            on_row(head, point, actual);
        }
    }
    if points == 0 && notes.list.is_empty() {
        notes.add(header_line, 1, "no point follows the header", "a row for each point", "");
    }
    if !notes.list.is_empty() {
        return Err(notes.finish());
    }
    if let (Some(head), Some(Taken { point, actual, .. })) = (&head, motion.finish()) {
        on_row(head, point, actual);
    }
    Ok(channels)
}

/// What the columns leave to be told from the positions.
fn wanted(columns: &[Option<Column>], known: Known<'_>) -> Wanted {
    let stated: HashSet<&Column> = columns.iter().flatten().collect();
    let any = |of: fn(&Column) -> bool| columns.iter().flatten().any(of);
    let joints = known.machine.map_or_else(Vec::new, Machine::joints);
    let moves = known.kind == RunKind::OnTheFly;
    Wanted {
        directions: joints.into_iter().filter(|&joint| !stated.contains(&Column::Direction(joint))).collect(),
        since_reversal: !any(|column| matches!(column, Column::SinceReversal(_))),
        speeds: moves && !any(|column| matches!(column, Column::Speed(_))),
        accelerations: moves && !any(|column| matches!(column, Column::Acceleration(_))),
    }
}

fn read_header(
    notes: &mut Notes<'_>,
    line: usize,
    header: &[Cell],
    Known { kind, setups, machine, .. }: Known<'_>,
) -> Vec<Option<Column>> {
    let every_kind = InstrumentKind::NAMES.map(|(_, kind)| kind).to_vec();
    let kinds = setups.map_or(every_kind, |setups| setups.iter().map(|setup| setup.instrument).collect());
    let joints = machine.map_or_else(|| Joint::ISO.to_vec(), Machine::joints);
    let mut required = vec![Column::Setup];
    required.extend(joints.iter().copied().map(Column::Position));
    let readings = readings(kinds.iter().copied());
    if let Some(name) =
        readings.iter().map(|column| column.name()).find(|name| required.iter().any(|c| c.name() == *name))
    {
        let found = format!("{name} is a reading of an instrument and the position of a joint");
        notes.add(
            line,
            1,
            &found,
            "a machine without a joint of that name",
            "Rename the joint in the machine file.",
        );
    }
    required.extend(readings.into_iter().map(Column::Reading));
    if setups.is_none_or(|setups| setups.iter().any(|setup| setup.artefact.is_some())) {
        required.push(Column::Target);
    }
    let mut allowed = required.clone();
    allowed.push(Column::Time);
    allowed.extend(joints.iter().copied().map(Column::Direction));
    if kind == RunKind::OnTheFly {
        allowed.extend(on_the_fly(&joints, kinds.iter().copied()));
    }
    let names = allowed.iter().map(Column::name).collect::<Vec<_>>().join(", ") + ", NAME_degc";

    let mut columns: Vec<Option<Column>> = Vec::new();
    let semicolons = header.iter().any(|(_, cell)| cell.contains(';'));
    for &(at, ref cell) in header {
        let column = Column::parse(cell, &allowed);
        if column.is_none() && (machine.is_some() || !may_be_joint(cell)) {
            let advice = match nearest(
                cell,
                allowed.iter().map(Column::name).collect::<Vec<_>>().iter().map(String::as_str),
            ) {
                _ if semicolons => "Separate the columns by commas.".into(),
                Some(near) => format!("Did you mean {near}?"),
                None => String::new(),
            };
            notes.add(line, at, &format!("column \"{cell}\""), &names, &advice);
        } else if column.is_some() && columns.contains(&column) {
            notes.add(line, at, &format!("column \"{cell}\" appears twice"), "each column once", "");
        }
        columns.push(column);
    }
    if machine.is_some() && setups.is_some() {
        for column in required.into_iter().map(Some).filter(|column| !columns.contains(column)) {
            let name = column.as_ref().map(Column::name).unwrap_or_default();
            notes.add(line, 1, &format!("column {name} is missing"), &names, "");
        }
    }
    columns
}

/// Without its machine nobody knows whether a column is about one of its joints.
fn may_be_joint(name: &str) -> bool {
    name.ends_with("_deg") || name.ends_with("_mm") || name.starts_with("direction_")
}

fn read_row(
    notes: &mut Notes<'_>,
    line: usize,
    columns: &[Option<Column>],
    cells: &[Cell],
    setups: Option<&[Setup]>,
) -> Option<Taken> {
    let before = notes.count();
    let setup_cell = columns.iter().position(|column| *column == Some(Column::Setup)).map(|at| &cells[at]);
    let setup = setups.zip(setup_cell).and_then(|(setups, &(at, ref name))| {
        let setup = setups.iter().position(|setup| setup.name == *name);
        if setup.is_none() {
            let names = setups.iter().map(|setup| setup.name.as_str()).collect::<Vec<_>>().join(", ");
            notes.add(line, at, &format!("setup \"{name}\""), &names, "Each setup needs a [[setup]] table.");
        }
        setup
    });
    let mounted = setups.zip(setup).map(|(setups, setup)| &setups[setup]);
    let mut state = State { setup: setup.unwrap_or(0), ..State::default() };
    let (mut reading_mm, mut spread_mm, mut samples) = ([0.0; 3], [0.0; 3], 0);
    let (mut feed_mm_per_s, mut encoders) = (None, Vec::new());
    for (column, &(at, ref cell)) in columns.iter().zip(cells) {
        let Some(column) = column else { continue };
        let foreign = match column {
            Column::Setup => continue,
            Column::Reading(column) => mounted.is_some_and(|s| !s.instrument.columns().contains(column)),
            Column::Target => mounted.is_some_and(|setup| setup.artefact.is_none()),
            Column::Spread(component) => {
                mounted.is_some_and(|s| !s.instrument.components().contains(component))
            }
            _ => false,
        };
        if foreign {
            if !cell.is_empty() {
                let found = format!("{} = {cell}", column.name());
                notes.add(line, at, &found, "an empty cell: this setup does not measure it", "");
            }
            continue;
        }
        if *column == Column::Target {
            state.target = read_target(notes, (line, at, cell), mounted);
            continue;
        }
        let Some(number) = cell.parse().ok().filter(|number: &f64| number.is_finite()) else {
            notes.add(line, at, &format!("{} = \"{cell}\"", column.name()), "a finite number", "");
            continue;
        };
        match column {
            Column::Setup | Column::Target => {}
            Column::Time => state.time_s = Some(number),
            Column::Position(joint) => state.position[*joint] = inside(*joint, number),
            Column::Actual(joint) => encoders.push((*joint, inside(*joint, number))),
            Column::Speed(joint) => state.velocity[*joint] = inside(*joint, number),
            Column::Acceleration(joint) => state.acceleration[*joint] = inside(*joint, number),
            Column::SinceReversal(joint) => state.since_reversal[*joint] = inside(*joint, number),
            Column::Feed => feed_mm_per_s = Some(number / 60.0),
            Column::Samples if number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX) => {
                samples = number as u32;
            }
            Column::Samples => notes.add(line, at, &format!("samples = {cell}"), "a whole number", ""),
            Column::Spread(component) => {
                let components = mounted.map_or(&[][..], |setup| setup.instrument.components());
                if let Some(i) = components.iter().position(|own| own == component) {
                    spread_mm[i] = convert::mm_from_um(number);
                }
            }
            Column::Direction(letter) if [-1.0, 0.0, 1.0].contains(&number) => {
                state.direction[*letter] = number;
            }
            Column::Direction(_) => {
                notes.add(line, at, &format!("{} = {cell}", column.name()), "-1, 0, 1", "");
            }
            Column::Reading(column) => {
                let own = mounted.map(|setup| (setup, setup.instrument.columns()));
                let i = own.and_then(|(_, columns)| columns.iter().position(|own| own == column));
                if let Some((setup, i)) = mounted.zip(i) {
                    reading_mm[i] = setup.reading_from_column_mm(i, number);
                }
            }
            Column::Temperature(_) => state.temperature_degc.push(number),
        }
    }
    if mounted.is_some_and(|setup| setup.instrument.deflects_probes()) {
        state.deflection_mm = reading_mm.into();
    }
    // An axis whose encoder no column states is where it was asked to be.
    let actual = (!encoders.is_empty()).then(|| {
        let mut position = state.position;
        encoders.into_iter().for_each(|(joint, q)| position[joint] = q);
        AxisSample { time_s: state.time_s.unwrap_or_default(), position, ..AxisSample::default() }
    });
    let point = Point { state, reading_mm, spread_mm, samples, quality: Quality::Good };
    (notes.count() == before).then_some(Taken { point, feed_mm_per_s, actual })
}

/// mm and rad from the units of a column.
fn inside(joint: Joint, number: f64) -> f64 {
    if joint.is_rotary() { convert::rad_from_deg(number) } else { number }
}

/// Index of the target that a cell names.
fn read_target(
    notes: &mut Notes<'_>,
    (line, at, cell): (usize, usize, &str),
    mounted: Option<&Setup>,
) -> usize {
    let targets = mounted.and_then(|setup| setup.artefact.as_ref()).map(|artefact| &artefact.targets);
    let target = targets.and_then(|targets| targets.iter().position(|target| target.name == cell));
    if let (Some(targets), None) = (targets, target) {
        let names: Vec<&str> = targets.iter().take(NAMES_SHOWN).map(|target| target.name.as_str()).collect();
        let more = if targets.len() > NAMES_SHOWN { ", …" } else { "" };
        let advice = "Each target needs a [[setup.artefact.target]] table.";
        notes.add(line, at, &format!("target \"{cell}\""), &(names.join(", ") + more), advice);
    }
    target.unwrap_or(0)
}

struct Notes<'a> {
    file: &'a str,
    list: Vec<Problem>,
    more: usize,
}

impl Notes<'_> {
    fn add(&mut self, line: usize, column: usize, found: &str, allowed: &str, advice: &str) {
        if self.list.len() >= MOST_PROBLEMS {
            self.more += 1;
            return;
        }
        let (found, allowed, advice) = (found.into(), allowed.into(), advice.into());
        self.list.push(Problem { file: self.file.into(), line, column, found, allowed, advice });
    }

    fn count(&self) -> usize {
        self.list.len() + self.more
    }

    fn finish(mut self) -> Vec<Problem> {
        if self.more > 0 {
            self.list.push(Problem {
                file: self.file.into(),
                line: 0,
                column: 0,
                found: format!("{} more problems of this file are not listed", self.more),
                allowed: String::new(),
                advice: String::new(),
            });
        }
        self.list
    }
}
