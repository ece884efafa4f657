//! Residual maps over both rotary axes: per component, setup and direction.

use crate::markup::escape;
use crate::number::degrees;
use crate::svg::{HeatMap, end_above, heat_map, legend};
use crate::views::{
    Axes, Axis, at_station, component_names, components, direction, direction_name, directions, mean,
    residuals_um, stations,
};
use trunnion_core::convert::rad_from_deg;
use trunnion_results::{Place, ResidualPoint, Residuals};

/// What the colours mean, where no scale is drawn.
pub const KEY: &str =
    "Orange: the tool stands further in the positive direction than predicted; blue: in the negative.";

/// Stations of both rotary axes.
pub struct Grid<'a> {
    axes: Axes<'a>,
    tilting: Axis<'a>,
    turning: Axis<'a>,
    tilts: Vec<f64>,
    turns: Vec<f64>,
}

/// Residual of one component, setup and direction on the grid.
pub struct Map {
    pub title: String,
    pub component: String,
    /// Tilt after tilt, µm; NaN where nothing was read.
    pub values_um: Vec<Vec<f64>>,
    /// Cells to be framed.
    pub framed: Vec<Vec<bool>>,
}

impl<'a> Grid<'a> {
    /// `None` unless two rotary axes moved.
    pub fn of(residuals: &'a Residuals) -> Option<Self> {
        let axes = Axes::of(residuals);
        let (tilting, turning) = (axes.tilting?, axes.turning?);
        let [tilts, turns] = [tilting, turning].map(|axis| stations(&residuals.points, axis));
        Some(Self { axes, tilting, turning, tilts, turns })
    }
}

impl Map {
    /// The map as a figure; values at `limit_um` have the full colour.
    pub fn figure(&self, grid: &Grid<'_>, limit_um: f64, title: &str) -> String {
        let degrees =
            |stations: &[f64]| stations.iter().map(|&at| degrees(rad_from_deg(at))).collect::<Vec<_>>();
        heat_map(&HeatMap {
            title,
            columns: &degrees(&grid.turns),
            rows: &degrees(&grid.tilts),
            columns_name: grid.turning.name,
            rows_name: grid.tilting.name,
            values_um: &self.values_um,
            framed: &self.framed,
            limit_um,
        })
    }

    /// Mean square of its cells, µm².
    pub fn mean_square(&self) -> f64 {
        let cells = || self.values_um.iter().flatten().filter(|v| v.is_finite());
        cells().map(|v| v * v).sum::<f64>() / (cells().count().max(1)) as f64
    }
}

pub fn section(residuals: &Residuals) -> String {
    let Some(grid) = Grid::of(residuals) else { return String::new() };
    let maps = maps(residuals, &grid);
    let limit_um = limit_um(&maps);
    let mut body = format!("<div class=\"key\">{}</div>\n", legend(limit_um));
    for component in component_names(residuals) {
        let drawn = maps.iter().filter(|m| m.component == component);
        let drawn: String = drawn.map(|m| m.figure(&grid, limit_um, &m.title)).collect();
        body += &format!("<h3>Component {}</h3>\n<div class=\"plots\">{drawn}</div>\n", escape(component));
    }
    format!(
        "<section class=\"page\"><h2>Residual over {} and {}</h2>\n{body}</section>\n",
        grid.tilting.name, grid.turning.name
    )
}

/// One map for each component, setup and direction that holds anything.
pub fn maps(residuals: &Residuals, grid: &Grid<'_>) -> Vec<Map> {
    let mut maps = Vec::new();
    for (s, setup) in residuals.setups.iter().enumerate() {
        for signs in directions(&residuals.points, grid.axes) {
            let points: Vec<_> = residuals
                .points
                .iter()
                .filter(|p| p.setup == s && direction(p, grid.axes) == signs)
                .collect();
            if points.is_empty() {
                continue;
            }
            for (k, component) in components(residuals, s).into_iter().enumerate() {
                let cell = |tilt: f64, turn: f64| {
                    let here = points.iter().filter(|p| {
                        at_station(p, grid.tilting, tilt, &grid.tilts)
                            && at_station(p, grid.turning, turn, &grid.turns)
                    });
                    mean(
                        here.flat_map(|p| residuals_um(residuals, p))
                            .filter(|(j, _)| *j == k)
                            .map(|(_, r)| r),
                    )
                };
                let row = |&tilt: &f64| grid.turns.iter().map(|&turn| cell(tilt, turn)).collect();
                maps.push(Map {
                    title: format!("{component}, setup {}, {}", setup.name, direction_name(signs, grid.axes)),
                    component: component.into(),
                    values_um: grid.tilts.iter().map(row).collect(),
                    framed: Vec::new(),
                });
            }
        }
    }
    maps
}

/// The component of a place over the grid, taken as its words say (setup, direction, time), its cells framed; `None` for a
/// component that is not read in three directions.
pub fn of_place(residuals: &Residuals, grid: &Grid<'_>, place: &Place) -> Option<Map> {
    let region = &place.region;
    let value = |p: &ResidualPoint| -> Option<f64> {
        let goes = |axis: &Option<String>, wanted: i8| {
            axis.as_deref().is_none_or(|axis| way(residuals, p, axis) == wanted)
        };
        if !goes(&region.forward, 1) || !goes(&region.back, -1) {
            return None;
        }
        let weight = match region.turns.as_deref().map(|axis| way(residuals, p, axis)) {
            Some(0) => return None,
            Some(sign) => f64::from(sign),
            None => 1.0,
        };
        let in_setup = region.setup.is_none_or(|setup| setup == p.setup);
        let in_time =
            region.time_s.is_none_or(|[from, to]| p.time_s.is_some_and(|t| (from..=to).contains(&t)));
        let three = components(residuals, p.setup).len() == 3;
        if p.excluded || !in_setup || !in_time || !three {
            return None;
        }
        let component = match region.component {
            k @ 0..3 => p.tool_residual_um[k],
            k @ 3..6 => p.tool_residual_in_table_um[k - 3],
            _ => return None,
        };
        Some(component * weight).filter(|v| v.is_finite())
    };
    let cell = |tilt: f64, turn: f64| {
        let here = residuals.points.iter().filter(|p| {
            at_station(p, grid.tilting, tilt, &grid.tilts) && at_station(p, grid.turning, turn, &grid.turns)
        });
        mean(here.filter_map(value))
    };
    let inside = |tilt: f64, turn: f64| {
        [(grid.tilting, tilt), (grid.turning, turn)].into_iter().all(|(axis, at)| {
            region.axes.iter().filter(|range| range.axis == axis.name).all(|range| {
                const NEAR_DEG: f64 = 0.05;
                let (above, below) = (at >= range.from - NEAR_DEG, at <= range.to + NEAR_DEG);
                if range.from <= range.to { above && below } else { above || below }
            })
        })
    };
    let over_grid = |of: &dyn Fn(f64, f64) -> f64| -> Vec<Vec<f64>> {
        grid.tilts.iter().map(|&tilt| grid.turns.iter().map(|&turn| of(tilt, turn)).collect()).collect()
    };
    let values_um = over_grid(&cell);
    if !values_um.iter().flatten().any(|v| v.is_finite()) {
        return None;
    }
    let framed = grid.tilts.iter().map(|&tilt| grid.turns.iter().map(|&turn| inside(tilt, turn)).collect());
    let how =
        place.turns_with.as_ref().map_or(String::new(), |axis| format!(", {axis} forward less back, halved"));
    Some(Map {
        title: format!("{}{how}", place.component),
        component: place.component.clone(),
        values_um,
        framed: framed.collect(),
    })
}

/// Direction of travel of the axis of this name; 0 where it is not known.
fn way(residuals: &Residuals, point: &ResidualPoint, axis: &str) -> i8 {
    let index = residuals.axes.iter().position(|known| known.name == axis);
    index.map_or(0, |index| point.direction[index])
}

/// A round number above every value.
pub fn limit_um<'a>(maps: impl IntoIterator<Item = &'a Map>) -> f64 {
    let largest = maps.into_iter().flat_map(|m| m.values_um.iter().flatten()).filter(|v| v.is_finite());
    end_above(largest.fold(0.0, |limit: f64, v| limit.max(v.abs())))
}
