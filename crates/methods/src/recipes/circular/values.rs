//! What the circular method reports.

use super::charts::charts;
use super::confounded::{Other, Seen, Together};
use super::fit::{Fitted, FittedError};
use super::list::ListedKind;
use super::planes::together;
use super::to_do::to_do;
use super::trace::{Speed, Trace, Traces};
use crate::common::left_out_notes;
use crate::common::rounding::without;
use crate::findings::{Cell, Column, Findings, FoundTable, FoundValue, ValueKind};
use crate::recipes::{Convention, Method};
use std::cmp::Ordering::Equal;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::{plain, signed, um_or_less};
use trunnion_cycles::Run;
use trunnion_effects::Unit;
use trunnion_machine::Machine;

/// Causes shown for one error of the list, those that may move it most; a page has no room for more.
const SHOWN_CAUSES: usize = 3;

pub(super) fn findings(
    method: &Method,
    machine: &Machine,
    runs: &[Run],
    traces: &Traces,
    fits: &[Fitted<'_>],
) -> Findings {
    let mut values: Vec<FoundValue> = fits.iter().flat_map(of_plane).collect();
    let common = together(fits);
    values.extend(common.iter().map(|found| {
        let disagreement = found.disagreement * found.unit.per_inside;
        let note = format!(
            "all planes together ({} of them see it); they disagree by up to {} {}",
            found.planes,
            plain(disagreement),
            found.unit.text()
        );
        FoundValue::new(format!("{} of all planes", found.name), found.value, found.unit, Some(found.u))
            .note(note)
    }));
    Findings {
        values,
        tables: fits.iter().map(ranking).chain(fits.iter().filter_map(doubts)).collect(),
        charts: fits.iter().flat_map(charts).collect(),
        notes: notes(machine, traces, fits),
        to_do: to_do(fits),
        ..method.findings(runs, Convention::RightHanded)
    }
}

fn of_plane(fit: &Fitted<'_>) -> Vec<FoundValue> {
    let plane = &fit.trace.name;
    let mut values = Vec::new();
    // ISO 230-4 knows whole circles.
    let of_arc = fit.trace.arc_rad.map_or(String::new(), |arc| {
        format!(", of an arc of {:.0}° alone: not of the circle", arc.to_degrees())
    });
    let mut iso = |name: &str, value: f64, kind: ValueKind, note: &str| {
        let note = format!("{note}{of_arc}");
        values.push(FoundValue::new(format!("{plane} {name}"), value, Unit::UM, None).note(note).kind(kind));
    };
    // Of both directions G(b) is what the measurement comes to, of one its G.
    let of_one_way = if fit.iso.g_b_mm.is_some() { ValueKind::Error } else { ValueKind::Summary };
    for (way, g_mm) in &fit.iso.g_mm {
        let (sign, words) = if *way < 0.0 { ("−", "clockwise") } else { ("+", "counter-clockwise") };
        let note = format!("circle in {plane}, out of round {words} (circular deviation)");
        iso(&format!("G({sign})"), *g_mm, of_one_way, &note);
    }
    if let Some(g_b_mm) = fit.iso.g_b_mm {
        let note =
            format!("circle in {plane}, out of round both ways together (bidirectional circular deviation)");
        iso("G(b)", g_b_mm, ValueKind::Summary, &note);
    }
    if let Some(d_mm) = fit.iso.d_mm {
        iso("D", d_mm, ValueKind::Error, "mean bidirectional radial deviation");
    }
    if let Some([high, low]) = fit.iso.f_mm {
        iso("F max", high, ValueKind::Error, "radial deviation, largest");
        iso("F min", low, ValueKind::Error, "radial deviation, smallest");
    }
    let share = fit.unexplained();
    let verdict = if fit.leaves_more_than_noise() {
        "more than noise: something is not on the list"
    } else {
        "no more than the noise of the readings"
    };
    let shown = match &strongest(fit)[..] {
        [] => String::new(),
        names => format!(", but {} shows in it", names.join(" or ")),
    };
    let note = format!(
        "{:.1} % of the variance of the trace is left by the whole list, {} rms of {}; noise of the readings {}; {verdict}{shown}",
        100.0 * share,
        um_or_less(um_from_mm(fit.left_rms_mm)),
        um_or_less(um_from_mm(fit.centred_rms_mm)),
        um_or_less(um_from_mm(fit.noise_mm))
    );
    values.push(FoundValue::new(format!("{plane} unexplained share"), share, Unit::ONE, None).note(note));
    let beyond_mm = fit.unexplained_beyond_noise_mm();
    let value = FoundValue::new(format!("{plane} unexplained beyond noise"), beyond_mm, Unit::UM, None);
    values.push(value.note("rms of what neither the list nor the noise of the readings explains"));
    let value =
        FoundValue::new(format!("{plane} unexplained circularity"), fit.left_circularity_mm, Unit::UM, None);
    values.push(value.note("range of the residual, noise included"));
    for error in &fit.errors {
        let name = format!("{plane} {}", error.listed.name);
        let value = FoundValue::new(name, error.value, error.listed.unit, Some(error.u));
        let circularity_um = um_from_mm(error.circularity_mm);
        let doubt = if error.significant() { "" } else { "; below twice its uncertainty" };
        let doubt = format!("{doubt}{}", confounded_with(fit, error));
        values.push(value.note(format!(
            "makes {}; {}{doubt}",
            um_or_less(circularity_um),
            error.listed.about
        )));
    }
    values
}

/// The cause that stands out most of those that are not on the list, with those that leave the same and so are not separated from it;
/// nothing where none stands out.
fn strongest(fit: &Fitted<'_>) -> Vec<String> {
    let in_u = |other: &Other| {
        let seen = other.seen.as_ref().filter(|seen| seen.significant)?;
        Some(seen.amount.abs() / seen.u.max(f64::MIN_POSITIVE))
    };
    let most = fit.others().filter(|other| in_u(other).is_some());
    let most = most.max_by(|a, b| in_u(a).partial_cmp(&in_u(b)).unwrap_or(Equal));
    let same = |other: &&Other| most.is_some_and(|most| other.leaves_the_same_as(most));
    fit.others().filter(same).map(Other::words).collect()
}

/// What reads as this error and leaves nothing that shows it, as a remark.
fn confounded_with(fit: &Fitted<'_>, error: &FittedError) -> String {
    let mut names = Vec::new();
    for other in fit.others().filter(|other| other.seen.is_none()) {
        // The error that takes up most of the cause.
        let takes_mm = |error: &FittedError| {
            let of_one = error.circularity_mm / error.value.abs().max(f64::MIN_POSITIVE);
            error.columns.clone().map(|k| other.moves[k].abs()).fold(0.0, f64::max) * of_one
        };
        let most = fit.errors.iter().max_by(|a, b| takes_mm(a).total_cmp(&takes_mm(b)));
        if most.is_some_and(|most| most.columns == error.columns) {
            names.push(other.words());
        }
    }
    let of_error = |group: &&Together| error.columns.clone().any(|k| group.moved[k]);
    names.extend(
        fit.together.iter().filter(of_error).map(|group| format!("{} together", group.names.join(", "))),
    );
    if names.is_empty() { String::new() } else { format!("; confounded with {}", names.join("; ")) }
}

/// What the readings bound of causes that read as errors of the list: those that may move an error by more than its u.
fn doubts(fit: &Fitted<'_>) -> Option<FoundTable> {
    let heads = [
        "error",
        "value",
        "u",
        "unit",
        "other cause",
        "its amount",
        "its u",
        "its unit",
        "value with it",
        "moved at most, circle",
        "moved at most, whole travel",
    ];
    let mut rows = Vec::new();
    for error in &fit.errors {
        let most = |other: &Other| other.at_most(&error.columns);
        let mut of_error: Vec<(&Other, &Seen, [f64; 2])> = fit
            .others()
            .filter_map(|other| Some((other, other.seen.as_ref()?, most(other)?)))
            .filter(|(.., [within, far])| within.max(*far) > error.u)
            .collect();
        of_error.sort_by(|a, b| b.2[0].total_cmp(&a.2[0]));
        let scale = error.listed.unit.per_inside;
        for (other, seen, [within, far]) in of_error.into_iter().take(SHOWN_CAUSES) {
            rows.push(vec![
                Cell::Text(error.listed.name.clone()),
                Cell::Number(error.value * scale),
                Cell::Number(error.u * scale),
                Cell::Text(error.listed.unit.text()),
                Cell::Text(other.words()),
                Cell::Number(seen.amount * other.unit.per_inside),
                Cell::Number(seen.u * other.unit.per_inside),
                Cell::Text(other.unit.text()),
                Cell::Number(without(other.value_with(&error.x, &error.columns), error.rounding) * scale),
                Cell::Number(within * scale),
                Cell::Number(far * scale),
            ]);
        }
    }
    (!rows.is_empty()).then(|| FoundTable {
        caption: format!("What else may read as errors of the list in {}", fit.trace.name),
        columns: heads.map(Column::plain).to_vec(),
        rows,
    })
}

impl FittedError {
    /// What a person types into the control, with its sign; for errors that controls take as one number, where they are significant.
    pub(super) fn to_enter(&self, trace: &Trace) -> Option<String> {
        // One way, a servo mismatch and backlash read as squareness, lateral play as scale.
        if !trace.both_ways() {
            return None;
        }
        let plane = trace.plane;
        let (number, unit) = (-self.value * self.listed.unit.per_inside, self.listed.unit.text());
        let what = match self.listed.kind {
            ListedKind::Backlash(k) => format!("backlash compensation of {}", plane[k]),
            ListedKind::ScaleMismatch => format!("scale of {} against {}", plane[0], plane[1]),
            ListedKind::Squareness => format!("squareness compensation {}", self.listed.name),
            _ => return None,
        };
        self.significant().then(|| format!("{what}: add {} {unit}", signed(number, 1)))
    }
}

/// The list by its circularity, and what it leaves.
fn ranking(fit: &Fitted<'_>) -> FoundTable {
    let columns = vec![
        Column::plain("rank"),
        Column::plain("error"),
        Column::of("circularity", Unit::UM),
        Column::plain("share"),
        Column::plain("value"),
        Column::plain("u"),
        Column::plain("unit"),
        Column::of("decay", Unit::MM),
        Column::plain("to enter"),
    ];
    let beyond_noise_mm = fit.unexplained_circularity_mm();
    let share = |circularity_mm: f64| Cell::Text(fit.share(circularity_mm));
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for (i, error) in fit.errors.iter().enumerate() {
        let scale = error.listed.unit.per_inside;
        rows.push(vec![
            Cell::Text((i + 1).to_string()),
            Cell::Text(error.listed.name.clone()),
            Cell::Number(error.circularity_mm),
            share(error.circularity_mm),
            Cell::Number(error.value * scale),
            Cell::Number(error.u * scale),
            Cell::Text(error.listed.unit.text()),
            error.decay_mm.map_or(Cell::Missing, Cell::Number),
            error.to_enter(fit.trace).map_or(Cell::Missing, Cell::Text),
        ]);
    }
    for (name, circularity_mm, share) in [
        ("unexplained beyond noise", beyond_noise_mm, share(beyond_noise_mm)),
        ("whole trace", fit.iso.of_the_trace_mm(), Cell::Missing),
    ] {
        let mut row = vec![Cell::Missing, Cell::Text(name.into()), Cell::Number(circularity_mm), share];
        row.resize(columns.len(), Cell::Missing);
        rows.push(row);
    }
    FoundTable {
        caption: format!("What the trace in {} is made of, by circularity", fit.trace.name),
        columns,
        rows,
    }
}

/// The feeds of the trace in words.
fn feed(trace: &Trace) -> String {
    let feeds: Vec<String> =
        trace.feeds_mm_per_s().iter().map(|feed| format!("{:.0}", 60.0 * feed)).collect();
    match feeds.is_empty() {
        true => "feed unknown".into(),
        false => format!("feed {} mm/min", feeds.join(", ")),
    }
}

fn notes(machine: &Machine, traces: &Traces, fits: &[Fitted<'_>]) -> Vec<String> {
    let mut notes = vec![
        "All errors of the list are fitted together to both ways; circularities of errors do not add up to that of the trace. A share is part of the sum of all of them and of \
         what is unexplained beyond noise. The latter counts as the range of a sine of its rms."
            .to_string(),
        "To enter: correction = −error, added to what stands in the control. Measure again: a wrong sign doubles the error.".into(),
    ];
    for fit in fits {
        let plane = &fit.trace.name;
        // What ISO 230-4 wants stated with the values; a wrong unit of time or feed is seen here.
        notes.push(format!("{plane}: radius {:.1} mm, {}.", fit.trace.radius_mm, feed(fit.trace)));
        notes.push(format!(
            "{plane}: values hold for the guides within the circle, ±{:.0} mm. A guide that is S-shaped leans differently over a longer travel.",
            fit.trace.radius_mm
        ));
        if doubts(fit).is_some() {
            notes.push(format!(
                "{plane}: a table gives what else may read as errors of the list, and by how far it may move them (95 %). It gives two bounds: within the circle, and over \
                 the whole travel if the guide goes on as it does there."
            ));
        }
        if let Err(why) = &fit.others {
            notes.push(format!(
                "{plane}: which other causes read as errors of the list was not computed ({why}), so u does not hold them."
            ));
        }
        let names = strongest(fit);
        if !names.is_empty() {
            let listed =
                if names.len() > 1 { "; none of them is on the list" } else { ", which is not on the list" };
            notes.push(format!(
                "{plane}: what the list leaves looks like {}{listed}. The readings do not say whether an error is of the list or {}; its u holds the difference.",
                names.join(" or "),
                if names.len() > 1 { "one of these" } else { "this" }
            ));
        }
        notes.extend(fit.drift.iter().map(|drift| format!("{plane}: {}", drift.words())));
        if fit.leaves_more_than_noise() {
            notes.push(format!(
                "{plane}: the list does not explain everything. See the chart of the residual: where it is large, and whether both ways agree. \
                 The joint fit and `diagnose` look for what is missing."
            ));
        }
        if let Some(arc) = fit.trace.arc_rad {
            notes.push(format!(
                "{plane} covers {:.0}° of 360°: its circular deviations are those of the arc, and errors that only a whole circle separates read as each other. Spikes at the ends of the arc are where a pass begins and ends. Run whole circles.",
                arc.to_degrees()
            ));
        }
        if fit.iso.g_mm.len() < 2 {
            notes.push(format!(
                "{plane} was read one way only: G(b), backlash, lateral play and servo mismatch are not observable, and a servo mismatch \
                 reads as squareness. Run it both ways."
            ));
        }
        let distance = "Servo mismatch is given as a distance at that speed. This holds for one constant speed only: do not trust backlash and spikes where the feed \
                        changed.";
        match fit.trace.speed {
            Speed::Run => {}
            Speed::Times if fit.trace.on_the_fly => notes.push(format!(
                "{plane}: the rows are too far apart in time for speeds at a row, so the speed is that from row to row. Servo mismatch and reversals are better \
                 known with ten rows a second or more."
            )),
            Speed::Times => notes.push(format!(
                "{plane}: the speed is that of the rows by time_s, because the run was imported as static. If the axes stopped for each reading, servo mismatch means \
                 nothing. If they moved, import with --kind on-the-fly."
            )),
            Speed::OutOfOrder => notes.push(format!(
                "{plane}: the run has time_s, but its rows do not follow the path in time, so it knows no speed. {distance} Sort the rows by time and import \
                 with --kind on-the-fly."
            )),
            Speed::TooCoarse => notes.push(format!(
                "{plane}: time_s has too few decimals to give a speed: rows one after the other have the same time. {distance} Export it with more decimals."
            )),
            Speed::Unknown => notes
                .push(format!("{plane}: the run knows no speed (no time_s, no feed_mm_per_min). {distance}")),
        }
        if fit.trace.between > 0 {
            notes.push(format!(
                "{plane}: left out of the fit are {} of {} readings, just after an axis reversed: rows do not say whether it goes the other way there already.",
                fit.trace.between,
                fit.trace.read.len()
            ));
        }
        if !fit.trace.calibrated {
            notes.push(format!(
                "{plane}: the bar has no calibrated length (calibrated = true), so D, F and the mean scale are not known."
            ));
        }
        for letter in fit.trace.plane {
            let spike = format!("reversal spike {letter}");
            if fit.errors.iter().all(|error| error.listed.name != spike) {
                notes.push(format!("{plane}: no {spike} is significant; it is not on the list."));
            }
            if machine.axis(letter).is_some_and(|axis| axis.facts.screw_lead_mm.is_none()) {
                notes.push(format!(
                    "Axis {letter} has no screw_lead_mm in the machine file, so cyclic error is not on the list."
                ));
            }
        }
    }
    notes.extend(left_out_notes(&traces.left_out));
    notes
}
