//! Drawings as SVG text: few elements, one decimal, white ground so that they read on any page.

use super::views::{Drawing, Plot, Series};
use std::fmt::Write;
use trunnion_core::number::fixed;

const WIDTH: f64 = 640.0;
/// Shades from blue (negative) over white to red.
const SHADES: [&str; 11] = [
    "#2166ac", "#4a8bc0", "#79b0d5", "#a9cee5", "#d5e7f2", "#f7f7f7", "#fae0d3", "#f7bb9c", "#e88a70",
    "#d2554a", "#b2182b",
];

pub(super) fn draw(drawing: &Drawing) -> String {
    let mut body = String::new();
    let height = match &drawing.plot {
        Plot::Maps { b_deg, c_deg, xyz_um } => maps(&mut body, b_deg, c_deg, xyz_um),
        Plot::Curves { x_label, y_label, series } => curves(&mut body, x_label, y_label, series),
        Plot::Polar { traces } => polar(&mut body, traces),
    };
    let [what, how] = &drawing.caption;
    let mut svg = String::new();
    line(
        &mut svg,
        format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" \
             font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">"
        ),
    );
    line(&mut svg, format_args!("<title>{}</title>", escaped(what)));
    line(&mut svg, format_args!("<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fff\"/>"));
    line(&mut svg, format_args!("<text x=\"10\" y=\"18\" font-weight=\"bold\">{}</text>", escaped(what)));
    line(&mut svg, format_args!("<text x=\"10\" y=\"34\" fill=\"#555\">{}</text>", escaped(how)));
    svg.push_str(&body);
    svg.push_str("</svg>\n");
    svg
}

fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    writeln!(text, "{arguments}").expect("a String takes everything");
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

fn text(body: &mut String, x: f64, y: f64, anchor: &str, content: &str) {
    line(
        body,
        format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", escaped(content)),
    );
}

/// A number of about two digits, with a true minus sign.
fn number(value: f64) -> String {
    let digits = if value.abs() >= 9.95 || value == 0.0 {
        0
    } else if value.abs() >= 0.095 {
        1
    } else {
        2
    };
    let text = fixed(value, digits);
    let trimmed = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    trimmed.into()
}

fn maps(body: &mut String, b_deg: &[f64], c_deg: &[f64], xyz_um: &[Vec<f64>; 3]) -> f64 {
    let (left, top, cell_w, cell_h, gap) = (48.0, 62.0, 7.0, 9.0, 14.0);
    let (w, h) = (cell_w * c_deg.len() as f64, cell_h * b_deg.len() as f64);
    let largest = xyz_um.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs())).max(1e-9);
    for (k, (values, name)) in xyz_um.iter().zip(["x", "y", "z"]).enumerate() {
        let x0 = left + k as f64 * (w + gap);
        text(body, x0 + w / 2.0, top - 6.0, "middle", name);
        for (shade, colour) in SHADES.iter().enumerate() {
            let path =
                cells(values, c_deg.len(), |v| shade_of(v / largest) == shade, (x0, top, cell_w, cell_h));
            if !path.is_empty() {
                line(body, format_args!("<path fill=\"{colour}\" d=\"{path}\"/>"));
            }
        }
        line(
            body,
            format_args!(
                "<rect x=\"{x0:.1}\" y=\"{top:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" fill=\"none\" stroke=\"#888\"/>"
            ),
        );
        for c in [0.0, 180.0, 345.0] {
            let column = c_deg.iter().position(|known| (known - c).abs() < 1e-9).unwrap_or(0) as f64;
            text(body, x0 + (column + 0.5) * cell_w, top + h + 14.0, "middle", &number(c));
        }
        text(body, x0 + w / 2.0, top + h + 28.0, "middle", "C, °");
    }
    for (row, b) in b_deg.iter().enumerate().filter(|(_, b)| (*b / 90.0).fract().abs() < 1e-9) {
        let y = top + h - (row as f64 + 0.5) * cell_h + 4.0;
        text(body, left - 4.0, y, "end", &number(*b));
    }
    text(body, left - 34.0, top - 6.0, "start", "B, °");
    // Scale of the colours.
    let (x, y) = (left + 3.0 * (w + gap), top);
    let step = h / SHADES.len() as f64;
    for (i, colour) in SHADES.iter().rev().enumerate() {
        line(
            body,
            format_args!(
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"10\" height=\"{:.1}\" fill=\"{colour}\"/>",
                y + i as f64 * step,
                step + 0.3
            ),
        );
    }
    for (share, value) in [(0.0, largest), (0.5, 0.0), (1.0, -largest)] {
        text(body, x + 14.0, y + share * h + 4.0, "start", &number(value));
    }
    text(body, x, y - 6.0, "start", "µm");
    top + h + 38.0
}

fn shade_of(share: f64) -> usize {
    ((share.clamp(-1.0, 1.0) + 1.0) / 2.0 * (SHADES.len() - 1) as f64).round() as usize
}

/// Rectangles of the cells that `wanted` picks, neighbours in a row joined; row 0 at the bottom.
fn cells(
    values: &[f64],
    columns: usize,
    wanted: impl Fn(f64) -> bool,
    (x0, y0, w, h): (f64, f64, f64, f64),
) -> String {
    let rows = values.len() / columns;
    let mut path = String::new();
    for (row, of_row) in values.chunks(columns).enumerate() {
        let y = y0 + (rows - 1 - row) as f64 * h;
        let mut column = 0;
        while column < columns {
            let run = of_row[column..].iter().take_while(|v| wanted(**v)).count();
            if run > 0 {
                let (x, width) = (x0 + column as f64 * w, run as f64 * w);
                write!(path, "M{x} {y}h{width}v{h}h-{width}z").expect("a String takes everything");
            }
            column += run.max(1);
        }
    }
    path
}

fn curves(body: &mut String, x_label: &str, y_label: &str, series: &[Series]) -> f64 {
    let (left, top, w, h) = (56.0, 58.0, 480.0, 150.0);
    let all = || series.iter().flat_map(|s| s.points.iter().copied());
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let (x_low, x_high) = range(&mut all().map(|p| p.0));
    let (low, high) = range(&mut all().map(|p| p.1).chain([0.0]));
    let margin = 0.06 * (high - low).max(1e-9);
    let (y_low, y_high) = (low - margin, high + margin);
    let at = |(x, y): (f64, f64)| {
        (left + (x - x_low) / (x_high - x_low) * w, top + h - (y - y_low) / (y_high - y_low) * h)
    };
    for tick in ticks(y_low, y_high) {
        let (_, y) = at((x_low, tick));
        let colour = if tick == 0.0 { "#888" } else { "#e2e2e2" };
        line(body, format_args!("<path stroke=\"{colour}\" d=\"M{left} {y:.1}h{w}\"/>"));
        text(body, left - 5.0, y + 4.0, "end", &number(tick));
    }
    for tick in ticks(x_low, x_high) {
        let (x, _) = at((tick, y_low));
        text(body, x, top + h + 16.0, "middle", &number(tick));
    }
    line(
        body,
        format_args!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" fill=\"none\" stroke=\"#888\"/>"
        ),
    );
    text(body, left + w / 2.0, top + h + 32.0, "middle", x_label);
    text(body, 10.0, top - 4.0, "start", y_label);
    for s in series {
        polyline(body, s, s.points.iter().map(|p| at(*p)), false);
    }
    legend(body, series, left + w + 14.0, top + 12.0);
    top + h + 42.0
}

/// Round numbers within a range, zero among them where it lies inside.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 5.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

fn polyline(body: &mut String, series: &Series, points: impl Iterator<Item = (f64, f64)>, closed: bool) {
    let mut path = String::new();
    for (i, (x, y)) in points.enumerate() {
        write!(path, "{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" }).expect("a String takes everything");
    }
    let dashes = if series.dashed { " stroke-dasharray=\"5 3\"" } else { "" };
    let end = if closed { "Z" } else { "" };
    line(
        body,
        format_args!(
            "<path fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"{dashes} d=\"{path}{end}\"/>",
            series.colour
        ),
    );
}

fn legend(body: &mut String, series: &[Series], x: f64, y: f64) {
    for (i, s) in series.iter().filter(|s| !s.name.is_empty()).enumerate() {
        let y = y + 18.0 * i as f64;
        let dashes = if s.dashed { " stroke-dasharray=\"5 3\"" } else { "" };
        line(
            body,
            format_args!(
                "<path stroke=\"{}\" stroke-width=\"2\"{dashes} d=\"M{x:.1} {:.1}h22\"/>",
                s.colour,
                y - 4.0
            ),
        );
        text(body, x + 28.0, y, "start", &s.name);
    }
}

fn polar(body: &mut String, traces: &[Series]) -> f64 {
    let (cx, cy, r) = (160.0, 170.0, 85.0);
    let largest = traces.iter().flat_map(|s| &s.points).fold(0.0f64, |m, p| m.max(p.1.abs())).max(1e-9);
    let unit = ticks(0.0, largest * 1.01).last().copied().filter(|u| *u > 0.0).unwrap_or(largest);
    // The largest deviation is drawn as 0.4 of the radius.
    let per_um = 0.4 * r / largest;
    for (value, width) in [(-unit, 0.6), (0.0, 1.2), (unit, 0.6)] {
        line(
            body,
            format_args!(
                "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{:.1}\" fill=\"none\" stroke=\"#aaa\" stroke-width=\"{width}\"/>",
                r + value * per_um
            ),
        );
    }
    line(
        body,
        format_args!(
            "<path stroke=\"#ddd\" d=\"M{} {cy}H{}M{cx} {}V{}\"/>",
            cx - 1.45 * r,
            cx + 1.45 * r,
            cy - 1.45 * r,
            cy + 1.45 * r
        ),
    );
    text(body, cx + 1.5 * r, cy + 4.0, "start", "+X");
    text(body, cx + 6.0, cy - 1.4 * r, "start", "+Y");
    for s in traces {
        let point = |&(angle, value): &(f64, f64)| {
            let radius = r + value * per_um;
            (cx + radius * angle.cos(), cy - radius * angle.sin())
        };
        polyline(body, s, s.points.iter().map(point), true);
    }
    legend(body, traces, 340.0, 80.0);
    let below = 80.0 + 18.0 * traces.len() as f64 + 10.0;
    text(body, 340.0, below, "start", &format!("thin circles: ±{} µm", number(unit)));
    text(body, 340.0, below + 18.0, "start", "outward: radius too large");
    cy + 1.45 * r + 14.0
}
