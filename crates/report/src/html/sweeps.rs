//! Residual over time, and over the turning axis for recordings taken while it turned.

use crate::CompareInput;
use crate::markup::escape;
use crate::number::um;
use crate::svg::{Mark, Series, XyChart, nice_above, xy_chart};
use crate::views::{Axes, component_name, component_names, direction, residuals_um, thinned, time_range_s};
use trunnion_core::AxisLetter;
use trunnion_core::convert::{deg_from_rad, s_from_min};

pub fn section(input: &CompareInput) -> String {
    over_turning_axis(input) + &over_time(input)
}

fn over_time(input: &CompareInput) -> String {
    if time_range_s(input).is_none() {
        return "<section><h2>Residual over time</h2><p>The points have no time, so drift cannot be seen.</p></section>\n"
            .into();
    }
    let minutes = |p: &crate::PointView| p.time_s.map_or(f64::NAN, |t| t / s_from_min(1.0));
    let changes: Vec<_> = (0..input.setups.len())
        .filter_map(|s| {
            let first = input.points.iter().find(|p| p.setup == s)?;
            Some((minutes(first), input.setups[s].name.clone()))
        })
        .collect();
    let charts = charts(input, "time", "time (min)", &changes, minutes, [Mark::Dot, Mark::Triangle]);
    format!("<section><h2>Residual over time</h2>\n<div class=\"plots\">{charts}</div></section>\n")
}

fn over_turning_axis(input: &CompareInput) -> String {
    let Some(turning) = Axes::of(&input.rotary, &input.points).turning.filter(|_| input.on_the_fly) else {
        return String::new();
    };
    let angle = |p: &crate::PointView| deg_from_rad(p.position[turning]);
    let name = format!("{turning} (°)");
    let charts = charts(input, turning.as_str(), &name, &[], angle, [Mark::Line, Mark::Dashed]);
    format!(
        "<section><h2>Residual over {turning}, both ways</h2>\n<div class=\"plots\">{charts}</div></section>\n"
    )
}

/// One chart a component; forward and back apart.
fn charts(
    input: &CompareInput,
    over: &str,
    x_name: &str,
    marks_on_x: &[(f64, String)],
    x_of: impl Fn(&crate::PointView) -> f64,
    marks: [Mark; 2],
) -> String {
    let axes = Axes::of(&input.rotary, &input.points);
    let letter = axes.turning.map_or("", AxisLetter::as_str);
    let mut of_components = Vec::new();
    for component in component_names(input) {
        let way = |back: bool| -> Vec<(f64, f64)> {
            let points = input.points.iter().filter(|p| (direction(p, axes)[1] < 0) == back);
            let mut places: Vec<_> = points
                .flat_map(|p| residuals_um(input, p).map(move |(k, r)| (p, k, r)))
                .filter(|(p, k, _)| component_name(input, p, *k) == component)
                .map(|(p, _, r)| (x_of(p), r))
                .filter(|(x, _)| x.is_finite())
                .collect();
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            thinned(&places)
        };
        let name = |word: &str| if letter.is_empty() { word.into() } else { format!("{letter} {word}") };
        let series: Vec<_> = [("forward", false, marks[0]), ("back", true, marks[1])]
            .into_iter()
            .map(|(word, back, mark)| Series { name: name(word), mark, points: way(back) })
            .filter(|s| !s.points.is_empty())
            .collect();
        of_components.push((component, series));
    }
    let all = of_components.iter().flat_map(|(_, s)| s).flat_map(|s| &s.points);
    let y_limit = nice_above(all.fold(0.0, |limit: f64, p| limit.max(p.1.abs())));
    let mut html = String::new();
    for (component, series) in &of_components {
        let title = format!("Component {component} over {over}; scale ±{}", um(y_limit));
        html += &xy_chart(&XyChart { title: &title, x_name, y_name: "µm", series, y_limit, marks_on_x });
    }
    if html.is_empty() { escape("Nothing to draw.") } else { html }
}
