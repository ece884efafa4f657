//! Volumetric accuracy as a page: verdict, values, the distorted volume.

use crate::markup::{element, escape, table};
use crate::svg::{Lattice, lattice, nice_above};
use crate::volumetric::{HEADS, notes, rows, verdict};
use trunnion_core::AxisLetter;
use trunnion_methods::volumetric::{MapPoint, VolumetricMap};

/// The longest vector is drawn as long as this share of the longest side of the volume.
const DRAWN: f64 = 0.1;

pub fn sections(map: &VolumetricMap, volume: &str, label: &str) -> String {
    let mut html = element("h1", &verdict(map));
    let runs = map.runs.join(", ");
    html += &format!(
        "\n<p class=\"soft\">Source: ISO 230-1; S2 §1. Volume: {}. Runs: {}. {}</p>\n",
        escape(volume),
        escape(&runs),
        escape(label)
    );
    html += &table("Largest ranges over the volume with standard uncertainties", &HEADS, &[1, 2], &rows(map));
    let items: String = notes(map).iter().map(|note| element("li", note)).collect();
    html += &format!("<ul>{items}</ul>\n");
    let pictures = views(map);
    if !pictures.is_empty() {
        html += &format!(
            "<section><h2>The volume, displaced</h2>\n<div class=\"pairs\">{pictures}</div></section>\n"
        );
    }
    html
}

/// Sections through the volume in three views, deviations magnified alike.
fn views(map: &VolumetricMap) -> String {
    let longest_mm = map.longest.value;
    let side = |letter: AxisLetter| map.volume.range[letter].1 - map.volume.range[letter].0;
    let longest_side = AxisLetter::LINEAR.into_iter().map(side).fold(0.0, f64::max);
    if longest_mm <= 0.0 || longest_side <= 0.0 {
        return String::new();
    }
    // A round number, not above what was asked.
    let magnification = nice_above(DRAWN * longest_side / longest_mm / 2.0);
    let [x, y, z] = AxisLetter::LINEAR;
    [(x, y, z), (z, x, y), (y, z, x)]
        .into_iter()
        .filter(|&(across, up, _)| side(across) > 0.0 && side(up) > 0.0)
        .map(|(across, up, through)| view(map, [across, up, through], magnification))
        .collect()
}

fn view(map: &VolumetricMap, [across, up, through]: [AxisLetter; 3], magnification: f64) -> String {
    let middle = |letter: AxisLetter| {
        let places = map.volume.places(letter);
        places[places.len() / 2]
    };
    let nearest_zero = |letter: AxisLetter| {
        let places = map.volume.places(letter);
        places.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0)
    };
    let held = |letter: AxisLetter| if letter.is_rotary() { nearest_zero(letter) } else { middle(letter) };
    let others = || map.volume.joints.iter().copied().filter(|letter| *letter != across && *letter != up);
    let here =
        |point: &&MapPoint| others().all(|letter| (point.position[letter] - held(letter)).abs() < 1e-9);
    let mut points: Vec<&MapPoint> = map.points.iter().filter(here).collect();
    let by = |p: &&MapPoint, letter: AxisLetter| p.position[letter];
    points.sort_by(|a, b| by(a, across).total_cmp(&by(b, across)).then(by(a, up).total_cmp(&by(b, up))));
    let nominal = |p: &MapPoint| (p.in_table_mm[across.index()], p.in_table_mm[up.index()]);
    let displaced = |p: &MapPoint| {
        let moved = |k: usize| p.in_table_mm[k] + magnification * p.error.translation_mm[k];
        (moved(across.index()), moved(up.index()))
    };
    let rows = |of: &dyn Fn(&MapPoint) -> (f64, f64)| -> Vec<Vec<(f64, f64)>> {
        points
            .chunk_by(|a, b| by(a, across) == by(b, across))
            .map(|row| row.iter().map(|p| of(p)).collect())
            .collect()
    };
    let drawn = Lattice { nominal: rows(&nominal), displaced: rows(&displaced) };
    let title = format!("Plane {across}{up} at {through} {:.0} mm", held(through));
    let caption = format!("{title}; deviations {magnification:.0} times as large");
    lattice(&title, &caption, [across.as_str(), up.as_str()], &drawn)
}
