//! Import of static points measured elsewhere: `points.csv` and `setup.toml` (docs/design/contracts.md §2).
//!
//! Columns in any order, units in their names. Every problem of the file is reported at once, with line,
//! column, what was found and what is allowed.

use crate::export::{position_column, reading_columns};
use crate::rows::{Cell, Row, rows};
use std::collections::HashSet;
use trunnion_core::direction::fill_directions;
use trunnion_core::names::nearest;
use trunnion_core::setup::parse_setup_file;
use trunnion_core::{
    AxisLetter, InstrumentKind, Point, Problem, Problems, Quality, ReadingColumn, Setup, State, convert,
};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::Machine;

/// A file that is wrong everywhere is not listed to its end.
const MOST_PROBLEMS: usize = 200;

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
    let (points, channels) = read(file, text, Some(&setups), Some(&machine)).map_err(Problems)?;
    Ok(Run { name: name.into(), machine, kind: RunKind::Static, setups, channels, points })
}

/// Reads both files, each given as its name and its text, and reports the problems of both at once.
/// `machine_by_name` knows the machine that the setup file names.
///
/// # Errors
/// Every problem of either file.
pub fn import_files(
    name: &str,
    (points_file, points_text): (&str, &str),
    (setup_file, setup_text): (&str, &str),
    machine_by_name: &dyn Fn(&str) -> Option<Machine>,
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
    let points = read(points_file, points_text, setups.as_deref(), machine.as_ref());
    let points = points.map_err(|wrong| problems.extend(wrong)).ok();
    match (points, setups, machine) {
        (Some((points, channels)), Some(setups), Some(machine)) => {
            Ok(Run { name: name.into(), machine, kind: RunKind::Static, setups, channels, points })
        }
        _ => Err(Problems(problems)),
    }
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

/// What a column holds.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Column {
    Setup,
    Time,
    Position(AxisLetter),
    Direction(AxisLetter),
    Target,
    Reading(ReadingColumn),
    Temperature(String),
}

/// Reads the points; without setups or machine only what can be checked without them.
fn read(
    file: &str,
    text: &str,
    setups: Option<&[Setup]>,
    machine: Option<&Machine>,
) -> Result<(Vec<Point>, Vec<String>), Vec<Problem>> {
    let mut notes = Notes { file, list: Vec::new(), more: 0 };
    let mut rows = rows(text).into_iter();
    let Some(Row { line: header_line, cells: header }) = rows.next() else {
        notes.add(0, 0, "the file is empty", "a header row and a row for each point", "");
        return Err(notes.finish());
    };
    let columns = read_header(&mut notes, header_line, &header, setups, machine);
    let mut points = Vec::new();
    for Row { line, cells } in rows {
        if cells.len() != columns.len() {
            let found = format!("{} cells", cells.len());
            let advice = "A decimal mark must be a point; cells are separated by commas.";
            notes.add(line, 1, &found, &format!("{}, as in the header", columns.len()), advice);
            continue;
        }
        points.extend(read_row(&mut notes, line, &columns, &cells, setups));
    }
    if points.is_empty() && notes.list.is_empty() {
        notes.add(header_line, 1, "no point follows the header", "a row for each point", "");
    }
    if !notes.list.is_empty() {
        return Err(notes.finish());
    }
    let stated: HashSet<&Column> = columns.iter().flatten().collect();
    let joints = machine.map_or_else(Vec::new, Machine::joints);
    let unstated = joints.into_iter().filter(|&letter| !stated.contains(&Column::Direction(letter)));
    fill_directions(&mut points, &unstated.collect::<Vec<_>>());
    let channels = columns.iter().flatten().filter_map(|column| match column {
        Column::Temperature(name) => Some(name.clone()),
        _ => None,
    });
    Ok((points, channels.collect()))
}

fn read_header(
    notes: &mut Notes<'_>,
    line: usize,
    header: &[Cell],
    setups: Option<&[Setup]>,
    machine: Option<&Machine>,
) -> Vec<Option<Column>> {
    let every_kind = InstrumentKind::NAMES.map(|(_, kind)| kind).to_vec();
    let kinds = setups.map_or(every_kind, |setups| setups.iter().map(|setup| setup.instrument).collect());
    let joints = machine.map_or_else(|| AxisLetter::ISO.to_vec(), Machine::joints);
    let mut required = vec![Column::Setup];
    required.extend(joints.iter().copied().map(Column::Position));
    let readings = reading_columns(kinds.iter().copied());
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
    allowed.extend(joints.into_iter().map(Column::Direction));
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
) -> Option<Point> {
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
    let mut reading_mm = [0.0; 3];
    for (column, &(at, ref cell)) in columns.iter().zip(cells) {
        let Some(column) = column else { continue };
        let foreign = match column {
            Column::Setup => continue,
            Column::Reading(column) => mounted.is_some_and(|s| !s.instrument.columns().contains(column)),
            Column::Target => mounted.is_some_and(|setup| setup.artefact.is_none()),
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
            Column::Position(letter) if letter.is_rotary() => {
                state.position[*letter] = convert::rad_from_deg(number);
            }
            Column::Position(letter) => state.position[*letter] = number,
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
    let point = Point { state, reading_mm, spread_mm: [0.0; 3], samples: 0, quality: Quality::Good };
    (notes.count() == before).then_some(point)
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

impl Column {
    /// The column of this name out of `allowed`. Any other `NAME_degc` is a temperature.
    fn parse(name: &str, allowed: &[Self]) -> Option<Self> {
        let temperature = || name.strip_suffix("_degc").filter(|name| !name.is_empty());
        let known = allowed.iter().find(|column| column.name() == name).cloned();
        known.or_else(|| temperature().map(|name| Self::Temperature(name.into())))
    }

    fn name(&self) -> String {
        match self {
            Self::Setup => "setup".into(),
            Self::Time => "time_s".into(),
            Self::Position(letter) => position_column(*letter),
            Self::Direction(letter) => format!("direction_{}", letter.lower()),
            Self::Target => "target".into(),
            Self::Reading(column) => column.name().into(),
            Self::Temperature(name) => format!("{name}_degc"),
        }
    }
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
