//! A volumetric map in rows: what text, page and error map file share.

use crate::number::{MISSING, minus, um, value_and_u};
use trunnion_core::AxisLetter;
use trunnion_core::convert::{deg_from_rad, um_from_mm, urad_from_rad};
use trunnion_methods::volumetric::{Datum, Extreme, Unseen, VolumetricMap};
use trunnion_results::LocationError;

/// Heads of the table of values.
pub const HEADS: [&str; 4] = ["over the volume", "value", "u", "from where to where"];

/// Range by direction and the longest vector.
pub fn rows(map: &VolumetricMap) -> Vec<Vec<String>> {
    let row = |name: String, extreme: &Extreme, rotation: bool, place: String| {
        let (scaled, unit): (fn(f64) -> f64, _) =
            if rotation { (urad_from_rad, "urad") } else { (um_from_mm, "um") };
        let u = Some(scaled(extreme.u)).filter(|u| *u > 0.0);
        let (value, u) = value_and_u(Some(scaled(extreme.value)), u, unit);
        vec![name, value, u, place]
    };
    let mut rows: Vec<Vec<String>> = AxisLetter::ALL
        .into_iter()
        .zip(&map.ranges)
        .map(|(letter, range)| {
            let what = if letter.is_rotary() { "orientation" } else { "position" };
            let place = format!("{} to {}", at(map, range.low), at(map, range.high));
            row(format!("largest range of {what} in {letter}"), range, letter.is_rotary(), place)
        })
        .collect();
    rows.push(row("longest vector of position".into(), &map.longest, false, at(map, map.longest.high)));
    rows
}

/// Positions of the axes that move, `X −240 Y 0 mm`.
fn at(map: &VolumetricMap, point: usize) -> String {
    let position = &map.points[point].position;
    let axis = |letter: AxisLetter| match letter.is_rotary() {
        true => format!("{letter} {}°", round(deg_from_rad(position[letter]))),
        false => format!("{letter} {}", round(position[letter])),
    };
    map.volume.moving().map(axis).collect::<Vec<_>>().join(" ")
}

fn round(value: f64) -> String {
    minus(format!("{}", (value * 10.0).round() / 10.0 + 0.0))
}

/// What the figures are and what they lack, in sentences.
pub fn notes(map: &VolumetricMap) -> Vec<String> {
    let mut notes = vec![match map.datum {
        Datum::BestFit => "Deviation of tool against table in the axes of the table; the rigid displacement of the whole volume that fits best is removed (how the workpiece is set).".to_owned(),
        Datum::Model => "Deviation of tool against table in the axes of the table, in the coordinate system that the zeros of the model's parameters define.".to_owned(),
    }];
    if map.lower_bound() {
        let moved = |unseen: &Unseen| unseen.moves.iter().map(|letter| letter.as_str()).collect::<Vec<_>>();
        let alike = map.unseen.chunk_by(|a, b| a.moves == b.moves);
        let mut lacks: Vec<String> = alike
            .map(|group| {
                let directions: Vec<&str> = group.iter().map(|unseen| unseen.direction.as_str()).collect();
                let moves = group.first().map(moved).unwrap_or_default().join(", ");
                format!("{} (not seen, taken as zero; would change {moves})", directions.join(", "))
            })
            .collect();
        lacks.extend(
            map.stood_still
                .iter()
                .map(|letter| format!("everything of axis {letter} (it stood still in these runs)")),
        );
        notes.push(format!("The figures are lower bounds. They lack: {}.", lacks.join("; ")));
    } else {
        notes.push("Nothing of the model that would change the figures is unseen. Errors that the model does not know are not in them.".into());
    }
    notes.extend(
        map.left_out.iter().map(|left_out| format!("Not in the map: {}: {}.", left_out.effect, left_out.why)),
    );
    notes
}

/// The error map as CSV: `x_mm … c_deg` of the axes that move or stand, then deviations and standard uncertainties.
pub fn error_map_csv(map: &VolumetricMap, axes: &[AxisLetter]) -> String {
    let mut head: Vec<String> = axes
        .iter()
        .map(|letter| format!("{}_{}", letter.lower(), if letter.is_rotary() { "deg" } else { "mm" }))
        .collect();
    for prefix in ["e", "u_e"] {
        let unit = |letter: &AxisLetter| if letter.is_rotary() { "urad" } else { "um" };
        head.extend(
            AxisLetter::ALL.iter().map(|letter| format!("{prefix}{}_{}", letter.lower(), unit(letter))),
        );
    }
    let mut text = head.join(",") + "\n";
    for point in &map.points {
        let place = |letter: &AxisLetter| match letter.is_rotary() {
            true => deg_from_rad(point.position[*letter]),
            false => point.position[*letter],
        };
        let mut cells: Vec<String> =
            axes.iter().map(|letter| format!("{:.6}", place(letter) + 0.0)).collect();
        for twist in [&point.error, &point.u] {
            cells.extend(twist.translation_mm.iter().map(|mm| format!("{:.5}", um_from_mm(*mm) + 0.0)));
            cells.extend(twist.rotation_rad.iter().map(|rad| format!("{:.5}", urad_from_rad(*rad) + 0.0)));
        }
        text += &(cells.join(",") + "\n");
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
            _ => format!("without {}: not seen, or zero by convention", error.without_number.join(", ")),
        };
        vec![error.symbol.clone(), value, u, remark]
    }));
    rows
}

/// Headline of the page: the worst of the position ranges.
pub fn verdict(map: &VolumetricMap) -> String {
    let (letter, range) = AxisLetter::LINEAR
        .into_iter()
        .zip(&map.ranges)
        .max_by(|a, b| a.1.value.total_cmp(&b.1.value))
        .map_or((AxisLetter::X, map.ranges[0]), |(letter, range)| (letter, *range));
    let lacking =
        !map.stood_still.is_empty() || map.unseen.iter().any(|unseen| unseen.moves.contains(&letter));
    let bound = if lacking { "at least " } else { "" };
    format!("Volumetric accuracy of {}: {bound}{} in {letter}", map.machine, um(um_from_mm(range.value)))
}
