//! Likely causes of everything that is significant, ranked over the machine.
//!
//! Amounts are made comparable at the end of a lever of 100 mm, over which S4 prints tilts: a tilt ω counts ω · 100 mm. The share is that of
//! the squared amounts of all rows. Of a step with the direction half counts, as of a wave its amplitude.

use super::causes::{Cause, ErrorKind, of_number};
use super::dependence::Dependence;
use super::found::Found;
use super::track::Axis;
use crate::findings::{Cell, Column, FoundTable};
use trunnion_core::{Joint, LEVER_MM};
use trunnion_effects::Unit;

/// Cause of a wave that is no ring of a bearing, which does not know how the axis turns.
const CHANGES: &str = "not the bearing alone: see what it depends on";

/// A significant part of what the machine does wrong.
pub(super) struct Row {
    what: String,
    axis: Option<Joint>,
    /// In which traces a wave is seen.
    kind: Option<ErrorKind>,
    waves: Option<usize>,
    amount_mm: f64,
    u_mm: f64,
    words: String,
    depends: String,
}

impl Row {
    /// A wave of an error motion.
    pub fn of_wave(
        name: &str,
        axis: Axis,
        kind: ErrorKind,
        cause: &Cause,
        dependences: &[Dependence],
    ) -> Self {
        let lever = if kind == ErrorKind::Tilt { LEVER_MM } else { 1.0 };
        // A tilt is the difference of two radial motions: what one shows the other may have.
        let seen_in = if kind == ErrorKind::Tilt { ErrorKind::Radial } else { kind };
        let of_wave = |other: &&Dependence| {
            (other.axis, other.kind, other.order) == (axis.letter, seen_in, cause.harmonic.order)
        };
        let depends: Vec<&str> =
            dependences.iter().filter(of_wave).map(|other| other.words.as_str()).collect();
        Self {
            what: name.into(),
            axis: Some(axis.letter),
            kind: Some(seen_in),
            waves: Some(cause.harmonic.order),
            amount_mm: cause.harmonic.amplitude * lever,
            u_mm: cause.harmonic.u * lever,
            words: cause.words.clone(),
            depends: depends.join("; "),
        }
    }

    fn of_dependence(dependence: &Dependence) -> Self {
        let way = if dependence.kind == ErrorKind::Axial { "along" } else { "across" };
        Self {
            what: format!("{way} {}", dependence.axis),
            axis: Some(dependence.axis),
            kind: Some(dependence.kind),
            waves: Some(dependence.order),
            amount_mm: dependence.half_mm,
            u_mm: dependence.u_mm,
            words: CHANGES.into(),
            depends: dependence.words.clone(),
        }
    }

    fn of_number(what: &str, kind: ErrorKind, value_mm: f64, u_mm: f64, quantities: usize) -> Option<Self> {
        let words = of_number(kind, value_mm, u_mm, quantities).trim_start_matches("likely: ");
        (!words.is_empty()).then(|| Self {
            what: what.into(),
            axis: None,
            kind: None,
            waves: None,
            amount_mm: value_mm.abs(),
            u_mm,
            words: words.into(),
            depends: String::new(),
        })
    }
}

/// The table; `None` where nothing is significant. `waves`: of all error motions; `quantities`: how many are judged together.
pub(super) fn ranked(
    found: &Found<'_>,
    waves: Vec<Row>,
    dependences: &[Dependence],
    quantities: usize,
) -> Option<FoundTable> {
    let mut rows = waves;
    // What changes sign has no mean, so it is no wave of an error motion.
    let is_unnamed = |other: &&Dependence| {
        let its = (Some(other.axis), Some(other.kind), Some(other.order));
        !rows.iter().any(|row| (row.axis, row.kind, row.waves) == its)
    };
    let alone: Vec<Row> = dependences.iter().filter(is_unnamed).map(Row::of_dependence).collect();
    rows.extend(alone);
    rows.extend(found.location.iter().filter_map(|location| {
        let lever = if location.unit == Unit::URAD { LEVER_MM } else { 1.0 };
        Row::of_number(&location.name, location.kind, location.value * lever, location.u * lever, quantities)
    }));
    rows.extend(found.shapes.iter().filter_map(|shape| {
        let (half_mm, u_mm) = (0.5 * shape.reversal_mm?, shape.u_mean_mm);
        Row::of_number(&format!("{} reversal", shape.label), ErrorKind::Reversal, half_mm, u_mm, quantities)
    }));
    rows.sort_by(|a, b| b.amount_mm.total_cmp(&a.amount_mm));
    let all: f64 = rows.iter().map(|row| row.amount_mm.powi(2)).sum();
    let cells = |row: &Row| {
        vec![
            Cell::Text(row.what.clone()),
            row.waves.map_or(Cell::Missing, |waves| Cell::Text(waves.to_string())),
            Cell::Number(row.amount_mm),
            Cell::Number(row.u_mm),
            Cell::Text(format!("{:.0}", 100.0 * row.amount_mm.powi(2) / all)),
            Cell::Text(row.words.clone()),
            Cell::Text(row.depends.clone()),
        ]
    };
    let columns = vec![
        Column::plain("seen in"),
        Column::plain("waves a turn"),
        Column::of("amount at 100 mm", Unit::UM),
        Column::of("u", Unit::UM),
        Column::plain("share of squares, %"),
        Column::plain("likely cause"),
        Column::plain("depends on"),
    ];
    (!rows.is_empty()).then(|| FoundTable {
        caption: "Likely causes, ranked over the machine; nothing is said of what is not significant".into(),
        columns,
        rows: rows.iter().map(cells).collect(),
    })
}
