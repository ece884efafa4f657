//! What the split reports.

use super::split::{Part, Parts};
use super::sweeps::{SplitError, Sweep, Sweeps};
use crate::common::feed::{feed_of, feeds};
use crate::findings::{
    AxisName, Cell, Chart, Column, Curve, Findings, FoundTable, FoundValue, Plot, ValueKind,
};
use crate::recipes::{Convention, Method};
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::um;
use trunnion_cycles::Run;
use trunnion_effects::Unit;

/// Errors that are drawn.
const DRAWN: usize = 4;

pub(super) fn findings(method: &Method, runs: &[Run], sweeps: &Sweeps, parts: &Parts) -> Findings {
    Findings {
        values: values(sweeps, parts),
        tables: tables(sweeps, parts),
        charts: charts(sweeps, parts),
        notes: notes(sweeps, parts),
        ..method.findings(runs, Convention::RightHanded)
    }
}

/// The feed that parts with speed and acceleration belong to, e.g. `7200 °/min`.
fn fastest(sweeps: &Sweeps, parts: &Parts) -> String {
    feed_words(sweeps, parts.fastest)
}

fn feed_words(sweeps: &Sweeps, feed: f64) -> String {
    format!("{:.0} {}", feed * sweeps.unit.per_inside, sweeps.unit.text())
}

fn values(sweeps: &Sweeps, parts: &Parts) -> Vec<FoundValue> {
    let mut values = Vec::new();
    for (error, SplitError { name, unit, is_setting }) in sweeps.errors.iter().enumerate() {
        for (part, (value, u)) in parts.separated.iter().zip(&parts.of_errors[error]) {
            let found = FoundValue::new(format!("{name} {}", part.name()), *value, *unit, Some(*u));
            values.push(match part {
                Part::QuasiStatic if *is_setting => {
                    found.note("the same at every feed").kind(ValueKind::Setting)
                }
                Part::QuasiStatic => found.note("the same at every feed"),
                Part::Way => found.note("forward; backward with the other sign"),
                Part::Speed if parts.both_ways => {
                    found.note(format!("forward at {}; proportional to the feed", fastest(sweeps, parts)))
                }
                Part::Speed => found.note(format!("at {}; proportional to the feed", fastest(sweeps, parts))),
                Part::Acceleration => found
                    .note(format!("at {}; proportional to the square of the feed", fastest(sweeps, parts))),
            });
        }
    }
    values
}

/// A table for each unit, and what the base model leaves at each feed.
fn tables(sweeps: &Sweeps, parts: &Parts) -> Vec<FoundTable> {
    let mut units: Vec<Unit> = Vec::new();
    for SplitError { unit, .. } in &sweeps.errors {
        if !units.contains(unit) {
            units.push(*unit);
        }
    }
    let table = |unit: Unit| {
        let mut columns = vec![Column::plain("error")];
        for part in Part::ALL {
            columns.extend([Column::of(part.name(), unit), Column::of("u", unit)]);
        }
        let of_unit = sweeps.errors.iter().enumerate().filter(|(_, other)| other.unit == unit);
        let row = |(error, split): (usize, &SplitError)| {
            let mut row = vec![Cell::Text(split.name.clone())];
            for part in Part::ALL {
                let at = parts.separated.iter().position(|separated| *separated == part);
                row.extend(match at.map(|at| parts.of_errors[error][at]) {
                    Some((value, u)) => [Cell::Number(value), Cell::Number(u)],
                    None => [Cell::Missing, Cell::Missing],
                });
            }
            row
        };
        FoundTable {
            caption: format!(
                "Parts of each error; those with speed and acceleration at {}",
                fastest(sweeps, parts)
            ),
            columns,
            rows: of_unit.map(row).collect(),
        }
    };
    units.into_iter().map(table).chain([by_feed(sweeps)]).collect()
}

fn by_feed(sweeps: &Sweeps) -> FoundTable {
    let feeds = feeds(sweeps.all.iter().map(|sweep| sweep.feed).collect());
    let row = |(k, feed): (usize, &f64)| {
        let of_feed: Vec<&Sweep> =
            sweeps.all.iter().filter(|sweep| feed_of(&feeds, sweep.feed) == Some(k)).collect();
        let square = of_feed.iter().map(|sweep| sweep.rms_mm.powi(2)).sum::<f64>() / of_feed.len() as f64;
        vec![Cell::Number(*feed), Cell::Text(of_feed.len().to_string()), Cell::Number(square.sqrt())]
    };
    FoundTable {
        caption: "What the base model leaves at each feed".into(),
        columns: vec![
            Column::of("feed", sweeps.unit),
            Column::plain("sweeps"),
            Column::of("rms residual", Unit::UM),
        ],
        rows: feeds.iter().enumerate().map(row).collect(),
    }
}

/// Errors over the feed, those that change most clearly first.
fn charts(sweeps: &Sweeps, parts: &Parts) -> Vec<Chart> {
    let mut order: Vec<usize> = (0..sweeps.errors.len()).collect();
    order.sort_by(|&a, &b| parts.clearest(b).total_cmp(&parts.clearest(a)));
    let chart = |error: usize| {
        let SplitError { name, unit, .. } = &sweeps.errors[error];
        let ways = [(1.0, "forward"), (-1.0, "backward")];
        let ways = ways.into_iter().filter(|(way, _)| sweeps.all.iter().any(|sweep| sweep.way == *way));
        let curves = ways.flat_map(|(way, words)| {
            let mut of_way: Vec<&Sweep> = sweeps.all.iter().filter(|sweep| sweep.way == way).collect();
            of_way.sort_by(|a, b| a.feed.total_cmp(&b.feed));
            let measured = of_way.iter().map(|sweep| (sweep.feed, sweep.values[error])).collect();
            let by_parts = of_way.iter().map(|sweep| (sweep.feed, parts.at(error, way, sweep.feed)));
            let by_parts = std::iter::once((0.0, parts.at(error, way, 0.0))).chain(by_parts).collect();
            [
                Curve::new(format!("{words}, each sweep"), measured),
                Curve::new(format!("{words}, by its parts"), by_parts),
            ]
        });
        Chart {
            group: "Errors over the feed".into(),
            title: name.clone(),
            plot: Plot::Xy {
                x: AxisName { name: "feed".into(), unit: sweeps.unit },
                y: AxisName { name: name.clone(), unit: *unit },
                curves: curves.collect(),
            },
        }
    };
    order.into_iter().take(DRAWN).map(chart).collect()
}

fn notes(sweeps: &Sweeps, parts: &Parts) -> Vec<String> {
    let significant: Vec<&str> =
        parts.significant().into_iter().map(|error| sweeps.errors[error].name.as_str()).collect();
    let mut notes = vec![match significant.is_empty() {
        true => "No error depends significantly on the feed.".into(),
        false => format!("Depend on the feed (5 % for all of them together): {}.", significant.join(", ")),
    }];
    notes.push(format!(
        "{} sweeps, {} parts: {} degrees of freedom. u is widened by Student's t, so that ± 1.96 u holds 95 %.",
        sweeps.all.len(),
        parts.separated.len(),
        parts.degrees_of_freedom
    ));
    if parts.noise_is_known {
        notes.push(
            "u of a quasi-static part also holds what moves all sweeps together, such as drift.".into(),
        );
    }
    if !parts.both_ways {
        notes.push(
            "One way only: what changes with the direction is in the quasi-static part. Run every feed both ways."
                .into(),
        );
    }
    if !parts.separated.contains(&Part::Acceleration) {
        notes.push("Two feeds one way do not separate speed from acceleration. Add a third feed.".into());
    }
    if sweeps.several_runs {
        notes.push(
            "Settings are not split: between runs the ball may have been mounted again. One run with all feeds shows them.".into(),
        );
    }
    let worst = sweeps.all.iter().max_by(|a, b| a.rms_mm.total_cmp(&b.rms_mm));
    if let Some(worst) = worst {
        notes.push(format!(
            "The base model leaves up to {} rms ({}); where this grows with the feed, `trunnion diagnose` looks for the cause.",
            um(um_from_mm(worst.rms_mm)),
            feed_words(sweeps, worst.feed)
        ));
    }
    if sweeps.left_out > 0 {
        notes.push(format!("Left out: {} readings at no constant feed.", sweeps.left_out));
    }
    notes
}
