//! What text and page of a named method share: numbers in their units, heads of tables.

use crate::number::{MISSING, fixed, plain, signed, unit_on_screen, value_and_u};
use crate::to_do::{NOT_ON_THESE_RUNS, SCHEMES};
use std::cmp::Ordering::Equal;
use trunnion_results::sentences::{at_tool_um, error_in_words, not_plausible, setting_in_words};
use trunnion_results::{Cell, Column, Findings, FoundValue, Table, ValueKind};

/// Heads of the table of values.
pub const VALUE_HEADS: [&str; 4] = ["quantity", "value", "u", "remark"];

/// Name, value, standard uncertainty, remark.
pub fn value_row(found: &FoundValue) -> Vec<String> {
    let (value, u) = value_and_u(found.value, found.u, &found.unit);
    vec![found.name.clone(), value, u, found.note.clone()]
}

/// A value counts as different from zero above so many standard uncertainties: the 95 % interval of the GUM, k = 2.
const CLEAR_U: f64 = 2.0;

/// What a method comes to: its summary, the significant error that moves the tool most, how many are significant, and what these runs do not
/// show.
pub fn verdict(findings: &Findings) -> Vec<String> {
    let (shown, hidden): (Vec<_>, Vec<_>) = findings.values.iter().partition(|found| found.value.is_some());
    let clear: Vec<&FoundValue> = shown.iter().copied().filter(|found| is_clear(found)).collect();
    let errors_with_u = |all: &[&FoundValue]| {
        all.iter().filter(|found| found.kind == ValueKind::Error && in_u(found).is_some()).count()
    };
    let with_u = errors_with_u(&shown);
    let at_tool = |found: &FoundValue| at_tool_um(found.value?, &found.unit);
    let errors = clear.iter().copied().filter(|found| found.kind == ValueKind::Error);
    let most = errors.max_by(|a, b| at_tool(a).partial_cmp(&at_tool(b)).unwrap_or(Equal));
    let has_summary = shown.iter().any(|found| found.kind == ValueKind::Summary);
    let first = match most {
        // It is the verdict.
        None if has_summary => None,
        Some(found) => {
            let (value, u) = value_and_u(found.value, found.u, &found.unit);
            let (name, symbol) = in_words(&found.name);
            let over = match at_tool(found) {
                Some(um) if found.unit != "um" => format!(" ({} µm over 100 mm)", plain(um)),
                _ => String::new(),
            };
            // Of a unit without a shift it is not known how far it moves the tool.
            let does = if at_tool(found).is_some() { "moves the tool most" } else { "is significant" };
            Some(format!("{name} {does}: {value}{over}, standard uncertainty {u}{symbol}."))
        }
        None if !clear.is_empty() => {
            Some("Only what mounting left is significantly different from zero.".into())
        }
        None if with_u > 0 => Some("No value is significantly different from zero.".into()),
        None if shown.is_empty() => Some("These runs show none of the values of this method.".into()),
        None => Some(format!("{} values, without an uncertainty.", shown.len())),
    };
    let mut sentences = Vec::new();
    if !findings.plausibility.is_empty() {
        let doubt = "These numbers are not to be relied on, because the runs are not plausible or not whole.";
        sentences.extend([doubt.into(), not_plausible(&findings.plausibility)]);
    }
    sentences
        .extend(shown.iter().filter(|found| found.kind == ValueKind::Summary).map(|found| summary(found)));
    sentences.extend(first);
    if with_u > 0 {
        let count = errors_with_u(&clear);
        sentences
            .push(format!("{count} of {with_u} errors with an uncertainty are larger than {CLEAR_U} u."));
    }
    if !hidden.is_empty() {
        let names: Vec<&str> = hidden.iter().map(|found| found.name.as_str()).collect();
        sentences.push(format!("These runs do not show {}.", names.join(", ")));
    }
    sentences
}

/// What to do, in order: what the method says, else what its values allow; empty where nothing is known.
pub fn to_do(findings: &Findings) -> Vec<String> {
    if !findings.plausibility.is_empty() {
        return NOT_ON_THESE_RUNS.map(String::from).to_vec();
    }
    if !findings.to_do.is_empty() {
        return findings.to_do.clone();
    }
    let errors = findings.values.iter().filter(|found| found.kind == ValueKind::Error);
    let (shown, hidden): (Vec<_>, Vec<_>) = errors.partition(|found| found.value.is_some());
    let mut to_do = Vec::new();
    if shown.iter().any(|found| is_clear(found)) {
        to_do.push(
            "Ask what is behind it, and what is confounded with it: trunnion diagnose with the same runs."
                .into(),
        );
        to_do.push("Ask what the control can be given: trunnion correct with the same runs.".into());
    } else if shown.iter().any(|found| in_u(found).is_some()) {
        to_do.push(format!("Change nothing on these runs: no error is larger than {CLEAR_U} u."));
    }
    if !hidden.is_empty() {
        to_do.push(SCHEMES.into());
    }
    to_do
}

/// The size of a value in standard uncertainties.
fn in_u(found: &FoundValue) -> Option<f64> {
    Some(found.value?.abs() / found.u.filter(|u| *u > 0.0)?)
}

fn is_clear(found: &FoundValue) -> bool {
    in_u(found).is_some_and(|size| size > CLEAR_U)
}

/// `Bidirectional circular deviation: 6.61 µm (XY G(b)).`
fn summary(found: &FoundValue) -> String {
    let (value, _) = value_and_u(found.value, found.u, &found.unit);
    let mut letters = found.note.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    format!("{first}{}: {value} ({}).", letters.as_str(), found.name)
}

/// The name of a value in words, and its symbol in brackets: a headline begins with no symbol. `XY EC0Y` is said of its plane.
fn in_words(name: &str) -> (String, String) {
    let (first, rest) = name.split_once(' ').unwrap_or((name, ""));
    let words = |name| error_in_words(name).or_else(|| setting_in_words(name));
    match (words(first), words(rest)) {
        (Some(words), _) if rest.is_empty() => (format!("The {words}"), format!(" ({first})")),
        // Which trace shows it, `by C-XY`, follows the name.
        (Some(words), _) if rest.starts_with("by ") => (format!("The {words} {rest}"), format!(" ({first})")),
        (Some(words), _) => (format!("The {rest} of the {words}"), format!(" ({first})")),
        (None, Some(words)) => (format!("In {first}, the {words}"), format!(" ({rest})")),
        (None, None) => (name.into(), String::new()),
    }
}

/// Heads with units.
pub fn heads(table: &Table) -> Vec<String> {
    let head = |column: &Column| {
        column.unit.as_ref().map_or_else(
            || column.name.clone(),
            |unit| match unit_on_screen(unit) {
                symbol if symbol.is_empty() => column.name.clone(),
                symbol => format!("{} ({symbol})", column.name),
            },
        )
    };
    table.columns.iter().map(head).collect()
}

/// Cells as text; numbers in the unit of their column.
pub fn cells(table: &Table, row: &[Cell]) -> Vec<String> {
    let is_u = |j: usize| table.columns.get(j).is_some_and(|column| column.name == "u");
    let is_shift = |column: &Column| matches!(column.unit.as_deref(), Some("um" | "urad"));
    let text = |(j, (cell, column)): (usize, (&Cell, &Column))| match (cell, row.get(j + 1)) {
        (Cell::Text(text), _) => text.clone(),
        // Places are reported to a tenth, however far out.
        (Cell::Number(mm), _) if column.unit.as_deref() == Some("mm") => {
            signed(*mm, 1).trim_start_matches('+').into()
        }
        // A value has the digits of the standard uncertainty next to it.
        (Cell::Number(value), Some(Cell::Number(u))) if is_u(j + 1) => {
            value_and_u(Some(*value), Some(*u), "1").0
        }
        (Cell::Number(u), _) if is_u(j) => value_and_u(Some(0.0), Some(*u), "1").1,
        // No instrument shows less.
        (Cell::Number(number), _) if is_shift(column) && number.abs() < 1e-3 => fixed(*number, 3),
        (Cell::Number(number), _) => plain(*number),
        (Cell::Missing, _) => MISSING.into(),
    };
    row.iter().zip(&table.columns).enumerate().map(text).collect()
}

/// Columns that hold numbers.
pub fn numeric(table: &Table) -> Vec<usize> {
    let is_number = |j: &usize| {
        let mut cells = table.rows.iter().filter_map(|row| row.get(*j)).peekable();
        cells.peek().is_some() && cells.all(|cell| !matches!(cell, Cell::Text(_)))
    };
    (0..table.columns.len()).filter(is_number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(name: &str, kind: ValueKind, value: f64, u: Option<f64>) -> FoundValue {
        FoundValue {
            name: name.into(),
            kind,
            value: Some(value),
            unit: "um".into(),
            u,
            ..FoundValue::default()
        }
    }

    #[test]
    fn where_nothing_but_the_summary_is_significant_it_is_the_verdict() {
        let accuracy = value("X A", ValueKind::Summary, 6.94, Some(0.4));
        let values = vec![
            FoundValue { note: "accuracy".into(), ..accuracy },
            value("X mean reversal", ValueKind::Error, 0.05, Some(0.06)),
        ];
        let mut found = Findings { values, ..Findings::default() };
        assert_eq!(
            verdict(&found),
            ["Accuracy: 6.94 µm (X A).", "0 of 1 errors with an uncertainty are larger than 2 u."]
        );
        found.values[0].kind = ValueKind::Setting;
        assert_eq!(verdict(&found)[0], "Only what mounting left is significantly different from zero.");
    }

    #[test]
    fn no_cell_has_less_than_an_instrument_shows() {
        let column = |unit: Option<&str>| Column { name: "size".into(), unit: unit.map(String::from) };
        let table = Table { columns: vec![column(Some("um")), column(None)], ..Table::default() };
        assert_eq!(cells(&table, &[Cell::Number(-1.1e-4), Cell::Number(1e-7)]), ["0.000", "1.0e−7"]);
    }
}
