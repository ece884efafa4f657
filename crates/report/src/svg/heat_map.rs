//! Heat map of signed values: blue below zero, near white at zero, orange above (distinguishable with every kind of colour
//! vision, and by the printed numbers without any colour).

use super::element::{figure, line, text};
use crate::number::{signed, trimmed};

const WIDTH: f64 = 360.0;
const TOP: f64 = 20.0;
const CELL_HEIGHT: f64 = 21.0;
/// Mean width of a character of `−90°` in the widest of the usual fonts (DejaVu Sans), and room between two labels.
const DIGIT: f64 = 7.9;
const GAP: f64 = 5.0;
/// Width of a character of a number in a cell.
const CHARACTER: f64 = 6.2;
/// From here on a tenth of a micrometre is no more than a hundredth of the scale.
const WHOLE_FROM_UM: f64 = 10.0;

/// Values on a grid; NaN cells stay empty.
pub struct HeatMap<'a> {
    pub title: &'a str,
    pub columns: &'a [String],
    pub rows: &'a [String],
    pub columns_name: &'a str,
    pub rows_name: &'a str,
    /// Row after row, µm.
    pub values_um: &'a [Vec<f64>],
    /// Cells inside a frame, row after row; may be empty.
    pub framed: &'a [Vec<bool>],
    /// The value at the ends of the colour scale, µm.
    pub limit_um: f64,
}

/// The map as a figure.
pub fn heat_map(map: &HeatMap<'_>) -> String {
    let left = (length(map.rows) + GAP).max(24.0);
    let cell_width = (WIDTH - left - 2.0) / map.columns.len().max(1) as f64;
    let decimals = if map.limit_um < WHOLE_FROM_UM { 1 } else { 0 };
    // Without a plus: what a narrow cell has room for is the number, and its colour says the same.
    let number = |&value: &f64| signed(value, decimals).trim_start_matches('+').to_owned();
    let numbers: Vec<Vec<String>> =
        map.values_um.iter().map(|row| row.iter().map(number).collect()).collect();
    let longest = numbers.iter().flatten().map(|number| number.chars().count()).max().unwrap_or(0);
    // A map whose numbers would run into each other leaves them out.
    let is_numbered = longest as f64 * CHARACTER <= cell_width;
    let mut body = String::new();
    for (i, row) in map.values_um.iter().enumerate() {
        let y = TOP + i as f64 * CELL_HEIGHT;
        body += &text(left - 4.0, y + 15.0, "t end", map.rows.get(i).map_or("", String::as_str));
        for (j, &value) in row.iter().enumerate() {
            let x = left + j as f64 * cell_width;
            body += &cell(x, y, cell_width, value, map.limit_um);
            if is_numbered && value.is_finite() {
                let class = if dark(value / map.limit_um) { "cell light" } else { "cell" };
                body += &text(x + cell_width / 2.0, y + 14.0, class, &numbers[i][j]);
            }
        }
    }
    body += &frame(map.framed, left, cell_width);
    let bottom = TOP + map.values_um.len() as f64 * CELL_HEIGHT;
    let every = ((length(map.columns) + GAP) / cell_width).ceil().max(1.0) as usize;
    for (j, name) in map.columns.iter().enumerate().step_by(every) {
        body += &text(left + (j as f64 + 0.5) * cell_width, bottom + 13.0, "t mid", name);
    }
    body += &text(left, 13.0, "t", &format!("{} down, {} across; µm", map.rows_name, map.columns_name));
    figure(map.title, WIDTH, bottom + 19.0, map.title, &body)
}

/// How far the longest of these labels goes.
fn length(labels: &[String]) -> f64 {
    labels.iter().map(|label| label.chars().count()).max().unwrap_or(0) as f64 * DIGIT
}

/// Lines between cells inside and outside: dark on a white rim, because cells are light and a page may be dark.
fn frame(framed: &[Vec<bool>], left: f64, cell_width: f64) -> String {
    let inside = |i: isize, j: isize| {
        let cell = usize::try_from(i).ok().zip(usize::try_from(j).ok());
        cell.and_then(|(i, j)| framed.get(i)?.get(j).copied()).unwrap_or(false)
    };
    let corner =
        |i: isize, j: isize| (left + j as f64 * cell_width - 0.5, TOP + i as f64 * CELL_HEIGHT - 0.5);
    let (rows, columns) = (framed.len() as isize, framed.first().map_or(0, Vec::len) as isize);
    let mut lines = Vec::new();
    for i in 0..=rows {
        for j in 0..=columns {
            if inside(i, j) != inside(i - 1, j) {
                lines.push((corner(i, j), corner(i, j + 1)));
            }
            if inside(i, j) != inside(i, j - 1) {
                lines.push((corner(i, j), corner(i + 1, j)));
            }
        }
    }
    let drawn = |class: &'static str| lines.iter().map(move |&(from, to)| line(from, to, class));
    drawn("rim").chain(drawn("edge")).collect()
}

fn cell(x: f64, y: f64, width: f64, value_um: f64, limit_um: f64) -> String {
    if !value_um.is_finite() {
        return format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" class=\"hole\"/>\n",
            width - 1.0,
            CELL_HEIGHT - 1.0
        );
    }
    format!(
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>\n",
        width - 1.0,
        CELL_HEIGHT - 1.0,
        colour(value_um / limit_um)
    )
}

/// The signed colour scale with its numbers.
pub fn legend(limit_um: f64) -> String {
    let steps = 40;
    let width = 240.0 / f64::from(steps);
    let mut body = String::new();
    for i in 0..steps {
        let share = (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
        let x = 60.0 + f64::from(i) * width;
        body += &format!(
            "<rect x=\"{x:.1}\" y=\"4\" width=\"{:.1}\" height=\"12\" fill=\"{}\"/>\n",
            width + 0.3,
            colour(share)
        );
    }
    let end = trimmed(limit_um, 6);
    for (share, label) in [(-1.0, format!("−{end} µm")), (0.0, "0".into()), (1.0, format!("+{end} µm"))] {
        body += &text(180.0 + 120.0 * share, 29.0, "t mid", &label);
    }
    let caption = "Orange: the tool stands further in the positive direction than predicted; blue: in the negative. \
                   One scale for all maps.";
    figure("Colour scale of the residual", WIDTH, 34.0, caption, &body)
}

/// Blue (−1) – near white (0) – orange (+1).
fn colour(share: f64) -> String {
    const BLUE: [f64; 3] = [20.0, 84.0, 158.0];
    const PALE: [f64; 3] = [246.0, 246.0, 243.0];
    const ORANGE: [f64; 3] = [200.0, 84.0, 0.0];
    let share = share.clamp(-1.0, 1.0);
    let end = if share < 0.0 { BLUE } else { ORANGE };
    let mix = |k: usize| (PALE[k] + (end[k] - PALE[k]) * share.abs()).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

fn dark(share: f64) -> bool {
    share.abs() > 0.6
}
