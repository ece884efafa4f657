//! Import of points measured elsewhere, at rest or on the fly: `points.csv` and `setup.toml` (docs/design/contracts.md §2).
//!
//! Columns in any order, units in their names. Every problem of the file is reported at once, with line,
//! column, what was found and what is allowed.

mod header;
mod notes;
mod number;
mod renamed;
mod row;
mod units;

use crate::column::Column;
use crate::motion::{Motion, Taken};
use crate::rows::{Row, rows};
use header::{Known, read_header, wanted};
use notes::Notes;
use renamed::Renaming;
use row::read_row;
use trunnion_core::setup::{machine_of_setup_file, parse_setup_file};
use trunnion_core::{AxisSample, Point, Problem, Problems, Renamed, Setup, names};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::{Machine, shipped};

/// Receives the run without its points, a point, and what the encoders read there.
pub type OnRow<'v> = &'v mut dyn FnMut(&Run, Point, Option<AxisSample>);

/// Whether a text begins as a points file does: with a header that has setups, and positions or readings with their units.
pub fn begins(text: &str) -> bool {
    let header = rows(text).next().map_or_else(Vec::new, |row| row.cells);
    let names: Vec<String> = header.into_iter().map(|(_, cell)| cell.to_ascii_lowercase()).collect();
    let units = ["_mm", "_deg", "_um"];
    names.iter().any(|name| name == "setup")
        && names.iter().any(|name| units.iter().any(|unit| name.ends_with(unit)))
}

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
        read(file, text, &[], Known::of(&run), &mut |_, point, _| points.push(point)).map_err(Problems)?;
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
    let named = match &setup {
        Some(setup) => Some(setup.machine.clone()),
        None => machine_of_setup_file(setup_file, setup_text),
    };
    let machine = named.and_then(|name| {
        let machine = machine_by_name(&name);
        if machine.is_none() {
            problems.push(unknown_machine(setup_file, setup_text, &name));
            problems.sort_by(|one, other| one.file.cmp(&other.file).then(one.line.cmp(&other.line)));
        }
        machine
    });
    let (setups, columns) = setup.map_or((None, Vec::new()), |setup| (Some(setup.setups), setup.columns));
    let (Some(setups), Some(machine)) = (&setups, &machine) else {
        let known = Known { kind, run: None, setups: setups.as_deref(), machine: machine.as_ref() };
        let read = read(points_file, points_text, &columns, known, &mut |_, _, _| {});
        problems.extend(read.err().into_iter().flatten());
        return Err(Problems(problems));
    };
    let run = empty(name, kind, setups.clone(), machine.clone());
    let channels = read(points_file, points_text, &columns, Known::of(&run), on_row).map_err(Problems)?;
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
        advice: format!("Shipped: {}.", names::allowed(name, shipped::FILES.iter().map(|(name, _)| name))),
    }
}

/// A column of names, which may hold a point.
fn is_name(column: &str) -> bool {
    ["setup", "target"].iter().any(|name| column.eq_ignore_ascii_case(name))
}

/// Reads the points; gives the names of the temperature channels.
fn read(
    file: &str,
    text: &str,
    renamed: &[Renamed],
    known: Known<'_>,
    on_row: OnRow<'_>,
) -> Result<Vec<String>, Vec<Problem>> {
    let mut notes = Notes::of(file);
    let mut rows = rows(text);
    let Some(Row { line: header_line, cells: mut header, .. }) = rows.next() else {
        notes.add(0, 0, "the file is empty", "a header row and a row for each point", "");
        return Err(notes.finish());
    };
    // A separator at the end of each line begins a column without a name.
    while header.last().is_some_and(|(_, cell)| cell.is_empty()) {
        header.pop();
    }
    let cells_of_row = header.len();
    let names: Vec<String> = header.iter().map(|(_, cell)| cell.clone()).collect();
    let (renaming, header) = Renaming::of(&mut notes, header_line, header, renamed, known.setups);
    let columns = read_header(&mut notes, header_line, &header, known);
    if columns.iter().all(Option::is_none) && !notes.is_empty() {
        // Rows under a row that is no header say nothing.
        return Err(notes.finish());
    }
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
    let mut is_first = true;
    for Row { line, mut cells, pointed } in rows {
        while cells.len() > cells_of_row && cells.last().is_some_and(|(_, cell)| cell.is_empty()) {
            cells.pop();
        }
        if std::mem::take(&mut is_first) && units::are(&cells) {
            units::check(&mut notes, line, &names, &cells);
            continue;
        }
        if cells.iter().map(|(_, cell)| cell).eq(&names) {
            let advice = "Where the table goes on, remove this row; where another table begins, give it a file of its own.";
            notes.add(line, 1, "this row is the header again", "one header and its rows", advice);
            continue;
        }
        if cells.len() != cells_of_row {
            let found = format!("{} cells", cells.len());
            let advice = match cells.len() > cells_of_row {
                true => {
                    "Each cell needs a name in the header. Where commas separate cells, a decimal mark must be a point."
                }
                false => "The row ends too early.",
            };
            notes.add(line, 1, &found, &format!("{cells_of_row}, as in the header"), advice);
            continue;
        }
        if let Some(&place) =
            pointed.iter().find(|place| renaming.reads(**place) && !is_name(&names[**place]))
        {
            let (at, cell) = &cells[place];
            // One text for all rows, so that they are counted and not repeated.
            let advice = "The point may mark thousands: leave it out if it does, else write the comma of the other rows.";
            let found = format!("{} = \"{cell}\" in a table with decimal commas", names[place]);
            notes.add(line, *at, &found, "a number without a point", advice);
            continue;
        }
        let cells = renaming.row(cells);
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
            (&head, notes.is_empty(), motion.push(taken))
        {
            on_row(head, point, actual);
        }
    }
    if points == 0 && notes.is_empty() {
        notes.add(header_line, 1, "no point follows the header", "a row for each point", "");
    }
    if !notes.is_empty() {
        return Err(notes.finish());
    }
    while let (Some(head), Some(Taken { point, actual, .. })) = (&head, motion.next()) {
        on_row(head, point, actual);
    }
    Ok(channels)
}
