//! Residual over time, and over the turning axis for recordings taken while it turned.

use crate::markup::escape;
use crate::number::trimmed;
use crate::svg::{Mark, Series, XyChart, end_above, xy_chart};
use crate::views::{Axes, component_name, component_names, direction, residuals_um, thinned, time_range_s};
use trunnion_core::convert::s_from_min;
use trunnion_results::{ResidualPoint, Residuals};

pub fn section(residuals: &Residuals) -> String {
    over_turning_axis(residuals) + &over_time(residuals)
}

fn over_time(residuals: &Residuals) -> String {
    if time_range_s(residuals).is_none() {
        return "<section><h2>Residual over time</h2><p>The points have no time, so drift is not observable.</p></section>\n"
            .into();
    }
    let minutes = |p: &ResidualPoint| p.time_s.map_or(f64::NAN, |t| t / s_from_min(1.0));
    let changes: Vec<_> = (0..residuals.setups.len())
        .filter_map(|s| {
            let first = residuals.points.iter().find(|p| p.setup == s)?;
            Some((minutes(first), residuals.setups[s].name.clone()))
        })
        .collect();
    let charts = charts(residuals, "time", "time (min)", &changes, minutes, [Mark::Dot, Mark::Triangle]);
    format!(
        "<section class=\"together\"><h2>Residual over time</h2>\n<div class=\"plots\">{charts}</div></section>\n"
    )
}

fn over_turning_axis(residuals: &Residuals) -> String {
    let Some(turning) = Axes::of(residuals).turning.filter(|_| residuals.on_the_fly) else {
        return String::new();
    };
    let angle = |p: &ResidualPoint| p.position[turning.index];
    let name = format!("{} (°)", turning.name);
    let charts = charts(residuals, turning.name, &name, &[], angle, [Mark::Line, Mark::Dashed]);
    format!(
        "<section><h2>Residual over {}, both ways</h2>\n<div class=\"plots\">{charts}</div></section>\n",
        turning.name
    )
}

/// One chart a component; forward and back apart.
fn charts(
    residuals: &Residuals,
    over: &str,
    x_name: &str,
    marks_on_x: &[(f64, String)],
    x_of: impl Fn(&ResidualPoint) -> f64,
    marks: [Mark; 2],
) -> String {
    let axes = Axes::of(residuals);
    let letter = axes.turning.map_or("", |axis| axis.name);
    let mut of_components = Vec::new();
    for component in component_names(residuals) {
        let way = |back: bool| -> Vec<(f64, f64)> {
            let points = residuals.points.iter().filter(|p| (direction(p, axes)[1] < 0) == back);
            let mut places: Vec<_> = points
                .flat_map(|p| residuals_um(residuals, p).map(move |(k, r)| (p, k, r)))
                .filter(|(p, k, _)| component_name(residuals, p, *k) == component)
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
    let y_limit = end_above(all.fold(0.0, |limit: f64, p| limit.max(p.1.abs())));
    let mut html = String::new();
    for (component, series) in &of_components {
        let title = format!("Component {component} over {over}; scale ±{} µm", trimmed(y_limit, 6));
        html += &xy_chart(&XyChart {
            title: &title,
            x_name,
            y_name: "µm",
            series,
            y: (-y_limit, y_limit),
            marks_on_x,
        });
    }
    if html.is_empty() { escape("Nothing to draw.") } else { html }
}
