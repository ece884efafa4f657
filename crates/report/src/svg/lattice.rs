//! A lattice as commanded and as displaced, the deviations magnified.

use super::element::{figure, line, polyline, text};
use super::scale::Plane;
use crate::number::tick;

const WIDTH: f64 = 360.0;
const LEFT: f64 = 52.0;
const TOP: f64 = 24.0;
const SIDE: f64 = 296.0;

/// Places of a lattice in a plane, mm: rows of columns.
pub struct Lattice {
    pub nominal: Vec<Vec<(f64, f64)>>,
    /// The same, displaced and magnified.
    pub displaced: Vec<Vec<(f64, f64)>>,
}

/// The picture with equal scales; `names` of the directions to the right and up.
pub fn lattice(title: &str, caption: &str, names: [&str; 2], lattice: &Lattice) -> String {
    let all = || lattice.nominal.iter().chain(&lattice.displaced).flatten();
    let Plane { x, y, height, bottom } =
        Plane::around(all().copied(), (1.06, 1.06), SIDE / 3.0, (LEFT, TOP, SIDE));
    let mut body =
        format!("<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{SIDE}\" height=\"{height:.1}\" class=\"frame\"/>\n");
    let (ticks, step) = x.ticks(5);
    for value in ticks {
        body += &line((x.at(value), bottom), (x.at(value), bottom + 3.0), "axis");
        body += &text(x.at(value), bottom + 16.0, "t mid", &tick(value, step));
    }
    let (ticks, step) = y.ticks(5);
    for value in ticks {
        body += &line((LEFT - 3.0, y.at(value)), (LEFT, y.at(value)), "axis");
        body += &text(LEFT - 5.0, y.at(value) + 4.0, "t end", &tick(value, step));
    }
    for (places, class) in [(&lattice.nominal, "l3 thin"), (&lattice.displaced, "l2 solid")] {
        for across in places.iter().chain(&transposed(places)) {
            let drawn: Vec<_> = across.iter().map(|p| (x.at(p.0), y.at(p.1))).collect();
            body += &polyline(&drawn, false, class);
        }
    }
    for (from, class, name) in [(LEFT, "l3 thin", "commanded"), (LEFT + 130.0, "l2 solid", "displaced")] {
        body += &line((from, 10.0), (from + 16.0, 10.0), class);
        body += &text(from + 21.0, 13.5, "t", name);
    }
    body += &text(LEFT + SIDE / 2.0, bottom + 32.0, "t mid", &format!("{} (mm)", names[0]));
    body += &text(2.0, 13.5, "t", &format!("{} (mm)", names[1]));
    figure(title, WIDTH, bottom + 38.0, caption, &body)
}

fn transposed(rows: &[Vec<(f64, f64)>]) -> Vec<Vec<(f64, f64)>> {
    let columns = rows.iter().map(Vec::len).min().unwrap_or(0);
    (0..columns).map(|j| rows.iter().map(|row| row[j]).collect()).collect()
}
