//! Polar plot of a signed error around a zero circle, as roundness and error-motion charts are drawn.

use super::element::{figure, line, polyline, text};
use super::key::keys;
use super::mark::Mark;
use crate::number::{trimmed, unit_on_screen};

/// Two stand next to each other on a phone, with labels of 11 px.
const SIZE: f64 = 188.0;
const CENTRE: (f64, f64) = (97.0, 84.0);
const ZERO_RADIUS: f64 = 42.0;
const SWING: f64 = 24.0;
/// Lower end of the circles with their angles.
const BOTTOM: f64 = 164.0;
/// Where the angles stand: class, and where they begin from the outer circle.
const ANGLES: [(&str, f64, f64); 4] =
    [("t", 3.0, 4.0), ("t mid", 0.0, -4.0), ("t end", -2.0, 4.0), ("t mid", 0.0, 13.0)];

/// One closed or open line: angle in rad, value in the unit of the plot.
pub struct Trace {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// The plot: `limit` is the value drawn at the outer circle; up to three traces are distinguished.
pub fn polar(title: &str, traces: &[Trace], limit: f64, unit: &str) -> String {
    let place = |angle: f64, value: f64| {
        let radius = ZERO_RADIUS + SWING * (value / limit).clamp(-1.5, 1.3);
        (CENTRE.0 + radius * angle.cos(), CENTRE.1 - radius * angle.sin())
    };
    let circle = |radius: f64, class: &str| {
        format!("<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" class=\"{class}\"/>\n", CENTRE.0, CENTRE.1)
    };
    let mut body = circle(ZERO_RADIUS + SWING, "grid") + &circle(ZERO_RADIUS - SWING, "grid");
    body += &circle(ZERO_RADIUS, "zero");
    for (quarter, (class, right, down)) in (0_u8..).zip(ANGLES) {
        let outer = place(f64::from(quarter) * std::f64::consts::FRAC_PI_2, limit);
        body += &line(CENTRE, outer, "grid");
        body += &text(outer.0 + right, outer.1 + down, class, &format!("{}°", u16::from(quarter) * 90));
    }
    let traces = || traces.iter().zip(Mark::LINES).take(3);
    for (trace, (_, class)) in traces() {
        let mut points: Vec<_> =
            trace.points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()).copied().collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let span = points.last().zip(points.first()).map_or(0.0, |(last, first)| last.0 - first.0);
        let whole_turn = span > 5.0;
        let places: Vec<_> = points.iter().map(|&(angle, value)| place(angle, value)).collect();
        body += &polyline(&places, whole_turn, class);
    }
    let entries: Vec<(Mark, &str)> = traces().map(|(trace, (mark, _))| (mark, trace.name.as_str())).collect();
    let (key, last_row) = keys(&entries, 0.0, (0.0, SIZE));
    body += &format!("<g transform=\"translate(0 {BOTTOM})\">{key}</g>\n");
    let caption = format!("{title} (circles: −{0}, 0, +{0} {1})", trimmed(limit, 6), unit_on_screen(unit));
    figure(title, SIZE, BOTTOM + last_row + 6.0, &caption, &body)
}
