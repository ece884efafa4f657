//! One row of a points file as a point.

use super::notes::Notes;
use super::number::expected;
use crate::column::Column;
use crate::motion::Taken;
use crate::rows::Cell;
use trunnion_core::names::allowed;
use trunnion_core::{AxisSample, Joint, Point, Quality, Setup, State, convert};

/// Names of targets listed in a problem.
const NAMES_SHOWN: usize = 12;

/// The point of a row; `None` when something of it is wrong.
pub(super) fn read_row(
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
            let known = allowed(name, setups.iter().map(|setup| setup.name.as_str()));
            notes.add(line, at, &format!("setup \"{name}\""), &known, "Each setup needs a [[setup]] table.");
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
            let (allowed, advice) = expected(column, cell);
            notes.add(line, at, &format!("{} = \"{cell}\"", column.name()), allowed, advice);
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
