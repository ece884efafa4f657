//! Amounts ranked: a bar each, its name above it, amount and remark at its end.

use super::element::{figure, text};
use super::scale::Scale;
use crate::number::plain;

const WIDTH: f64 = 360.0;
const LEFT: f64 = 14.0;
const RIGHT: f64 = 210.0;
const ROW: f64 = 34.0;

/// One bar.
pub struct Ranked {
    pub name: String,
    pub amount: f64,
    /// Said next to the amount; may be empty.
    pub remark: String,
}

/// The bars from zero to the largest, as they come.
pub fn ranked(title: &str, unit: &str, bars: &[Ranked]) -> String {
    let largest = bars.iter().map(|bar| bar.amount).filter(|amount| amount.is_finite()).fold(0.0, f64::max);
    let x = Scale::new((0.0, if largest > 0.0 { largest } else { 1.0 }), (LEFT, RIGHT));
    let mut body = String::new();
    for (i, bar) in bars.iter().enumerate() {
        let y = i as f64 * ROW;
        let width = (x.at(bar.amount.max(0.0)) - LEFT).max(0.5);
        body += &text(LEFT, y + 11.0, "t halo", &bar.name);
        body += &format!(
            "<rect x=\"{LEFT}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"12\" class=\"bar\"/>\n",
            y + 15.0
        );
        let amount = format!("{} {unit}", plain(bar.amount));
        let label = if bar.remark.is_empty() { amount } else { format!("{amount} · {}", bar.remark) };
        body += &text(LEFT + width + 5.0, y + 25.0, "t halo", &label);
    }
    figure(title, WIDTH, bars.len() as f64 * ROW + 4.0, title, &body)
}
