//! What the ball-bar method reports.

use super::causes::{Counts, ErrorKind, causes, of_motion, of_number};
use super::charts::charts;
use super::dependence::{self, dependences, is_compared};
use super::error_motions::{ErrorMotion, error_motions};
use super::found::Found;
use super::location::Location;
use super::ranking::{Row, ranked};
use super::shape::{AxisShapes, Shape, is_same_angle};
use super::track::{Axis, Kind, span};
use crate::common::harmonics::{self, Harmonics};
use crate::common::left_out_notes;
use crate::findings::{Cell, Column, Findings, FoundTable, FoundValue};
use crate::recipes::{Convention, Method};
use std::f64::consts::TAU;
use trunnion_core::convert::{deg_from_rad, um_from_mm};
use trunnion_core::number::{fixed, signed};
use trunnion_core::{AxisValues, Joint};
use trunnion_cycles::Run;
use trunnion_effects::Unit;

pub(super) fn findings(method: &Method, runs: &[Run], found: &Found<'_>, convention: Convention) -> Findings {
    let motions: Vec<ErrorMotion> = found.axes.iter().flat_map(error_motions).collect();
    let quantities = quantities(found, motions.len());
    let of_location = |of: &Location| location(of, convention, quantities);
    let mut values: Vec<FoundValue> = found.location.iter().map(of_location).collect();
    let mut of_motions = Vec::new();
    let (dependences, mut waves) = (dependences(found.shapes, quantities), Vec::new());
    let counts = |axis: Axis| runs.first().map_or_else(Counts::default, |run| Counts::of(&run.machine, axis));
    for motion in motions {
        let as_read = span(motion.points.iter().map(|(_, value)| *value));
        let counted = counts(motion.axis);
        values.push(match Harmonics::with(&motion.points, &counted.orders(), quantities) {
            Some(of) => {
                let scale = motion.unit.per_inside;
                let read = format!("as read {:.2} {}, noise included", as_read * scale, motion.unit.text());
                let likely = of_motion(motion.kind, motion.upright, counted, &of);
                let causes = causes(motion.kind, motion.upright, counted, &of);
                let row = |cause| Row::of_wave(&motion.name, motion.axis, motion.kind, cause, &dependences);
                waves.extend(causes.iter().map(row));
                let value = of.range_value(&motion.name, motion.unit);
                let note = said(&[&motion.about, &value.note, &read, &likely]);
                let value = value.note(note);
                of_motions.push((motion.name, motion.unit, of));
                value
            }
            None => FoundValue::new(format!("{} range", motion.name), as_read, motion.unit, None)
                .note(said(&[&motion.about, "as read, noise included"])),
        });
    }
    for shape in found.shapes {
        let value =
            FoundValue::new(format!("{} circularity", shape.label), shape.circularity_mm, Unit::UM, None);
        let orders = shape.kind.axis().map_or_else(Vec::new, |axis| counts(axis).orders());
        let around = Harmonics::with(&shape.mean_contour, &orders, quantities);
        let likely = match (shape.kind, &around) {
            (Kind::Across { axis, .. }, Some(of)) => {
                of_motion(ErrorKind::Radial, axis.is_upright(), counts(axis), of)
            }
            (Kind::Along { axis }, Some(of)) => {
                of_motion(ErrorKind::Axial, axis.is_upright(), counts(axis), of)
            }
            (Kind::Followed { .. } | Kind::Path, _) => PATH.into(),
            _ => String::new(),
        };
        let words = around.map_or(String::new(), |of| of.words(Unit::UM));
        values.push(value.note(said(&["range as read", &words, &likely])));
        if let Some(reversal_mm) = shape.reversal_mm {
            // Half of the readings make each mean, all of them the one with u_mean.
            let u = 2.0 * shape.u_mean_mm;
            let value = FoundValue::new(format!("{} reversal", shape.label), reversal_mm, Unit::UM, Some(u));
            let likely = of_number(ErrorKind::Reversal, reversal_mm, u, quantities);
            values.push(value.note(said(&["forward less backward", likely])));
        }
    }
    let mut tables: Vec<FoundTable> = ranked(found, waves, &dependences, quantities).into_iter().collect();
    tables.push(measurements(found.shapes));
    tables.extend(harmonics::table(&of_motions));
    if !found.location.is_empty() {
        tables.push(comparison(found, convention));
    }
    Findings {
        values,
        tables,
        charts: charts(found),
        notes: notes(found),
        ..method.findings(runs, convention)
    }
}

/// An axis that went so many turns one way came by most of its angles again.
const SECOND_TURN: f64 = 1.5;

/// What several axes at once show.
const PATH: &str = "several axes at once: location errors, positioning (encoder, worm pitch, compensation table), drives out of step, too short \
                    blocks (S4 table 2, §4.4)";

/// Those that say something, one after the other.
fn said(words: &[&str]) -> String {
    words.iter().filter(|words| !words.is_empty()).copied().collect::<Vec<_>>().join("; ")
}

/// Of how many something may be said to be significant, so that 5 % is the chance that noise makes any of them so: location errors, error motions,
/// traces, steps with the direction, and what traces are compared in.
fn quantities(found: &Found<'_>, motions: usize) -> usize {
    let steps = found.shapes.iter().filter(|shape| shape.reversal_mm.is_some()).count();
    found.location.len() + motions + found.shapes.len() + steps + dependence::count(found.shapes)
}

fn location(location: &Location, convention: Convention, quantities: usize) -> FoundValue {
    let value = location.shown(convention);
    let found = FoundValue::new(&*location.name, value, location.unit, Some(location.u));
    let words = of_number(location.kind, location.value, location.u, quantities);
    if location.unit == Unit::URAD {
        let per_100_mm = format!("{} µm/100 mm", signed(um_from_mm(value * 100.0), 1));
        found.note(said(&[&per_100_mm, words]))
    } else {
        found.note(words)
    }
}

/// Circularity and mean radial error of every measurement, like S4 tables 3 and 4.
fn measurements(shapes: &[Shape]) -> FoundTable {
    let columns = vec![
        Column::plain("measurement"),
        Column::plain("setup"),
        Column::of("turned", Unit::DEG),
        Column::of("height or radius", Unit::MM),
        Column::of("circularity", Unit::UM),
        Column::of("mean radial error", Unit::UM),
        Column::of("u of the mean", Unit::UM),
        Column::of("centre 1", Unit::UM),
        Column::of("centre 2", Unit::UM),
    ];
    let row = |shape: &Shape| {
        let place = match shape.kind {
            Kind::Across { height_mm, .. } => Some(height_mm),
            Kind::Followed { radius_mm, .. } => Some(radius_mm),
            Kind::Along { .. } | Kind::Path => None,
        };
        // S4 eq. 4–5: C_x = E_v0 R, C_y = −E_u0 R.
        let centre = match shape.kind {
            Kind::Across { .. } => Some([shape.centre.x, shape.centre.y]),
            Kind::Followed { radius_mm, .. } => {
                Some([shape.centre.y * radius_mm, -shape.centre.x * radius_mm])
            }
            Kind::Along { .. } | Kind::Path => None,
        };
        let cell = |value: Option<f64>| value.map_or(Cell::Missing, Cell::Number);
        let mean = shape.calibrated.then_some(shape.mean_reading_mm);
        vec![
            Cell::Text(shape.label.clone()),
            Cell::Text(shape.setup.clone()),
            Cell::Number(shape.turned_rad),
            cell(place),
            Cell::Number(shape.circularity_mm),
            cell(mean),
            cell(mean.map(|_| shape.u_mean_mm)),
            cell(centre.map(|c| c[0])),
            cell(centre.map(|c| c[1])),
        ]
    };
    let caption = "Measurements: circularity about the centre, and mean radial error (S4 tables 3–4)".into();
    FoundTable { caption, columns, rows: shapes.iter().map(row).collect() }
}

/// Location errors by the recipe and by the joint fit of the same readings.
fn comparison(found: &Found<'_>, convention: Convention) -> FoundTable {
    let heads = ["by the recipe", "u", "by the joint fit"];
    let mut columns = vec![Column::plain("location error"), Column::plain("unit")];
    columns.extend(heads.map(Column::plain));
    let row = |location: &Location| {
        let scale = location.unit.per_inside;
        let shown = location.shown(convention) * scale;
        let joint = found.by_joint_fit.iter().find(|other| other.name == location.name);
        let joint = joint.map(|other| other.shown(convention) * scale);
        let cell = |value: Option<f64>| value.map_or(Cell::Missing, Cell::Number);
        vec![
            Cell::Text(location.name.clone()),
            Cell::Text(location.unit.text()),
            Cell::Number(shown),
            Cell::Number(location.u * scale),
            cell(joint),
        ]
    };
    FoundTable {
        caption: "Location errors by the recipe and by the joint fit of the same readings".into(),
        columns,
        rows: found.location.iter().map(row).collect(),
    }
}

/// Where the axes stood that stand elsewhere in other traces, `B = 0°`.
fn stand(stood_rad: &AxisValues<f64>, others: &[&AxisValues<f64>]) -> String {
    let differs = |joint: &Joint| others.iter().any(|other| !is_same_angle(other[*joint], stood_rad[*joint]));
    let words = |joint: Joint| format!("{joint} = {}°", fixed(deg_from_rad(stood_rad[joint]), 0));
    Joint::ROTARY.into_iter().filter(differs).map(words).collect::<Vec<_>>().join(", ")
}

/// Which traces of an axis its location errors and error motions are by, where other axes stood at several places.
fn stands(of_axis: &AxisShapes, shapes: &[Shape]) -> Vec<String> {
    let (letter, mut notes) = (of_axis.axis.letter, Vec::new());
    let further: Vec<&Shape> =
        shapes.iter().filter(|shape| of_axis.elsewhere.contains(&shape.label)).collect();
    let axial = of_axis.axial_elsewhere.as_ref();
    let others: Vec<&AxisValues<f64>> =
        further.iter().map(|shape| &shape.stood_rad).chain(axial.map(|(_, stood_rad)| stood_rad)).collect();
    if others.is_empty() {
        return notes;
    }
    notes.push(format!(
        "Location errors and error motions of {letter} are by the traces at {} alone{}.",
        stand(&of_axis.stood_rad, &others),
        axial.map_or_else(String::new, |(label, stood_rad)| {
            format!("; its axial error motion is by {label} at {}", stand(stood_rad, &[&of_axis.stood_rad]))
        })
    ));
    let listed = |compared: bool| {
        let wanted = further.iter().filter(|shape| is_compared(shape, shapes) == compared);
        let labels: Vec<&str> = wanted.map(|shape| shape.label.as_str()).collect();
        (!labels.is_empty()).then(|| labels.join(", "))
    };
    notes.extend(listed(true).map(|labels| format!("Only compared with other traces: {labels}.")));
    notes.extend(listed(false).map(|labels| {
        format!(
            "Not used for {letter}, because no other trace differs from them in one thing alone: {labels}."
        )
    }));
    notes
}

/// What of drift the uncertainties of location errors hold.
fn drift(found: &Found<'_>) -> Option<String> {
    let once = |shape: &&Shape| shape.contours.len() < 2 && shape.turned_rad < SECOND_TURN * TAU;
    let once = found.shapes.iter().filter(once).count();
    let words = match (found.location.is_empty(), found.noise_is_known) {
        (true, _) => return None,
        (false, false) => {
            "The readings do not show how the machine drifts. Uncertainties of location errors hold no drift from one setup to the next."
                .into()
        }
        (false, true) if once > 0 => format!(
            "Drift between setups is not seen: {once} of {} setups were read in one sweep. Uncertainties of location errors hold the drift and the \
             steps that are usual for machines. Read each setup several times, both ways, to measure them.",
            found.shapes.len()
        ),
        (false, true) => {
            "Uncertainties of location errors hold drift, and steps from sweep to sweep and setup to setup, as the readings show them.".into()
        }
    };
    Some(words)
}

fn notes(found: &Found<'_>) -> Vec<String> {
    let mut notes = vec![
        "Each trace is centred: a shape that turns once with the axis counts as setting of the ball. Uncertainties of its mean and its \
         circle come from what the centring leaves, shape included."
            .to_string(),
    ];
    notes.extend(drift(found));
    if !found.axes.is_empty() {
        notes.push("Location errors hold where the other axes stood: errors of what carries the axis are part of them.".into());
    }
    for of_axis in found.axes {
        let letter = of_axis.axis.letter;
        notes.extend(stands(of_axis, found.shapes));
        if !of_axis.calibrated {
            notes.push(format!(
                "A bar across {letter} has no calibrated length: the place of its line is not known; its tilt is, if the bar was the same at both heights."
            ));
        }
        if of_axis.line.iter().all(Option::is_none) && of_axis.radial_at_mm.iter().any(Option::is_some) {
            notes.push(format!("{letter} was read at one height: its tilt and the place of its line at other heights are not known. Measure a second height."));
        }
    }
    let short = |shape: &&Shape| shape.kind != Kind::Path && shape.turned_rad < 0.9 * TAU;
    let short: Vec<String> = found
        .shapes
        .iter()
        .filter(short)
        .map(|shape| format!("{} {:.0}°", shape.label, deg_from_rad(shape.turned_rad)))
        .collect();
    if !short.is_empty() {
        notes.push(format!(
            "Turned less than once around ({}): mean, setting and slow shapes are separated less well.",
            short.join(", ")
        ));
    }
    for shape in found.shapes {
        if matches!(shape.kind, Kind::Followed { .. }) {
            notes.push(format!(
                "{} reads the axis against the motion of the linear axes: their squareness and straightness are in it (S4 §4.2.3).",
                shape.label
            ));
        }
    }
    notes.extend(left_out_notes(&found.tracks.left_out));
    notes
}
