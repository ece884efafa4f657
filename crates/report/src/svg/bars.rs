//! Bars lying down, one below the other, with a second mark each and one line for the repeatability.

use super::element::{figure, line, text};
use super::scale::Scale;
use crate::number::{plain, tick, um};

const WIDTH: f64 = 360.0;
const LEFT: f64 = 14.0;
const RIGHT: f64 = 248.0;
const ROW: f64 = 36.0;
const TOP: f64 = 24.0;

/// One bar, µm.
pub struct Bar {
    pub name: String,
    pub fit_um: f64,
    pub holdout_um: Option<f64>,
    /// Repeatability of this bar alone.
    pub noise_um: Option<f64>,
    /// Said beside the name; may be empty.
    pub remark: String,
}

/// The bars with the repeatability where it is known.
pub fn bars(title: &str, caption: &str, bars: &[Bar], noise_um: Option<f64>) -> String {
    let largest = bars.iter().flat_map(|bar| [Some(bar.fit_um), bar.holdout_um, bar.noise_um]);
    let largest = largest.flatten().chain(noise_um);
    let largest = largest.filter(|v| v.is_finite()).fold(0.0, f64::max);
    let x = Scale::new((0.0, if largest > 0.0 { largest } else { 1.0 }), (LEFT, RIGHT));
    let bottom = TOP + bars.len() as f64 * ROW;
    let (ticks, step) = x.ticks(6);
    let mut body = String::new();
    for value in ticks {
        body += &line((x.at(value), TOP), (x.at(value), bottom), "grid");
        body += &text(x.at(value), bottom + 15.0, "t mid", &tick(value, step));
    }
    body += &text(WIDTH - 4.0, bottom + 15.0, "t end", "µm rms");
    for (i, bar) in bars.iter().enumerate() {
        let y = TOP + i as f64 * ROW;
        if bar.fit_um.is_finite() {
            let width = (x.at(bar.fit_um) - LEFT).max(0.5);
            body += &format!(
                "<rect x=\"{LEFT}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"13\" class=\"bar\"/>\n",
                y + 16.0
            );
        }
        if let Some(noise) = bar.noise_um.filter(|n| n.is_finite()) {
            body += &line((x.at(noise), y + 13.0), (x.at(noise), y + 32.0), "floor");
        }
        let mut end = x.at(bar.fit_um);
        if let Some(holdout) = bar.holdout_um.filter(|h| h.is_finite()) {
            let (cx, cy) = (x.at(holdout), y + 22.5);
            body += &format!("<path d=\"M{:.1} {cy:.1}l5 -6l5 6l-5 6z\" class=\"m2 fill\"/>\n", cx - 5.0);
            end = end.max(cx + 4.0);
        }
        if end.is_finite() {
            let held_out = bar.holdout_um.filter(|h| h.is_finite());
            let label = held_out.map_or(um(bar.fit_um), |h| format!("{} ◆ {}", plain(bar.fit_um), um(h)));
            body += &text(end + 5.0, y + 27.0, "t halo", &label);
        }
    }
    if let Some(noise) = noise_um.filter(|n| n.is_finite()) {
        body += &line((x.at(noise), TOP - 4.0), (x.at(noise), bottom), "floor");
        body += &text(x.at(noise) + 3.0, TOP - 7.0, "t", &format!("repeatability {}", um(noise)));
    }
    for (i, bar) in bars.iter().enumerate() {
        let y = TOP + i as f64 * ROW;
        body += &text(LEFT, y + 11.0, "t halo", &bar.name);
        body += &text(WIDTH - 4.0, y + 11.0, "t end faint halo", &bar.remark);
    }
    figure(title, WIDTH, bottom + 22.0, caption, &body)
}
