//! Residual maps over both rotary axes: per component, setup and direction.

use crate::markup::escape;
use crate::number::degrees;
use crate::svg::{HeatMap, heat_map, legend, nice_above};
use crate::views::{
    Axes, at_station, component_names, components, direction, direction_name, directions, mean, residuals_um,
    stations,
};
use crate::{CompareInput, PointView};
use trunnion_core::AxisLetter;
use trunnion_core::convert::um_from_mm;
use trunnion_engine::compare::{Place, Way};

/// What the colours mean, where no scale is drawn.
pub const KEY: &str =
    "Orange: the tool stands further in the positive direction than predicted; blue: in the negative.";

/// Stations of both rotary axes.
pub struct Grid {
    axes: Axes,
    tilting: AxisLetter,
    turning: AxisLetter,
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

impl Grid {
    /// `None` unless two rotary axes moved.
    pub fn of(input: &CompareInput) -> Option<Self> {
        let axes = Axes::of(&input.rotary, &input.points);
        let (tilting, turning) = (axes.tilting?, axes.turning?);
        let [tilts, turns] = [tilting, turning].map(|letter| stations(&input.points, letter));
        Some(Self { axes, tilting, turning, tilts, turns })
    }
}

impl Map {
    /// The map as a figure; values at `limit_um` have the full colour.
    pub fn figure(&self, grid: &Grid, limit_um: f64, title: &str) -> String {
        let degrees = |stations: &[f64]| stations.iter().copied().map(degrees).collect::<Vec<_>>();
        heat_map(&HeatMap {
            title,
            columns: &degrees(&grid.turns),
            rows: &degrees(&grid.tilts),
            columns_name: grid.turning.as_str(),
            rows_name: grid.tilting.as_str(),
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

pub fn section(input: &CompareInput) -> String {
    let Some(grid) = Grid::of(input) else { return String::new() };
    let maps = maps(input, &grid);
    let limit_um = limit_um(&maps);
    let mut body = format!("<div class=\"key\">{}</div>\n", legend(limit_um));
    for component in component_names(input) {
        let drawn = maps.iter().filter(|m| m.component == component);
        let drawn: String = drawn.map(|m| m.figure(&grid, limit_um, &m.title)).collect();
        body += &format!("<h3>Component {}</h3>\n<div class=\"plots\">{drawn}</div>\n", escape(component));
    }
    format!(
        "<section class=\"page\"><h2>Residual over {} and {}</h2>\n{body}</section>\n",
        grid.tilting, grid.turning
    )
}

/// One map for each component, setup and direction that holds anything.
pub fn maps(input: &CompareInput, grid: &Grid) -> Vec<Map> {
    let mut maps = Vec::new();
    for (s, setup) in input.setups.iter().enumerate() {
        for signs in directions(&input.points, grid.axes) {
            let points: Vec<_> =
                input.points.iter().filter(|p| p.setup == s && direction(p, grid.axes) == signs).collect();
            if points.is_empty() {
                continue;
            }
            for (k, component) in components(input, s).into_iter().enumerate() {
                let cell = |tilt: f64, turn: f64| {
                    let here = points.iter().filter(|p| {
                        at_station(p, grid.tilting, tilt, &grid.tilts)
                            && at_station(p, grid.turning, turn, &grid.turns)
                    });
                    mean(here.flat_map(|p| residuals_um(input, p)).filter(|(j, _)| *j == k).map(|(_, r)| r))
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
pub fn of_place(input: &CompareInput, grid: &Grid, place: &Place) -> Option<Map> {
    let region = &place.region;
    let value = |p: &PointView| -> Option<f64> {
        let sign = |letter: AxisLetter| p.direction[letter];
        let weight = match region.way {
            Way::All => 1.0,
            Way::Forward(letter) if sign(letter) > 0.0 => 1.0,
            Way::Back(letter) if sign(letter) < 0.0 => 1.0,
            Way::Turns(letter) if sign(letter) != 0.0 => sign(letter).signum(),
            Way::Forward(_) | Way::Back(_) | Way::Turns(_) => return None,
        };
        let in_setup = region.setup.is_none_or(|setup| setup == p.setup);
        let in_time =
            region.time_s.is_none_or(|(from, to)| p.time_s.is_some_and(|t| (from..=to).contains(&t)));
        let three = components(input, p.setup).len() == 3;
        if p.outlier || !in_setup || !in_time || !three {
            return None;
        }
        let tool_mm = p.tool_residual_mm();
        let component = match region.component {
            k @ 0..3 => tool_mm[k],
            k @ 3..6 => (p.table_from_machine * tool_mm)[k - 3],
            _ => return None,
        };
        Some(um_from_mm(component) * weight).filter(|v| v.is_finite())
    };
    let cell = |tilt: f64, turn: f64| {
        let here = input.points.iter().filter(|p| {
            at_station(p, grid.tilting, tilt, &grid.tilts) && at_station(p, grid.turning, turn, &grid.turns)
        });
        mean(here.filter_map(value))
    };
    let inside = |tilt: f64, turn: f64| {
        [(grid.tilting, tilt), (grid.turning, turn)].into_iter().all(|(letter, at)| {
            region.axes.iter().filter(|(axis, ..)| *axis == letter).all(|&(_, from, to)| {
                const NEAR_RAD: f64 = 1e-3;
                let (above, below) = (at >= from - NEAR_RAD, at <= to + NEAR_RAD);
                if from <= to { above && below } else { above || below }
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
    let how = match region.way {
        Way::Turns(_) => {
            format!(", {} forward less back, halved", place.turns_with.as_deref().unwrap_or_default())
        }
        Way::All | Way::Forward(_) | Way::Back(_) => String::new(),
    };
    Some(Map {
        title: format!("{}{how}", place.component),
        component: place.component.clone(),
        values_um,
        framed: framed.collect(),
    })
}

/// A round number above every value.
pub fn limit_um<'a>(maps: impl IntoIterator<Item = &'a Map>) -> f64 {
    let largest = maps.into_iter().flat_map(|m| m.values_um.iter().flatten()).filter(|v| v.is_finite());
    nice_above(largest.fold(0.0, |limit: f64, v| limit.max(v.abs())))
}
