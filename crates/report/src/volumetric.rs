//! Volumetric accuracy in rows: what text, page and error map file share.

use crate::number::{MISSING, trimmed, um, value_and_u};
use std::collections::BTreeMap;
use trunnion_core::Joint;
use trunnion_core::number::in_table;
use trunnion_results::{Datum, ErrorMap, LocationError, Looked, ResidualAxis, Volumetric, VolumetricValue};

/// Heads of the table of values.
pub const HEADS: [&str; 4] = ["over the volume", "value", "u", "from where to where (mm)"];

/// Why a figure is not known.
const NOT_CHANGED: &str = "no effect of the model changes it";

/// Range by direction and the longest vector.
pub fn rows(answer: &Volumetric) -> Vec<Vec<String>> {
    let row = |found: &VolumetricValue| {
        if found.value.is_none() {
            return vec![name_of(found), "not known".into(), MISSING.into(), NOT_CHANGED.into()];
        }
        let (value, u) = value_and_u(found.value, found.u.filter(|u| *u > 0.0), &found.unit);
        let place = match range_of(found) {
            Some(_) => format!("{} to {}", at(answer, &found.from), at(answer, &found.to)),
            None => at(answer, &found.to),
        };
        vec![name_of(found), value, u, place]
    };
    answer.values.iter().map(row).collect()
}

fn name_of(found: &VolumetricValue) -> String {
    range_of(found).map_or_else(
        || "longest vector of position".into(),
        |letter| {
            let what = if letter.is_rotary() { "orientation" } else { "position" };
            format!("largest range of {what} in {letter}")
        },
    )
}

/// The direction whose range it is; `None` for the longest vector.
fn range_of(found: &VolumetricValue) -> Option<Joint> {
    found.name.strip_prefix("range-").and_then(Joint::parse)
}

/// Positions of the axes that move, `X −240 Y 0 B 30°`; lengths in mm.
fn at(answer: &Volumetric, position: &BTreeMap<String, f64>) -> String {
    let moves = |name: &String| answer.volume.get(name).is_some_and(|[low, high]| low < high);
    let axis = |axis: &ResidualAxis| {
        let at = position.get(&axis.name).filter(|_| moves(&axis.name))?;
        Some(format!("{} {}{}", axis.name, trimmed(*at, 1), if axis.rotary { "°" } else { "" }))
    };
    answer.axes.iter().filter_map(axis).collect::<Vec<_>>().join(" ")
}

/// How densely the volume was looked at, and what that misses.
fn density(answer: &Volumetric) -> String {
    let step = |looked: &Looked| {
        let unit =
            if answer.axes.iter().any(|axis| axis.name == looked.axis && axis.rotary) { "°" } else { " mm" };
        format!("{} every {}{unit} ({} places)", looked.axis, trimmed(looked.step, 3), looked.places)
    };
    let steps: Vec<String> = answer.looked.iter().map(step).collect();
    let coarse: Vec<String> = answer
        .values
        .iter()
        .filter(|found| answer.is_coarse(found))
        .map(|found| {
            let (missed, _) = value_and_u(Some(found.missed), None, &found.unit);
            format!("{} by up to {missed}", name_of(found))
        })
        .collect();
    let misses = match coarse.is_empty() {
        true => "Along no axis is a figure larger between these places by more than 1 % or its u.".into(),
        false => format!(
            "That is too coarse for the waves of this model. Between these places may be larger: {}. Take more --steps, or a smaller --volume.",
            coarse.join("; ")
        ),
    };
    format!("Looked at: {}. {misses}", steps.join(", "))
}

/// Directions whose range is not known, `Z, A, B`; empty where all are.
fn not_known(answer: &Volumetric, of: fn(Joint) -> bool) -> String {
    let unknown = answer.values.iter().filter(|found| found.value.is_none()).filter_map(range_of);
    let names: Vec<&str> = unknown.filter(|letter| of(*letter)).map(|letter| letter.as_str()).collect();
    names.join(", ")
}

/// What the figures are and what they lack, in sentences.
pub fn notes(answer: &Volumetric) -> Vec<String> {
    let mut notes = vec![match answer.datum {
        Datum::Fit => "Deviation of tool against table in the axes of the table; the rigid displacement of the whole volume that fits best is removed (how the workpiece is set).".to_owned(),
        Datum::Model => "Deviation of tool against table in the axes of the table, in the coordinate system that the zeros of the model's parameters define.".to_owned(),
    }];
    let not_known = not_known(answer, |_| true);
    if !not_known.is_empty() {
        notes.push(format!(
            "Not known in {not_known}: {NOT_CHANGED} over this volume. The machine may have errors there; a model with effects that change it shows them."
        ));
    }
    notes.push(density(answer));
    if answer.lower_bound {
        let same = answer.unseen.chunk_by(|a, b| a.moves == b.moves);
        let mut lacks: Vec<String> = same
            .map(|group| {
                let directions: Vec<&str> = group.iter().map(|unseen| unseen.direction.as_str()).collect();
                let moves = group.first().map_or(String::new(), |unseen| unseen.moves.join(", "));
                format!("{} (not seen, taken as zero; would change {moves})", directions.join(", "))
            })
            .collect();
        lacks.extend(
            answer
                .stood_still
                .iter()
                .map(|letter| format!("everything of axis {letter} (it stood still in these runs)")),
        );
        notes.push(format!("The figures are lower bounds. They lack: {}.", lacks.join("; ")));
    } else {
        notes.push("Nothing of the model that would change the figures is unseen. Errors that the model does not know are not in them.".into());
    }
    notes.extend(
        answer
            .left_out
            .iter()
            .map(|left_out| format!("Not in the map: {}: {}.", left_out.effect, left_out.why)),
    );
    notes
}

/// The error map as CSV: `x_mm … c_deg` of the axes that move or stand, then deviations and standard uncertainties; empty where nothing of the
/// model moves a component.
pub fn error_map_csv(map: &ErrorMap) -> String {
    let mut head: Vec<String> = map
        .axes
        .iter()
        .map(|axis| format!("{}_{}", axis.name.to_lowercase(), if axis.rotary { "deg" } else { "mm" }))
        .collect();
    for prefix in ["e", "u_e"] {
        let unit = |letter: &Joint| if letter.is_rotary() { "urad" } else { "um" };
        head.extend(Joint::ALL.iter().map(|letter| format!("{prefix}{}_{}", letter.lower(), unit(letter))));
    }
    let mut text = head.join(",") + "\n";
    for place in &map.places {
        let position = place.position.iter().map(|at| in_table(*at, 6));
        let deviation = |value: &Option<f64>| value.map_or_else(String::new, |value| in_table(value, 5));
        let deviations = place.error.iter().chain(&place.u).map(deviation);
        text += &(position.chain(deviations).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

/// Location errors in a notation: heads and rows.
pub fn location_rows(errors: &[LocationError]) -> Vec<Vec<String>> {
    let mut rows = vec![["symbol", "value", "u", "remark"].map(String::from).to_vec()];
    rows.extend(errors.iter().map(|error| {
        let (value, u) = match (error.value, error.without_number.is_empty()) {
            (None, false) => ("no number".into(), MISSING.into()),
            _ => value_and_u(error.value, error.u, &error.unit),
        };
        let remark = match error.without_number.len() {
            0 => String::new(),
            _ => format!("these runs give no number to {}", error.without_number.join(", ")),
        };
        vec![error.symbol.clone(), value, u, remark]
    }));
    rows
}

/// Headline of the page: the worst of the position ranges.
pub fn verdict(answer: &Volumetric) -> String {
    let ranges = answer.values.iter().filter_map(|found| Some((range_of(found)?, found.value?, found)));
    let worst = ranges.filter(|(letter, ..)| !letter.is_rotary()).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((letter, value, range)) = worst else {
        return format!("Volumetric accuracy of {}", answer.machine);
    };
    let is_it = |name: &String| name == letter.as_str();
    let lacking =
        !answer.stood_still.is_empty() || answer.unseen.iter().any(|unseen| unseen.moves.iter().any(is_it));
    let bound = if lacking || answer.is_coarse(range) { "at least " } else { "" };
    let rest = match not_known(answer, |letter| !letter.is_rotary()) {
        names if names.is_empty() => names,
        names => format!("; not known in {names}"),
    };
    format!("Volumetric accuracy of {}: {bound}{} in {letter}{rest}", answer.machine, um(value))
}
