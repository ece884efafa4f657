//! Bars lying down, one below the other, with a second mark each and one line for the repeatability.

use super::element::{figure, line, text};
use super::key::length;
use super::scale::Scale;
use crate::number::{plain, tick, um};

const WIDTH: f64 = 360.0;
const LEFT: f64 = 14.0;
/// The end of the longest bar, where its figure leaves so much.
const RIGHT: f64 = 248.0;
const ROW: f64 = 36.0;
const TOP: f64 = 24.0;
/// Nothing is written beyond it.
const EDGE: f64 = WIDTH - 4.0;
/// From a mark to the figure next to it.
const GAP: f64 = 5.0;
/// Half a diamond.
const DIAMOND: f64 = 5.0;

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

impl Bar {
    fn holdout_um(&self) -> Option<f64> {
        self.holdout_um.filter(|h| h.is_finite())
    }

    /// Its figures.
    fn label(&self) -> String {
        self.holdout_um().map_or(um(self.fit_um), |h| format!("{} ◆ {}", plain(self.fit_um), um(h)))
    }
}

/// The bars with the repeatability where it is known.
pub fn bars(title: &str, caption: &str, bars: &[Bar], noise_um: Option<f64>) -> String {
    let noise_um = noise_um.filter(|n| n.is_finite());
    let largest = bars.iter().flat_map(|bar| [Some(bar.fit_um), bar.holdout_um, bar.noise_um]);
    let largest = largest.flatten().chain(noise_um);
    let largest = largest.filter(|v| v.is_finite()).fold(0.0, f64::max);
    let label = bars.iter().map(|bar| length(&bar.label())).fold(0.0, f64::max);
    let right = RIGHT.min(EDGE - GAP - DIAMOND - label);
    let x = Scale::new((0.0, if largest > 0.0 { largest } else { 1.0 }), (LEFT, right));
    let bottom = TOP + bars.len() as f64 * ROW;
    let (ticks, step) = x.ticks(6);
    let mut body = String::new();
    for value in ticks {
        body += &line((x.at(value), TOP), (x.at(value), bottom), "grid");
        body += &text(x.at(value), bottom + 15.0, "t mid", &tick(value, step));
    }
    body += &text(EDGE, bottom + 15.0, "t end", "µm rms");
    for (i, bar) in bars.iter().enumerate().filter(|(_, bar)| bar.fit_um.is_finite()) {
        let (y, width) = (TOP + i as f64 * ROW + 16.0, (x.at(bar.fit_um) - LEFT).max(0.5));
        body +=
            &format!("<rect x=\"{LEFT}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"13\" class=\"bar\"/>\n");
    }
    if let Some(noise) = noise_um {
        let at = x.at(noise);
        body += &line((at, TOP - 4.0), (at, bottom), "floor");
        // On the side with more room, in every language.
        let (place, class) = if at < WIDTH / 2.0 { (at + 3.0, "t") } else { (at - 3.0, "t end") };
        body += &text(place, TOP - 7.0, class, &format!("repeatability {}", um(noise)));
    }
    for (i, bar) in bars.iter().enumerate() {
        body += &marks(bar, TOP + i as f64 * ROW, &x, noise_um);
    }
    figure(title, WIDTH, bottom + 22.0, caption, &body)
}

/// Name, figures and marks of one bar whose row begins at `y`, next to the line of the repeatability.
fn marks(bar: &Bar, y: f64, x: &Scale, noise_um: Option<f64>) -> String {
    let mut body = String::new();
    let own = bar.noise_um.filter(|n| n.is_finite());
    if let Some(noise) = own {
        body += &line((x.at(noise), y + 13.0), (x.at(noise), y + 32.0), "floor");
    }
    let mut end = x.at(bar.fit_um);
    if let Some(holdout) = bar.holdout_um() {
        let (cx, cy) = (x.at(holdout), y + 22.5);
        let left = cx - DIAMOND;
        body += &format!("<path d=\"M{left:.1} {cy:.1}l5 -6l5 6l-5 6z\" class=\"m2 fill\"/>\n");
        end = end.max(cx + DIAMOND);
    }
    if end.is_finite() {
        let label = bar.label();
        // A line that would run through the figures has them behind it.
        let mut lines: Vec<f64> = own.into_iter().chain(noise_um).map(|noise| x.at(noise)).collect();
        lines.sort_by(f64::total_cmp);
        for at in lines {
            if (end..end + GAP + length(&label)).contains(&at) {
                end = at;
            }
        }
        body += &text(end + GAP, y + 27.0, "t halo", &label);
    }
    body += &text(LEFT, y + 11.0, "t halo", &bar.name);
    body + &text(EDGE, y + 11.0, "t end faint halo", &bar.remark)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(fit_um: f64, holdout_um: Option<f64>) -> Bar {
        Bar { name: "now".into(), fit_um, holdout_um, noise_um: None, remark: String::new() }
    }

    /// From where to where each text that holds `part` goes, and its class.
    fn spans(drawn: &str, part: &str) -> Vec<(f64, f64)> {
        let texts = drawn.lines().filter(|line| line.starts_with("<text") && line.contains(part));
        texts
            .map(|line| {
                let at: f64 = line.split('"').nth(1).unwrap().parse().unwrap();
                let width = length(line.split(['>', '<']).nth(2).unwrap());
                if line.contains("t end") { (at - width, at) } else { (at, at + width) }
            })
            .collect()
    }

    #[test]
    fn nothing_is_cut_at_an_edge_and_no_line_runs_through_a_figure() {
        for (fit, held_out, noise) in [
            (0.30, None, 0.35),
            (0.30, Some(0.31), 0.35),
            (0.34, None, 0.35),
            (12.34, Some(12.35), 0.35),
            (12.34, Some(12.35), 12.3),
            (1.0, None, 0.49),
        ] {
            let drawn = bars("", "", &[bar(fit, held_out), bar(0.6 * fit, None)], Some(noise));
            let at = drawn.lines().find(|line| line.contains("floor")).unwrap();
            let at: f64 = at.split('"').nth(1).unwrap().parse().unwrap();
            let figures = spans(&drawn, " µm<");
            assert_eq!(figures.len(), 3, "{drawn}");
            for (from, to) in figures {
                assert!(from >= 0.0 && to <= WIDTH, "{fit} {noise}: {from} to {to}");
                assert!(!(from..to).contains(&at), "{fit} {noise}: {at} runs through {from} to {to}");
            }
        }
    }
}
