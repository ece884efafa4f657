//! Lines and marks over two axes with round ticks.

use super::element::{figure, line, polyline, text};
use super::key::{FIRST_ROW, keys, length};
use super::mark::{Mark, symbol};
use super::scale::{Scale, extent};
use crate::number::tick;

const WIDTH: f64 = 360.0;
const LEFT: f64 = 46.0;
const RIGHT: f64 = 352.0;
/// Of the first row of the key to the plot, and the height of the plot.
const ABOVE: f64 = 13.0;
const UP: f64 = 148.0;
const HEIGHT_OF_REST: f64 = 38.0;
/// Height of a row of names of marks, and what stays free after each.
const NAME_ROW: f64 = 14.0;
const NAME_GAP: f64 = 8.0;

/// One set of points.
pub struct Series {
    pub name: String,
    pub mark: Mark,
    pub points: Vec<(f64, f64)>,
}

/// A chart.
pub struct XyChart<'a> {
    pub title: &'a str,
    pub x_name: &'a str,
    pub y_name: &'a str,
    pub series: &'a [Series],
    /// Ends of the y axis.
    pub y: (f64, f64),
    /// Places on x that are marked with a name.
    pub marks_on_x: &'a [(f64, String)],
}

/// The chart as a figure.
pub fn xy_chart(chart: &XyChart<'_>) -> String {
    // What is marked is in the picture, also where no point is.
    let all_x = chart.series.iter().flat_map(|s| s.points.iter().map(|p| p.0));
    let all_x = all_x.chain(chart.marks_on_x.iter().map(|(at, _)| *at));
    // The name of the axis stands before the key, in the same row.
    let entries: Vec<(Mark, &str)> = chart.series.iter().map(|s| (s.mark, s.name.as_str())).collect();
    let (mut body, last_row) = keys(&entries, LEFT.max(8.0 + length(chart.y_name)), (LEFT, RIGHT));
    let (top, bottom) = (last_row + ABOVE, last_row + ABOVE + UP);
    let x = Scale::new(extent(all_x).unwrap_or((0.0, 1.0)), (LEFT + 4.0, RIGHT - 4.0));
    let y = Scale::new(chart.y, (bottom, top));
    body += &axes(&x, &y, (top, bottom), [chart.x_name, chart.y_name]);
    let marks = chart.marks_on_x.iter().filter(|(at, _)| at.is_finite());
    body += &guides(marks.map(|(at, name)| (x.at(*at), name.as_str())), (top, bottom));
    for series in chart.series {
        // A line ends where a value is no number, and begins again after it.
        for stretch in series.points.split(|p| !(p.0.is_finite() && p.1.is_finite())) {
            let places: Vec<_> =
                stretch.iter().map(|p| (x.at(p.0), y.at(p.1.clamp(chart.y.0, chart.y.1)))).collect();
            body += &drawn(series.mark, &places);
        }
    }
    figure(chart.title, WIDTH, bottom + HEIGHT_OF_REST, chart.title, &body)
}

fn axes(x: &Scale, y: &Scale, (top, bottom): (f64, f64), [x_name, y_name]: [&str; 2]) -> String {
    let mut body = String::new();
    let (ticks, step) = y.ticks(5);
    for value in ticks {
        let class = if value == 0.0 { "zero" } else { "grid" };
        body += &line((LEFT, y.at(value)), (RIGHT, y.at(value)), class);
        body += &text(LEFT - 4.0, y.at(value) + 4.0, "t end", &tick(value, step));
    }
    let (ticks, step) = x.ticks(6);
    for value in ticks {
        body += &line((x.at(value), bottom), (x.at(value), bottom + 4.0), "axis");
        body += &text(x.at(value), bottom + 16.0, "t mid", &tick(value, step));
    }
    body += &line((LEFT, bottom), (RIGHT, bottom), "axis");
    body += &line((LEFT, top), (LEFT, bottom), "axis");
    body += &text((LEFT + RIGHT) / 2.0, bottom + 32.0, "t mid", x_name);
    body += &text(2.0, FIRST_ROW, "t", y_name);
    body
}

/// Upright lines with names above the lower axis: a name that would run into another stands a row higher, one that would leave the chart
/// left of its line.
fn guides<'n>(marks: impl Iterator<Item = (f64, &'n str)>, (top, bottom): (f64, f64)) -> String {
    let mut body = String::new();
    // Where the last name of each row ends.
    let mut rows: Vec<f64> = Vec::new();
    for (x, name) in marks {
        body += &line((x, top), (x, bottom), "guide");
        let width = length(name);
        let leaves = x + 2.0 + width > RIGHT;
        let begin = if leaves { x - 2.0 - width } else { x + 2.0 };
        let row = rows.iter().position(|end| *end < begin).unwrap_or(rows.len());
        let baseline = bottom - 4.0 - NAME_ROW * row as f64;
        // Of names without end those that have no room are left out; their lines stay.
        if baseline < top + NAME_ROW {
            continue;
        }
        rows.resize(rows.len().max(row + 1), 0.0);
        rows[row] = begin + width + NAME_GAP;
        let (at, class) = if leaves { (x - 2.0, "t end") } else { (begin, "t") };
        body += &text(at, baseline, class, name);
    }
    body
}

fn drawn(mark: Mark, places: &[(f64, f64)]) -> String {
    match mark.line_class() {
        Some(class) => polyline(places, false, class),
        None => places.iter().map(|&(x, y)| symbol(mark, x, y)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_beyond_the_points_stands_inside_the_axes() {
        let series = [Series { name: "wave".into(), mark: Mark::Line, points: vec![(2.2, 0.2), (5.8, 0.0)] }];
        let marks = [(1.94, "1".to_string())];
        let chart = XyChart {
            title: "",
            x_name: "",
            y_name: "µm",
            series: &series,
            y: (0.0, 0.5),
            marks_on_x: &marks,
        };
        let drawn = xy_chart(&chart);
        let guide = drawn.lines().find(|line| line.contains("class=\"guide\"")).unwrap();
        let x: f64 = guide.split('"').nth(1).unwrap().parse().unwrap();
        assert!((LEFT..=RIGHT).contains(&x), "{guide}");
    }

    #[test]
    fn names_of_marks_stand_apart_and_inside_the_chart() {
        let series = [Series { name: "r".into(), mark: Mark::Line, points: vec![(0.0, 0.0), (40.0, 1.0)] }];
        let marks = [0.0, 4.0, 8.0, 39.0].map(|at| (at, "a-long-name".to_string()));
        let chart = XyChart {
            title: "",
            x_name: "",
            y_name: "",
            series: &series,
            y: (-1.0, 1.0),
            marks_on_x: &marks,
        };
        let drawn = xy_chart(&chart);
        let number = |line: &str, k: usize| -> f64 { line.split('"').nth(k).unwrap().parse().unwrap() };
        let width = length(&marks[0].1);
        let names: Vec<(f64, f64)> = drawn
            .lines()
            .filter(|line| line.ends_with(">a-long-name</text>"))
            .map(|line| (number(line, 1) - if line.contains("t end") { width } else { 0.0 }, number(line, 3)))
            .collect();
        assert_eq!(names.len(), 4, "{drawn}");
        for (i, one) in names.iter().enumerate() {
            assert!(one.0 >= LEFT && one.0 + width <= RIGHT, "{names:?}");
            let meets = |other: &(f64, f64)| other.1 == one.1 && (other.0 - one.0).abs() < width;
            assert!(!names[i + 1..].iter().any(meets), "{names:?}");
        }
    }

    #[test]
    fn the_key_begins_where_the_name_of_the_axis_has_ended() {
        let series = [Series { name: "EX0C".into(), mark: Mark::Line, points: vec![(0.0, 0.0), (1.0, 1.0)] }];
        let y_name = "change (µrad)";
        let chart =
            XyChart { title: "", x_name: "", y_name, series: &series, y: (-1.0, 1.0), marks_on_x: &[] };
        let drawn = xy_chart(&chart);
        let at = |text: &str| -> f64 {
            let line = drawn.lines().find(|line| line.ends_with(&format!(">{text}</text>"))).unwrap();
            line.split('"').nth(1).unwrap().parse().unwrap()
        };
        assert!(at("EX0C") > at(y_name) + length(y_name), "{} {}", at("EX0C"), at(y_name));
    }
}
