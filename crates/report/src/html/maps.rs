//! Residual maps over both rotary axes: per component, setup and direction.

use crate::CompareInput;
use crate::markup::escape;
use crate::number::degrees;
use crate::svg::{HeatMap, heat_map, legend, nice_above};
use crate::views::{
    Axes, at_station, component_name, component_names, direction, direction_name, directions, mean,
    residuals_um, stations,
};

struct Map {
    title: String,
    component: String,
    values_um: Vec<Vec<f64>>,
}

pub fn section(input: &CompareInput) -> String {
    let axes = Axes::of(&input.points);
    let (Some(tilting), Some(turning)) = (axes.tilting, axes.turning) else {
        return String::new();
    };
    let rows: Vec<_> = stations(&input.points, tilting).into_iter().map(degrees).collect();
    let columns: Vec<_> = stations(&input.points, turning).into_iter().map(degrees).collect();
    let maps = maps(input, axes);
    let largest = maps.iter().flat_map(|m| m.values_um.iter().flatten()).filter(|v| v.is_finite());
    let limit_um = nice_above(largest.fold(0.0, |limit: f64, v| limit.max(v.abs())));
    let mut body = format!("<div class=\"key\">{}</div>\n", legend(limit_um));
    for component in component_names(input) {
        let drawn = maps.iter().filter(|m| m.component == component).map(|m| {
            heat_map(&HeatMap {
                title: &m.title,
                columns: &columns,
                rows: &rows,
                columns_name: turning.as_str(),
                rows_name: tilting.as_str(),
                values_um: &m.values_um,
                limit_um,
            })
        });
        body += &format!(
            "<h3>Component {}</h3>\n<div class=\"plots\">{}</div>\n",
            escape(&component),
            drawn.collect::<String>()
        );
    }
    format!("<section class=\"page\"><h2>Residual over {tilting} and {turning}</h2>\n{body}</section>\n")
}

/// One map for each component, setup and direction that holds anything.
fn maps(input: &CompareInput, axes: Axes) -> Vec<Map> {
    let (Some(tilting), Some(turning)) = (axes.tilting, axes.turning) else { return Vec::new() };
    let (tilts, turns) = (stations(&input.points, tilting), stations(&input.points, turning));
    let mut maps = Vec::new();
    for (s, setup) in input.setups.iter().enumerate() {
        for signs in directions(&input.points, axes) {
            let points: Vec<_> =
                input.points.iter().filter(|p| p.setup == s && direction(p, axes) == signs).collect();
            if points.is_empty() {
                continue;
            }
            for (k, component) in setup.components.iter().enumerate().take(3) {
                let cell = |tilt: f64, turn: f64| {
                    let here = points.iter().filter(|p| {
                        at_station(p, tilting, tilt, &tilts) && at_station(p, turning, turn, &turns)
                    });
                    mean(here.flat_map(|p| residuals_um(input, p)).filter(|(j, _)| *j == k).map(|(_, r)| r))
                };
                let values_um: Vec<Vec<f64>> =
                    tilts.iter().map(|&tilt| turns.iter().map(|&turn| cell(tilt, turn)).collect()).collect();
                debug_assert_eq!(component_name(input, points[0], k), component);
                maps.push(Map {
                    title: format!("{component}, setup {}, {}", setup.name, direction_name(signs, axes)),
                    component: component.clone(),
                    values_um,
                });
            }
        }
    }
    maps
}
