//! The values of ISO 230-2, a table of the targets, and their chart.

use super::targets::{Approaches, Target, Trace, Traces};
use crate::common::left_out_notes;
use crate::findings::ValueKind::{Error, Part, Summary};
use crate::findings::{
    AxisName, Cell, Chart, Column, Curve, Findings, FoundTable, FoundValue, Plot, ValueKind,
};
use crate::recipes::{Convention, Method};
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::Run;
use trunnion_effects::Unit;

/// Names of the ways.
const WAYS: [&str; 2] = ["↑", "↓"];

/// A number with its variance.
type Known = (f64, f64);

pub(super) fn findings(method: &Method, runs: &[Run], traces: &Traces) -> Findings {
    let mut notes = vec![
        "Extended by twice the standard deviation, as ISO 230-2 asks. Air, material temperature and the alignment of the beam are in no value.".to_string(),
    ];
    let few =
        |trace: &&Trace| trace.targets.iter().flat_map(|t| t.ways.iter()).flatten().any(|way| way.count < 5);
    notes.extend(
        traces
            .all
            .iter()
            .filter(few)
            .map(|t| format!("{}: ISO 230-2 asks for five approaches from each side.", t.name)),
    );
    notes.extend(traces.all.iter().filter(|trace| trace.unknown > 0).map(unknown_note));
    notes.extend(traces.all.iter().filter_map(one_sided_note));
    notes.extend(left_out_notes(&traces.left_out));
    Findings {
        values: traces.all.iter().flat_map(values).collect(),
        tables: traces.all.iter().map(table).collect(),
        charts: traces.all.iter().map(chart).collect(),
        notes,
        ..method.findings(runs, Convention::RightHanded)
    }
}

fn unknown_note(trace: &Trace) -> String {
    format!(
        "{}: {} readings were left out, because the direction of their approach is not known: the first, or the axis had not moved since the \
         reading before. State the direction, or overrun the end targets.",
        trace.name, trace.unknown
    )
}

/// Which targets have no reversal value, where others have one.
fn one_sided_note(trace: &Trace) -> Option<String> {
    let both = trace.targets.iter().filter(|target| reversal(target).is_some()).count();
    let lacks = |target: &&Target| reversal(target).is_none();
    let places: Vec<String> =
        trace.targets.iter().filter(lacks).map(|target| format!("{:.1}", target.position_mm)).collect();
    (both > 0 && !places.is_empty()).then(|| {
        format!(
            "{}: approached twice or more from one side alone: {} mm. B, R and M are those of the other {both} of {} targets. ISO 230-2 asks for an overrun at the end targets.",
            trace.name,
            places.join(", "),
            trace.targets.len()
        )
    })
}

fn values(trace: &Trace) -> Vec<FoundValue> {
    let mut values = Vec::new();
    let mut value = |name: &str, known: Option<Known>, kind: ValueKind, note: &str| {
        if let Some((value, variance)) = known {
            let name = format!("{} {name}", trace.name);
            values.push(FoundValue::new(name, value, Unit::UM, Some(variance.sqrt())).kind(kind).note(note));
        }
    };
    let of_way = |way: usize| -> Vec<Approaches> {
        trace.targets.iter().filter_map(|target| target.ways[way]).collect()
    };
    let [up, down] = [0, 1].map(of_way);
    let both: Vec<Approaches> = up.iter().chain(&down).copied().collect();
    let two_sided = !up.is_empty() && !down.is_empty();
    if two_sided {
        let reversals: Vec<Known> = trace.targets.iter().filter_map(reversal).collect();
        let largest = reversals.iter().copied().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        value("A", range(&both, 2.0), Summary, "accuracy, both directions");
        value(
            "R",
            largest_of(trace.targets.iter().filter_map(repeatability)),
            Summary,
            "repeatability, both directions",
        );
        value("E", range(&both, 0.0), Summary, "systematic deviation, both directions");
        value("M", means_range(&trace.targets), Summary, "range of the mean deviations of both directions");
        let size = largest.map(|(b, variance)| (b.abs(), variance));
        value("B", size, Summary, "largest reversal value, without sign");
        let count = reversals.len().max(1) as f64;
        let mean =
            reversals.iter().fold((0.0, 0.0), |sum, b| (sum.0 + b.0 / count, sum.1 + b.1 / count.powi(2)));
        value("mean reversal", Some(mean), Error, "mean of x̄↑ − x̄↓: negative where the axis stops short");
    }
    for (way, arrow) in [&up, &down].into_iter().zip(WAYS).filter(|(way, _)| !way.is_empty()) {
        let alone = |what: &str| format!("{what}, {arrow} alone");
        let kind = if two_sided { Part } else { Summary };
        let own = way.iter().map(|a| (4.0 * a.s, 16.0 * a.s_variance()));
        value(&format!("A{arrow}"), range(way, 2.0), kind, &alone("accuracy"));
        value(&format!("R{arrow}"), largest_of(own), kind, &alone("repeatability"));
        value(&format!("E{arrow}"), range(way, 0.0), kind, &alone("systematic deviation"));
    }
    values
}

/// B_i.
fn reversal(target: &Target) -> Option<Known> {
    let [up, down] = [target.ways[0]?, target.ways[1]?];
    Some((up.mean - down.mean, up.mean_variance() + down.mean_variance()))
}

/// R_i.
fn repeatability(target: &Target) -> Option<Known> {
    let [up, down] = [target.ways[0]?, target.ways[1]?];
    let (b, b_variance) = reversal(target)?;
    let across = (2.0 * (up.s + down.s) + b.abs(), 4.0 * (up.s_variance() + down.s_variance()) + b_variance);
    largest_of(
        [across, (4.0 * up.s, 16.0 * up.s_variance()), (4.0 * down.s, 16.0 * down.s_variance())].into_iter(),
    )
}

fn largest_of(all: impl Iterator<Item = Known>) -> Option<Known> {
    all.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// max(x̄ + k s) − min(x̄ − k s).
fn range(all: &[Approaches], k: f64) -> Option<Known> {
    let end = |sign: f64| {
        let ends = all.iter().map(|a| (a.mean + sign * k * a.s, a.mean_variance() + k * k * a.s_variance()));
        ends.max_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0)))
    };
    let (high, low) = (end(1.0)?, end(-1.0)?);
    Some((high.0 - low.0, high.1 + low.1))
}

/// M.
fn means_range(targets: &[Target]) -> Option<Known> {
    let mean = |target: &Target| {
        let [up, down] = [target.ways[0]?, target.ways[1]?];
        Some((0.5 * (up.mean + down.mean), 0.25 * (up.mean_variance() + down.mean_variance())))
    };
    let means: Vec<Known> = targets.iter().filter_map(mean).collect();
    let high = largest_of(means.iter().copied())?;
    let low = largest_of(means.iter().map(|m| (-m.0, m.1)))?;
    Some((high.0 + low.0, high.1 + low.1))
}

fn table(trace: &Trace) -> FoundTable {
    let mut columns = vec![Column::of("target", Unit::MM)];
    for arrow in WAYS {
        columns.push(Column::plain(format!("approaches {arrow}")));
        columns
            .extend([format!("mean {arrow}"), format!("s {arrow}")].map(|name| Column::of(name, Unit::UM)));
    }
    columns.push(Column::of("reversal", Unit::UM));
    let zero = zero(trace);
    let row = |target: &Target| {
        let mut row = vec![Cell::Number(target.position_mm)];
        for way in &target.ways {
            row.extend(match way {
                Some(a) => [Cell::Text(a.count.to_string()), Cell::Number(a.mean - zero), Cell::Number(a.s)],
                None => [Cell::Missing, Cell::Missing, Cell::Missing],
            });
        }
        row.push(reversal(target).map_or(Cell::Missing, |b| Cell::Number(b.0)));
        row
    };
    FoundTable {
        caption: format!("Deviations of {} from the first mean", trace.name),
        columns,
        rows: trace.targets.iter().map(row).collect(),
    }
}

/// The first mean: the display of a laser may be zeroed anywhere.
fn zero(trace: &Trace) -> f64 {
    trace.targets.iter().flat_map(|target| target.ways).flatten().next().map_or(0.0, |first| first.mean)
}

fn chart(trace: &Trace) -> Chart {
    let zero = zero(trace);
    let curve = |name: &str, of: &dyn Fn(&Target) -> Option<f64>| {
        let points = trace.targets.iter().filter_map(|t| Some((t.position_mm, of(t)? - zero)));
        Curve::new(name, points.collect())
    };
    let end = |sign: f64| {
        move |target: &Target| {
            let ends = target.ways.iter().flatten().map(|a| sign * (a.mean + sign * 2.0 * a.s));
            ends.max_by(f64::total_cmp).map(|end| sign * end)
        }
    };
    let curves = vec![
        curve("mean ↑", &|target| target.ways[0].map(|a| a.mean)),
        curve("mean ↓", &|target| target.ways[1].map(|a| a.mean)),
        curve("mean + 2 s", &end(1.0)),
        curve("mean − 2 s", &end(-1.0)),
    ];
    let mm = |name: &str, unit| AxisName { name: name.into(), unit };
    Chart {
        group: "Positioning".into(),
        title: format!(
            "Deviation of {}: {:.1} µm with repeatability",
            trace.name,
            um_from_mm(
                range(&trace.targets.iter().flat_map(|t| t.ways).flatten().collect::<Vec<_>>(), 2.0)
                    .map_or(0.0, |a| a.0)
            )
        ),
        plot: Plot::Xy { x: mm(&trace.name, Unit::MM), y: mm("", Unit::UM), curves },
    }
}
