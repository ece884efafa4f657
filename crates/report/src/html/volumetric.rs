//! Volumetric accuracy as a page: verdict, values, the distorted volume.

use crate::markup::{element, escape, table};
use crate::svg::{Lattice, lattice, nice_above};
use crate::volumetric::{HEADS, notes, rows, verdict};
use trunnion_core::convert::mm_from_um;
use trunnion_results::sentences::sources;
use trunnion_results::{ErrorAt, ErrorMap, Volumetric};

/// The longest vector is drawn as long as this share of the longest side of the volume.
const DRAWN: f64 = 0.1;

pub fn sections(answer: &Volumetric, map: &ErrorMap, volume: &str, label: &str) -> String {
    let mut html = element("h1", &verdict(answer));
    let runs = answer.runs.join(", ");
    html += &format!(
        "\n<p class=\"soft\">Source: {}. Volume: {}. Runs: {}. {}</p>\n",
        escape(&sources("ISO 230-1; S2 §1")),
        escape(volume),
        escape(&runs),
        escape(label)
    );
    html +=
        &table("Largest ranges over the volume with standard uncertainties", &HEADS, &[1, 2], &rows(answer));
    let items: String = notes(answer).iter().map(|note| element("li", note)).collect();
    html += &format!("<ul>{items}</ul>\n");
    let pictures = views(answer, map);
    if !pictures.is_empty() {
        html += &format!(
            "<section><h2>The volume, displaced</h2>\n<div class=\"pairs\">{pictures}</div></section>\n"
        );
    }
    html
}

/// A linear axis of the map: its name, its place among the axes of the map, and the coordinate along which it moves.
#[derive(Clone, Copy)]
struct Along<'a> {
    name: &'a str,
    axis: usize,
    coordinate: usize,
}

/// Sections through the volume in three views, deviations magnified alike.
fn views(answer: &Volumetric, map: &ErrorMap) -> String {
    let along = |(coordinate, name): (usize, &'static str)| {
        let axis = map.axes.iter().position(|axis| axis.name == name)?;
        Some(Along { name, axis, coordinate })
    };
    let [Some(x), Some(y), Some(z)] = [(0, "X"), (1, "Y"), (2, "Z")].map(along) else {
        return String::new();
    };
    let Some(longest_um) =
        answer.values.iter().find(|found| found.name == "longest-vector").and_then(|found| found.value)
    else {
        return String::new();
    };
    let side = |of: Along<'_>| answer.volume.get(of.name).map_or(0.0, |[low, high]| high - low);
    let longest_side = [x, y, z].map(side).into_iter().fold(0.0, f64::max);
    if longest_um <= 0.0 || longest_side <= 0.0 {
        return String::new();
    }
    // A round number, not above what was asked.
    let magnification = nice_above(DRAWN * longest_side / mm_from_um(longest_um) / 2.0);
    [[x, y, z], [z, x, y], [y, z, x]]
        .into_iter()
        .filter(|[across, up, _]| side(*across) > 0.0 && side(*up) > 0.0)
        .filter(|[across, up, _]| [across, up].iter().any(|of| is_known(map, of.coordinate)))
        .map(|view| section(map, view, magnification))
        .collect()
}

fn section(map: &ErrorMap, [across, up, through]: [Along<'_>; 3], magnification: f64) -> String {
    let positions = |axis: usize| {
        let mut positions: Vec<f64> = map.places.iter().map(|place| place.position[axis]).collect();
        positions.sort_by(f64::total_cmp);
        positions.dedup_by(|a, b| (*a - *b).abs() < SAME);
        positions
    };
    let held: Vec<f64> = (0..map.axes.len())
        .map(|axis| {
            let places = positions(axis);
            let nearest_zero = || places.iter().copied().min_by(|a, b| a.abs().total_cmp(&b.abs()));
            let middle = || places.get(places.len() / 2).copied();
            if map.axes[axis].rotary { nearest_zero() } else { middle() }.unwrap_or(0.0)
        })
        .collect();
    let drawn = [across.axis, up.axis].map(|axis| {
        let positions = positions(axis);
        let every = positions.len().div_ceil(MOST_LINES).max(1);
        (axis, positions.into_iter().step_by(every).collect::<Vec<f64>>())
    });
    let here = |place: &&ErrorAt| {
        let is_at = |axis: usize, position: f64| (place.position[axis] - position).abs() < SAME;
        let others = (0..map.axes.len()).filter(|axis| ![across.axis, up.axis].contains(axis));
        others.into_iter().all(|axis| is_at(axis, held[axis]))
            && drawn.iter().all(|(axis, positions)| positions.iter().any(|position| is_at(*axis, *position)))
    };
    let mut places: Vec<&ErrorAt> = map.places.iter().filter(here).collect();
    let by = |place: &&ErrorAt, of: Along<'_>| place.position[of.axis];
    places.sort_by(|a, b| by(a, across).total_cmp(&by(b, across)).then(by(a, up).total_cmp(&by(b, up))));
    let nominal = |p: &ErrorAt| (p.in_table_mm[across.coordinate], p.in_table_mm[up.coordinate]);
    let displaced = |p: &ErrorAt| {
        let moved = |k: usize| p.in_table_mm[k] + magnification * mm_from_um(p.error[k].unwrap_or(0.0));
        (moved(across.coordinate), moved(up.coordinate))
    };
    let rows = |of: &dyn Fn(&ErrorAt) -> (f64, f64)| -> Vec<Vec<(f64, f64)>> {
        places
            .chunk_by(|a, b| by(a, across) == by(b, across))
            .map(|row| row.iter().map(|p| of(p)).collect())
            .collect()
    };
    let drawn = Lattice { nominal: rows(&nominal), displaced: rows(&displaced) };
    let title = format!("Plane {}{} at {} {:.0} mm", across.name, up.name, through.name, held[through.axis]);
    let unknown: Vec<&str> =
        [across, up].iter().filter(|of| !is_known(map, of.coordinate)).map(|of| of.name).collect();
    let unknown = match unknown.as_slice() {
        [] => String::new(),
        names => format!("; not known along {}", names.join(", ")),
    };
    let caption = format!("{title}; magnification of deviations {magnification:.0}{unknown}");
    lattice(&title, &caption, [across.name, up.name], &drawn)
}

/// True where an effect of the model moves a coordinate somewhere in the volume.
fn is_known(map: &ErrorMap, coordinate: usize) -> bool {
    map.places.iter().any(|place| place.error[coordinate].is_some())
}

/// Lines drawn along an axis, at most; of more places every n-th.
const MOST_LINES: usize = 13;

/// Positions of the grid that differ by less are the same, mm and degrees.
const SAME: f64 = 1e-9;
