//! Pictures of the error map: places (S1 Fig. 5 and 8), errors over each axis (S1 Fig. 6 and 7).

use super::b_errors::BErrors;
use super::c_errors::CErrors;
use super::components::{components, is_about_itself};
use super::grid::{Cell, Grid};
use crate::findings::{AxisName, Chart, Curve, MapPlace, Plot};
use nalgebra::Vector3;
use trunnion_core::convert::deg_from_rad;
use trunnion_core::number::trimmed;
use trunnion_core::{Joint, Twist};
use trunnion_effects::Unit;

pub(super) fn charts(
    grid: &Grid<'_>,
    b_errors: &BErrors,
    c_errors: &CErrors,
    magnification: Option<f64>,
) -> Vec<Chart> {
    let upright = grid.tilt_near(0.0);
    let steepest = (0..grid.tilts_rad.len())
        .max_by(|&a, &b| grid.tilts_rad[a].abs().total_cmp(&(grid.tilts_rad[b].abs() - 1e-9)))
        .filter(|&tilt| tilt != upright);
    let mut charts = over_tilting(grid, b_errors).to_vec();
    for tilt in [Some(upright), steepest].into_iter().flatten() {
        charts.extend(over_turning(grid, c_errors, tilt));
    }
    let tilts = [Some(upright), steepest].into_iter().flatten();
    charts.extend(on_one_scale(tilts.flat_map(|tilt| places(grid, b_errors, tilt, magnification)).collect()));
    charts
}

/// Maps with the same magnification, so that they can be compared.
fn on_one_scale(mut maps: Vec<Chart>) -> Vec<Chart> {
    let of = |chart: &Chart| match &chart.plot {
        Plot::PlaneMap { magnification, .. } => Some(*magnification),
        _ => None,
    };
    let least = maps.iter().filter_map(of).fold(f64::INFINITY, f64::min);
    for map in &mut maps {
        if let Plot::PlaneMap { magnification, .. } = &mut map.plot {
            *magnification = least;
        }
    }
    maps
}

fn over_tilting(grid: &Grid<'_>, b_errors: &BErrors) -> [Chart; 2] {
    let over =
        |of: fn(&Twist) -> f64| grid.tilts_rad.iter().copied().zip(b_errors.at_tilt.iter().map(of)).collect();
    let group = format!("Errors of {} over {} (S1 Fig. 6)", grid.tilting, grid.tilting);
    sorted(&group, grid.tilting, "", |_| true, |of| Some(over(of)))
}

fn over_turning(grid: &Grid<'_>, c_errors: &CErrors, tilt: usize) -> [Chart; 2] {
    let at = degrees(grid, tilt);
    let group = format!("Errors of {} over {} (S1 Fig. 7)", grid.turning, grid.turning);
    let over = |of: fn(&Twist) -> f64| {
        let points = grid.turns_rad.iter().zip(&c_errors.at[tilt]);
        Some(points.filter_map(|(&turn, twist)| Some((turn, of(twist.as_ref()?)))).collect())
    };
    sorted(&group, grid.turning, &format!(" at {at}"), |name| !is_about_itself(name), over)
}

/// One chart of the rotations and one of the translations of an axis.
fn sorted(
    group: &str,
    axis: Joint,
    at: &str,
    shown: impl Fn(&str) -> bool,
    points: impl Fn(fn(&Twist) -> f64) -> Option<Vec<(f64, f64)>>,
) -> [Chart; 2] {
    [(Unit::URAD, "Rotations"), (Unit::UM, "Translations")].map(|(unit, title)| {
        let of_unit = components(axis).into_iter().filter(|(name, u, _)| *u == unit && shown(name));
        let curves = of_unit.filter_map(|(name, _, of)| Some(Curve::new(name, points(of)?))).collect();
        Chart {
            group: group.into(),
            title: format!("{title}{at}"),
            plot: Plot::Xy {
                x: AxisName { name: axis.to_string(), unit: Unit::DEG },
                y: AxisName { name: String::new(), unit },
                curves,
            },
        }
    })
}

/// Commanded, measured and simulated places of the nests on the plane in which the table tilts and on the table.
fn places(grid: &Grid<'_>, b_errors: &BErrors, tilt: usize, magnification: Option<f64>) -> Vec<Chart> {
    let across = if grid.tilting == Joint::A { 1 } else { 0 };
    let names = ["X", "Y", "Z"];
    let group = "Places of the nest: commanded (dot), measured (circle), by the errors of the tilting axis (cross) (S1 Fig. 5, 8)";
    let mut charts = Vec::new();
    for (s, nest) in grid.nests.iter().enumerate() {
        let moved: Vec<(&Cell, Vector3<f64>, Vector3<f64>)> = grid
            .at_tilt(tilt)
            .zip(&b_errors.residual_mm[tilt])
            .filter(|((_, of, _), _)| *of == s)
            .map(|((.., cell), left)| {
                // The table moves against the tool where the reading is the tool against the table.
                let simulated = -(cell.machine_from_table * cell.of_tilting(&b_errors.at_tilt[tilt]));
                (cell, simulated - cell.machine_from_table * left, simulated)
            })
            .collect();
        let in_machine = moved.iter().map(|(cell, measured, simulated)| MapPlace {
            commanded_mm: [cell.nest_in_machine_mm[across], cell.nest_in_machine_mm.z],
            measured_off_mm: [measured[across], measured.z],
            simulated_off_mm: Some([simulated[across], simulated.z]),
        });
        let on_table = moved.iter().map(|(cell, measured, simulated)| {
            // Axes of what carries the turning axis: the plane of the table, tilted with it.
            let carrier_from_machine = cell.turning.machine_from_carrier.inverse();
            let [place, measured, simulated] =
                [cell.nest_in_machine_mm.coords, *measured, *simulated].map(|v| carrier_from_machine * v);
            MapPlace {
                commanded_mm: [place.x, place.y],
                measured_off_mm: [measured.x, measured.y],
                simulated_off_mm: Some([simulated.x, simulated.y]),
            }
        });
        let at = degrees(grid, tilt);
        let chart = |title: String, names: [&str; 2], places: Vec<MapPlace>| Chart {
            group: group.into(),
            title: format!("{title}, nest {nest}, {at}"),
            plot: Plot::plane_map(names.map(String::from), places, magnification),
        };
        let plane = format!("{}{} plane of the machine", names[across], names[2]);
        charts.push(chart(plane, [names[across], names[2]], in_machine.collect()));
        charts.push(chart("Plane of the table".into(), ["across", "up"], on_table.collect()));
    }
    charts
}

fn degrees(grid: &Grid<'_>, tilt: usize) -> String {
    format!("{} = {}°", grid.tilting, trimmed(deg_from_rad(grid.tilts_rad[tilt]), 2))
}
