//! Polar plot of a signed error around a zero circle, as roundness and error-motion charts are drawn.

use super::element::{figure, line, polyline, text};
use crate::number::with_unit;

const SIZE: f64 = 240.0;
const CENTRE: (f64, f64) = (120.0, 112.0);
const ZERO_RADIUS: f64 = 58.0;
const SWING: f64 = 36.0;

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
    for quarter in 0..4 {
        let angle = f64::from(quarter) * std::f64::consts::FRAC_PI_2;
        body += &line(CENTRE, place(angle, limit), "grid");
        let (x, y) = place(angle, limit * 1.22);
        body += &text(x, y + 4.0, "t mid", &format!("{}°", quarter * 90));
    }
    for (i, trace) in traces.iter().take(3).enumerate() {
        let mut points: Vec<_> =
            trace.points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()).copied().collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let span = points.last().zip(points.first()).map_or(0.0, |(last, first)| last.0 - first.0);
        let whole_turn = span > 5.0;
        let places: Vec<_> = points.iter().map(|&(angle, value)| place(angle, value)).collect();
        let class = format!("l{}", i + 1);
        body += &polyline(&places, whole_turn, &class);
        let y = 226.0;
        let x = 8.0 + 78.0 * i as f64;
        body += &line((x, y), (x + 14.0, y), &class);
        body += &text(x + 18.0, y + 4.0, "t", &trace.name);
    }
    let caption = format!("{title} (circles: −{0}, 0, +{0})", with_unit(limit, unit));
    figure(title, SIZE, 236.0, &caption, &body)
}
