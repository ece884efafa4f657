//! What the two-height method reports.

use super::charts::charts;
use super::circle::Circle;
use super::each_run::{self, OfRun, OverRuns};
use super::error_motions::{ErrorMotion, Signs, error_motions};
use super::fit::{HeightFit, Heights};
use crate::common::harmonics::{self, Harmonics};
use crate::common::left_out_notes;
use crate::common::of_few::widening;
use crate::common::turning::Turning;
use crate::findings::{Cell, Column, Findings, FoundTable, FoundValue, ValueKind};
use crate::recipes::{Convention, Method};
use trunnion_core::convert::deg_from_rad;
use trunnion_core::number::fixed;
use trunnion_cycles::Run;
use trunnion_effects::Unit;

pub(super) fn findings(
    method: &Method,
    turning: &Turning,
    heights: &Heights,
    each: &[OfRun],
    u_under_noise: Option<&[f64]>,
    runs: &[Run],
    convention: Convention,
) -> Findings {
    let signs = Signs::of(convention);
    let located: Vec<Vec<FoundValue>> =
        each.iter().map(|run| location(turning, &run.heights, &signs)).collect();
    let over_runs = OverRuns::all(&located);
    let by_passes = of_few_passes(location(turning, heights, &signs), heights);
    let value = |(k, common): (usize, FoundValue)| match over_runs.get(k).filter(|of_runs| of_runs.differs())
    {
        // What the runs differ by is in the noise that they show together: it would count twice.
        Some(of_runs) => of_runs.widened(common),
        None => FoundValue { u: u_under_noise.map(|u| u[k]).or(common.u), ..common },
    };
    let mut values: Vec<FoundValue> = by_passes.into_iter().enumerate().map(value).collect();
    values.extend(settings(turning, heights));
    let motions = error_motions(turning, heights, &signs);
    // They are judged together, so 5 % is the chance that noise makes any of them significant.
    let around = |motion: &ErrorMotion| Harmonics::among(&motion.points, motions.len());
    let judged: Vec<(&ErrorMotion, Option<Harmonics>)> =
        motions.iter().map(|motion| (motion, around(motion))).collect();
    values.extend(judged.iter().flat_map(|(motion, of)| of_motion(motion, of.as_ref())));
    let listed =
        |(motion, of): (&ErrorMotion, Option<Harmonics>)| Some((motion.name.clone(), motion.unit, of?));
    let harmonics: Vec<_> = judged.into_iter().filter_map(listed).collect();
    Findings {
        values,
        tables: each_run::tables(each, &located)
            .into_iter()
            .chain([passes(turning, heights)])
            .chain(harmonics::table(&harmonics))
            .collect(),
        charts: each_run::overlay(turning, each)
            .into_iter()
            .chain(charts(turning, heights, &signs))
            .collect(),
        notes: each_run::doubt(&located)
            .into_iter()
            .chain(notes(turning, heights, u_under_noise.is_some()))
            .collect(),
        ..method.findings(runs, convention)
    }
}

/// Location errors of the axis average line.
fn location(turning: &Turning, heights: &Heights, signs: &Signs) -> Vec<FoundValue> {
    let [u, v] = heights.centre;
    let [u_name, v_name, _] = turning.frame;
    let [tilt_u, tilt_v, _] = turning.rotations();
    let value = |direction, value: f64, unit, u| {
        let found = FoundValue::new(turning.symbol(direction, true), value, unit, Some(u));
        if unit == Unit::URAD { found.note(format!("{}°", fixed(deg_from_rad(value), 5))) } else { found }
    };
    vec![
        value(tilt_u, -v.slope * signs.tilt_u_of_line, Unit::URAD, v.u_slope),
        value(tilt_v, u.slope, Unit::URAD, u.u_slope),
        value(u_name, u.at_zero, Unit::UM, u.u_at_zero),
        value(v_name, v.at_zero, Unit::UM, v.u_at_zero),
    ]
}

/// u widened by Student's t, so that ± 1.96 u holds 95 %: it is by the scatter of a few passes. Of each run by itself it is not, for runs are
/// compared by the root mean square of all their u (`each_run`).
fn of_few_passes(location: Vec<FoundValue>, heights: &Heights) -> Vec<FoundValue> {
    let Some([[u_at_zero, u_slope], [v_at_zero, v_slope]]) = heights.freedom else { return location };
    let widened = |(found, freedom): (FoundValue, usize)| {
        let u = found.u.map(|u| u * widening(freedom));
        FoundValue { u, ..found }
    };
    location.into_iter().zip([v_slope, u_slope, u_at_zero, v_at_zero]).map(widened).collect()
}

fn settings(turning: &Turning, heights: &Heights) -> Vec<FoundValue> {
    let of_set = |set: &HeightFit| {
        [0, 1].map(|k| {
            let name = format!("setting.{}.{}", set.name, turning.frame[k].lower());
            let value = FoundValue::new(name, set.all.setting_mm[k], Unit::UM, Some(set.u.setting_mm[k]));
            value.kind(ValueKind::Setting)
        })
    };
    heights.sets.iter().flat_map(of_set).collect()
}

/// Range and rms of an error motion: the range without the bias of noise where the axis goes around, else as read.
fn of_motion(motion: &ErrorMotion, around: Option<&Harmonics>) -> Vec<FoundValue> {
    let ErrorMotion { name, unit, points, u } = motion;
    let numbers = || points.iter().map(|(_, value)| *value);
    let (low, high) = numbers().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let rms = (numbers().map(|v| v * v).sum::<f64>() / points.len().max(1) as f64).sqrt();
    if points.is_empty() {
        return Vec::new();
    }
    let scale = unit.per_inside;
    let point = u.map_or(String::new(), |u| format!("; u of one angle {:.3} {}", u * scale, unit.text()));
    let range = match around {
        Some(of) => {
            let value = of.range_value(name, *unit);
            let as_read = (high - low) * scale;
            let note = format!("{}; as read {as_read:.2} {}, noise included{point}", value.note, unit.text());
            value.note(note)
        }
        // The ends of a range are two values.
        None => FoundValue::new(
            format!("{name} range"),
            high - low,
            *unit,
            u.map(|u| u * std::f64::consts::SQRT_2),
        )
        .note(format!("as read, noise included{point}")),
    };
    vec![range, FoundValue::new(format!("{name} rms"), rms, *unit, None)]
}

/// Setting and centre of each pass: what repeats, and what the direction changes.
fn passes(turning: &Turning, heights: &Heights) -> FoundTable {
    let [u, v, _] = turning.frame;
    let mut columns = vec![Column::plain("setup"), Column::of("height", Unit::MM), Column::plain("pass")];
    columns.extend(
        [format!("centre {u}"), format!("centre {v}"), format!("setting {u}"), format!("setting {v}")]
            .map(|name| Column::of(name, Unit::UM)),
    );
    let mut rows = Vec::new();
    for set in &heights.sets {
        let row = |name: String, circle: &Circle| {
            let mut row = vec![Cell::Text(set.name.clone()), Cell::Number(set.height_mm), Cell::Text(name)];
            row.extend(
                [circle.centre_mm, circle.setting_mm].iter().flat_map(|v| [v.x, v.y]).map(Cell::Number),
            );
            row
        };
        for (i, (direction, circle)) in set.passes.iter().enumerate() {
            let way = if *direction < 0.0 { "back" } else { "forward" };
            rows.push(row(format!("{} {way}", i + 1), circle));
        }
        rows.push(row("all".into(), &set.all));
        rows.push(row(if set.repeated { "u, by the passes" } else { "u, by the residual" }.into(), &set.u));
    }
    FoundTable { caption: "Centre and setting of each pass".into(), columns, rows }
}

fn notes(turning: &Turning, heights: &Heights, noise_is_known: bool) -> Vec<String> {
    let axis = turning.axis;
    let places: Vec<_> =
        heights.sets.iter().map(|s| format!("{} {} mm", s.name, fixed(s.height_mm, 1))).collect();
    let mut notes = vec![format!(
        "Axis {axis} turns alone; heights of the ball along it: {}. Positioning error E{}{axis} is not observable with the ball on the axis.",
        places.join(", "),
        turning.rotations()[2]
    )];
    let others = trunnion_core::Joint::ROTARY
        .into_iter()
        .filter(|&letter| letter != axis && turning.sets[0].position[letter] != 0.0)
        .map(|letter| format!("{letter} = {}°", fixed(deg_from_rad(turning.sets[0].position[letter]), 4)));
    let others: Vec<_> = others.collect();
    let at = if others.is_empty() { String::new() } else { format!(" at {}", others.join(", ")) };
    notes.push(format!(
        "Location errors hold{at} where the linear axes stood: errors of what carries {axis} and of the linear axes there are part of them."
    ));
    if !turning.whole_turn() {
        notes.push(format!(
            "{axis} did not go around: slow error motions and the setting are separated less well than over a whole turn."
        ));
    }
    notes.push(
        match (noise_is_known, heights.sets.iter().all(|set| set.repeated)) {
            (true, _) => {
                "Uncertainties of location errors hold drift, and steps from pass to pass and height to height. Where no reading shows these, they \
                 hold what is usual for machines. What all readings of the run share, such as a drift that is slower, is in none."
            }
            (false, true) => {
                "Uncertainties hold what changes from pass to pass, widened by Student's t for few passes; a slow drift from one height to the next is not in them."
            }
            (false, false) => "A slow drift from one height to the next is in no uncertainty.",
        }
        .into(),
    );
    if heights.sets.iter().any(|set| !set.repeated) {
        notes.push(
            "A height has a single pass: its uncertainties come from the residual, which holds the error motions too; \
             the error motions have none. Turn twice both ways."
                .into(),
        );
    }
    notes.extend(left_out_notes(&turning.left_out));
    notes
}
