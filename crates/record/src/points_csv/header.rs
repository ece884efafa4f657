//! The header row of a points file: which column holds what.

use super::notes::Notes;
use crate::column::{Column, on_the_fly, readings};
use crate::motion::Wanted;
use crate::rows::Cell;
use std::collections::HashSet;
use trunnion_core::names::nearest;
use trunnion_core::{InstrumentKind, Joint, Setup};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::Machine;

/// What is known of the run before its points are read; without setups or machine only what can be checked without them.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    pub kind: RunKind,
    pub run: Option<&'a Run>,
    pub setups: Option<&'a [Setup]>,
    pub machine: Option<&'a Machine>,
}

impl<'a> Known<'a> {
    pub fn of(run: &'a Run) -> Self {
        Self { kind: run.kind, run: Some(run), setups: Some(&run.setups), machine: Some(&run.machine) }
    }
}

/// The columns in order; `None` where nobody knows what one holds, which is noted unless it may be about a joint.
pub(super) fn read_header(
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
    // Of files that cannot be read nobody knows the joints and the instruments.
    let is_known = setups.is_some() && machine.is_some();
    let mut of_readings = readings.iter().map(|column| column.name());
    if let Some(name) =
        of_readings.find(|name| is_known && required.iter().any(|column| column.name() == *name))
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
    let only_on_the_fly = match kind {
        RunKind::Static => on_the_fly(&joints, kinds.iter().copied()),
        RunKind::OnTheFly => Vec::new(),
    };
    let names = allowed.iter().map(Column::name).collect::<Vec<_>>().join(", ") + ", NAME_degc";

    // Spreadsheets like capitals, and people write µ: the sign of the unit, or the Greek letter.
    let among = |cell: &String, columns: &[Column]| {
        let plain = || cell.to_ascii_lowercase().replace(['µ', 'μ'], "u");
        Column::parse(cell, columns).or_else(|| Column::parse(&plain(), columns))
    };
    let parse = |cell: &String| among(cell, &allowed);
    let there: Vec<Column> = header.iter().filter_map(|(_, cell)| parse(cell)).collect();
    // One cell that ends in _degc reads as a temperature, and is no header either.
    if (there.is_empty() || header.len() == 1) && machine.is_some() && setups.is_some() {
        let first = header.first().map_or("", |(_, cell)| cell);
        let advice = match header {
            [(_, one)] if one.contains(char::is_whitespace) => {
                "The row is one cell: separate cells by commas, semicolons or tabs. A title in front of the header begins with #."
            }
            _ => {
                "A title in front of the header begins with #. Columns of another program are named in the setup file, [columns]."
            }
        };
        notes.add(
            line,
            1,
            &format!("this row is not the header: it begins with \"{first}\""),
            &names,
            advice,
        );
        return vec![None; header.len()];
    }
    let absent = |column: &Column| !there.contains(column);
    let mut columns: Vec<Option<Column>> = Vec::new();
    for &(at, ref cell) in header {
        let column = parse(cell);
        if column.is_none() && (machine.is_some() || !may_be_joint(cell)) {
            let near = || meant(cell, &required, &absent).or_else(|| meant(cell, &allowed, &absent));
            let another = || machine.and_then(|machine| joint_of_another(cell, machine));
            let advice = match among(cell, &only_on_the_fly) {
                Some(_) => ON_THE_FLY.into(),
                None => another()
                    .or_else(|| near().map(|near| format!("Did you mean {near}?")))
                    .unwrap_or_default(),
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

/// For a column that says how the axes moved, in a table that is read as points at rest.
const ON_THE_FLY: &str = "A run on the fly has such a column: add --kind on-the-fly.";

/// The nearest name of a column that the header lacks.
fn meant(cell: &str, of: &[Column], absent: &dyn Fn(&Column) -> bool) -> Option<String> {
    let names: Vec<String> = of.iter().filter(|column| absent(column)).map(Column::name).collect();
    nearest(cell, names.iter().map(String::as_str)).map(String::from)
}

/// A column of an axis that the machine has not, but others have.
fn joint_of_another(cell: &str, machine: &Machine) -> Option<String> {
    let name = cell.trim_end_matches("_deg").trim_end_matches("_mm").trim_start_matches("direction_");
    let letter = name.to_ascii_uppercase();
    let is_axis = name != cell && letter.len() == 1 && "XYZUVWABC".contains(&letter);
    (is_axis && machine.joint(&letter).is_none()).then(|| {
        format!("Machine {} has no axis {letter}: these points are of another machine.", machine.name)
    })
}

/// Without its machine nobody knows whether a column is about one of its joints.
fn may_be_joint(name: &str) -> bool {
    name.ends_with("_deg") || name.ends_with("_mm") || name.starts_with("direction_")
}

/// What the columns leave to be computed from the positions.
pub(super) fn wanted(columns: &[Option<Column>], known: Known<'_>) -> Wanted {
    let stated: HashSet<&Column> = columns.iter().flatten().collect();
    let any = |of: fn(&Column) -> bool| columns.iter().flatten().any(of);
    let joints = known.machine.map_or_else(Vec::new, Machine::joints);
    let moves = known.kind == RunKind::OnTheFly;
    Wanted {
        directions: joints.into_iter().filter(|&joint| !stated.contains(&Column::Direction(joint))).collect(),
        since_reversal: !any(|column| matches!(column, Column::SinceReversal(_))),
        speeds: moves && !any(|column| matches!(column, Column::Speed(_))),
        accelerations: moves && !any(|column| matches!(column, Column::Acceleration(_))),
        on_the_fly: moves,
    }
}
