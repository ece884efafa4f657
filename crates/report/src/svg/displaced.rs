//! Commanded, measured and predicted places in a plane, the deviations magnified (S1 Fig. 5 and 8).

use super::element::{figure, line, text};
use super::scale::Plane;
use crate::number::tick;

const WIDTH: f64 = 360.0;
const LEFT: f64 = 48.0;
const TOP: f64 = 22.0;
const SIDE: f64 = 304.0;
const LEAST_HEIGHT: f64 = 150.0;

/// One point, mm in the plane; measured and predicted already magnified.
pub struct Displaced {
    pub commanded: (f64, f64),
    pub measured: (f64, f64),
    /// `None` on a map of measurements alone.
    pub predicted: Option<(f64, f64)>,
}

impl Displaced {
    fn places(&self) -> impl Iterator<Item = (f64, f64)> + Clone {
        [Some(self.commanded), Some(self.measured), self.predicted].into_iter().flatten()
    }
}

/// The picture with equal scales; `names` of the axes across and up.
pub fn displaced(title: &str, caption: &str, names: (&str, &str), points: &[Displaced]) -> String {
    let finite = |p: &&Displaced| p.places().all(|(a, b)| a.is_finite() && b.is_finite());
    let points: Vec<_> = points.iter().filter(finite).collect();
    let places = || points.iter().flat_map(|p| p.places());
    let Plane { x, y, height, bottom } =
        Plane::around(places(), (1.1, 1.15), LEAST_HEIGHT, (LEFT, TOP, SIDE));
    let mut body =
        format!("<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{SIDE}\" height=\"{height:.1}\" class=\"frame\"/>\n");
    let (ticks, step) = x.ticks(6);
    for value in ticks {
        body += &line((x.at(value), TOP), (x.at(value), bottom), "grid");
        body += &text(x.at(value), bottom + 15.0, "t mid", &tick(value, step));
    }
    let (ticks, step) = y.ticks(5);
    for value in ticks {
        body += &line((LEFT, y.at(value)), (LEFT + SIDE, y.at(value)), "grid");
        body += &text(LEFT - 4.0, y.at(value) + 4.0, "t end", &tick(value, step));
    }
    for p in points {
        let at = |(a, b): (f64, f64)| (x.at(a), y.at(b));
        let expected = p.predicted.unwrap_or(p.commanded);
        body += &line(at(p.commanded), at(expected), "l3 thin");
        body += &line(at(expected), at(p.measured), "l2 solid");
        let (cx, cy) = at(p.commanded);
        body += &format!("<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"1.8\" class=\"ink\"/>\n");
        let (mx, my) = at(p.measured);
        body += &format!("<circle cx=\"{mx:.1}\" cy=\"{my:.1}\" r=\"3.4\" class=\"open\"/>\n");
        if let Some((px, py)) = p.predicted.map(at) {
            body += &line((px - 3.0, py - 3.0), (px + 3.0, py + 3.0), "l1");
            body += &line((px - 3.0, py + 3.0), (px + 3.0, py - 3.0), "l1");
        }
    }
    body += &text(LEFT + SIDE / 2.0, bottom + 31.0, "t mid", &format!("{} (mm)", names.0));
    body += &text(4.0, 13.5, "t", &format!("{} (mm)", names.1));
    figure(title, WIDTH, bottom + 37.0, caption, &body)
}
