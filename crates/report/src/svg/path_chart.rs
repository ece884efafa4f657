//! Paths in a plane, equal scales in both directions, with a key.

use super::element::{figure, line, polyline, text};
use super::key::{FIRST_ROW, keys, length};
use super::mark::Mark;
use super::scale::{Scale, extent};
use crate::number::tick;

const WIDTH: f64 = 360.0;
const LEFT: f64 = 54.0;
/// Of the last row of the key to the plot.
const ABOVE: f64 = 11.0;
const SIDE: f64 = 260.0;

/// The picture; `names` of the directions to the right and up, with unit.
pub fn path_chart(title: &str, names: [&str; 2], paths: &[(String, Vec<(f64, f64)>)]) -> String {
    let finite = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite();
    let places = || paths.iter().flat_map(|(_, points)| points.iter().filter(finite));
    let (left, right) = extent(places().map(|p| p.0)).unwrap_or((-1.0, 1.0));
    let (low, high) = extent(places().map(|p| p.1)).unwrap_or((-1.0, 1.0));
    let half = ((right - left).max(high - low) * 0.55).max(1e-9);
    let (middle_x, middle_y) = ((left + right) / 2.0, (low + high) / 2.0);
    let entries: Vec<(Mark, &str)> =
        paths.iter().zip(Mark::LINES).map(|((name, _), (mark, _))| (mark, name.as_str())).collect();
    let begin = LEFT.max(10.0 + length(names[1]));
    let (mut body, last_row) = keys(&entries, begin, (LEFT, WIDTH));
    let (top, bottom) = (last_row + ABOVE, last_row + ABOVE + SIDE);
    let x = Scale::new((middle_x - half, middle_x + half), (LEFT, LEFT + SIDE));
    let y = Scale::new((middle_y - half, middle_y + half), (bottom, top));
    body += &format!("<rect x=\"{LEFT}\" y=\"{top}\" width=\"{SIDE}\" height=\"{SIDE}\" class=\"frame\"/>\n");
    let (ticks, step) = x.ticks(5);
    for value in ticks {
        let class = if value == 0.0 { "zero" } else { "grid" };
        body += &line((x.at(value), top), (x.at(value), bottom), class);
        body += &text(x.at(value), bottom + 15.0, "t mid", &tick(value, step));
    }
    let (ticks, step) = y.ticks(5);
    for value in ticks {
        let class = if value == 0.0 { "zero" } else { "grid" };
        body += &line((LEFT, y.at(value)), (LEFT + SIDE, y.at(value)), class);
        body += &text(LEFT - 4.0, y.at(value) + 4.0, "t end", &tick(value, step));
    }
    for ((_, points), (_, class)) in paths.iter().zip(Mark::LINES) {
        let drawn: Vec<_> = points.iter().filter(finite).map(|p| (x.at(p.0), y.at(p.1))).collect();
        body += &polyline(&drawn, false, class);
    }
    body += &text(LEFT + SIDE / 2.0, bottom + 31.0, "t mid", names[0]);
    body += &text(4.0, FIRST_ROW, "t", names[1]);
    figure(title, WIDTH, bottom + 37.0, title, &body)
}
