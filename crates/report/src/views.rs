//! Cuts through the residual: by axis position, direction, setup, time and component.
//!
//! A point excluded by the fit, and any value that is not finite, is left out of every figure here.

use crate::number::degrees;
use trunnion_core::convert::rad_from_deg;
use trunnion_core::statistics;
use trunnion_results::{ResidualPoint, Residuals};

/// More stations than this are gathered in sectors.
const MOST_STATIONS: usize = 36;
const SECTOR_DEG: f64 = 10.0;

/// A rotary axis: its name and its place in the positions of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis<'a> {
    /// Its name.
    pub name: &'a str,
    /// Index in positions and directions.
    pub index: usize,
}

/// The rotary axes that moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes<'a> {
    /// The one with the most stations, usually C.
    pub turning: Option<Axis<'a>>,
    /// The other, usually B or A.
    pub tilting: Option<Axis<'a>>,
}

/// A part of the points, with the root mean square of its residual.
#[derive(Clone, Debug)]
pub struct Group {
    /// Name for a person, e.g. `B = −90°`.
    pub name: String,
    /// Points in it.
    pub points: usize,
    /// µm per component.
    pub rms_um: f64,
}

impl<'a> Axes<'a> {
    /// Which rotary axes moved in these points.
    pub fn of(residuals: &'a Residuals) -> Self {
        let rotary = residuals.axes.iter().enumerate().filter(|(_, axis)| axis.rotary);
        let mut moved: Vec<_> = rotary
            .map(|(index, axis)| Axis { name: &axis.name, index })
            .map(|axis| (stations(&residuals.points, axis).len(), axis))
            .filter(|(count, _)| *count > 1)
            .collect();
        moved.sort_by_key(|(count, axis)| (*count, axis.index));
        let turning = moved.pop().map(|(_, axis)| axis);
        Self { turning, tilting: moved.pop().map(|(_, axis)| axis) }
    }
}

/// Positions at which an axis was read, rising, degrees; sectors of 10° when it was read while turning.
pub fn stations(points: &[ResidualPoint], axis: Axis<'_>) -> Vec<f64> {
    let distinct = |grid_deg: f64| {
        let mut indices: Vec<i64> = points
            .iter()
            .map(|p| p.position[axis.index])
            .filter(|q| q.is_finite())
            .map(|q| (q / grid_deg).round() as i64)
            .collect();
        indices.sort_unstable();
        indices.dedup();
        indices.into_iter().map(|i| i as f64 * grid_deg).collect::<Vec<_>>()
    };
    let fine = distinct(0.01);
    if fine.len() > MOST_STATIONS { distinct(SECTOR_DEG) } else { fine }
}

/// True when a point belongs to the station at `station_deg` of `stations`.
pub fn at_station(point: &ResidualPoint, axis: Axis<'_>, station_deg: f64, stations: &[f64]) -> bool {
    let gap = stations.windows(2).map(|w| w[1] - w[0]).fold(SECTOR_DEG, f64::min);
    let offset = point.position[axis.index] - station_deg;
    -gap / 2.0 <= offset && offset < gap / 2.0
}

/// Residual components of a point, µm, with the component's index: motion of the tool against the table in machine axes where
/// the instrument reads three components, else as read; nothing for a point excluded.
pub fn residuals_um<'a>(
    residuals: &'a Residuals,
    point: &'a ResidualPoint,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let three = components(residuals, point.setup).len() == 3;
    let values: &[f64] = if three { &point.tool_residual_um } else { &point.residual_um };
    values.iter().copied().enumerate().filter(|(_, r)| !point.excluded && r.is_finite())
}

/// Names of the components of [`residuals_um`].
pub fn components(residuals: &Residuals, setup: usize) -> Vec<&str> {
    match residuals.setups.get(setup).map(|setup| &setup.components) {
        Some(names) if names.len() == 3 => vec!["X", "Y", "Z"],
        Some(names) => names.iter().take(3).map(String::as_str).collect(),
        None => Vec::new(),
    }
}

/// Root mean square per component, µm; NaN of nothing.
pub fn rms_um<'a>(residuals: &'a Residuals, points: impl Iterator<Item = &'a ResidualPoint>) -> f64 {
    rms(points.flat_map(|p| residuals_um(residuals, p)).map(|(_, r)| r))
}

/// Root mean square; NaN of nothing.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    statistics::rms(values).unwrap_or(f64::NAN)
}

/// Mean; NaN of nothing.
pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    statistics::mean(values).unwrap_or(f64::NAN)
}

/// Names of the components in the order they first appear in the setups.
pub fn component_names(residuals: &Residuals) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for name in (0..residuals.setups.len()).flat_map(|setup| components(residuals, setup)) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Name of component `k` of the setup of `point`.
pub fn component_name<'a>(residuals: &'a Residuals, point: &ResidualPoint, k: usize) -> &'a str {
    components(residuals, point.setup).get(k).copied().unwrap_or("?")
}

/// Directions of travel that occur, as signs of the tilting and the turning axis.
pub fn directions(points: &[ResidualPoint], axes: Axes<'_>) -> Vec<[i8; 2]> {
    let mut found: Vec<[i8; 2]> = points.iter().map(|p| direction(p, axes)).collect();
    found.sort_unstable_by(|a, b| b.cmp(a));
    found.dedup();
    found
}

/// Signs of travel of the tilting and the turning axis.
pub fn direction(point: &ResidualPoint, axes: Axes<'_>) -> [i8; 2] {
    [axes.tilting, axes.turning].map(|axis| axis.map_or(0, |axis| point.direction[axis.index]))
}

/// `B forward, C back`.
pub fn direction_name(signs: [i8; 2], axes: Axes<'_>) -> String {
    let word = |sign: i8| match sign {
        1 => "forward",
        -1 => "back",
        _ => "direction unknown",
    };
    let both: Vec<_> = [axes.tilting, axes.turning]
        .into_iter()
        .zip(signs)
        .filter_map(|(axis, sign)| Some(format!("{} {}", axis?.name, word(sign))))
        .collect();
    if both.is_empty() { "all points".into() } else { both.join(", ") }
}

/// Every cut of the compare table: title and groups.
pub fn cuts(residuals: &Residuals) -> Vec<(String, Vec<Group>)> {
    let axes = Axes::of(residuals);
    let group = |name: String, keep: &dyn Fn(&ResidualPoint) -> bool| {
        let kept: Vec<_> = residuals.points.iter().filter(|p| !p.excluded && keep(p)).collect();
        Group { name, points: kept.len(), rms_um: rms_um(residuals, kept.into_iter()) }
    };
    let mut cuts = Vec::new();
    let names = component_names(residuals);
    let by_component = |name: &&str| {
        let named = |p: &ResidualPoint, k: usize| component_name(residuals, p, k) == *name;
        let of_point =
            |p| residuals_um(residuals, p).filter(|(k, _)| named(p, *k)).map(|(_, r)| r).collect::<Vec<_>>();
        let values: Vec<f64> = residuals.points.iter().flat_map(of_point).collect();
        Group { name: name.to_string(), points: values.len(), rms_um: rms(values.into_iter()) }
    };
    cuts.push(("component".into(), names.iter().map(by_component).collect()));
    for axis in [axes.tilting, axes.turning].into_iter().flatten() {
        let stations = stations(&residuals.points, axis);
        let groups = stations.iter().map(|&q| {
            group(format!("{} = {}", axis.name, degrees(rad_from_deg(q))), &|p| {
                at_station(p, axis, q, &stations)
            })
        });
        cuts.push((format!("{} position", axis.name), groups.collect()));
    }
    let directions = directions(&residuals.points, axes);
    let groups: Vec<_> =
        directions.iter().map(|&d| group(direction_name(d, axes), &|p| direction(p, axes) == d)).collect();
    cuts.push(("direction".into(), groups));
    let groups = (0..residuals.setups.len())
        .map(|i| group(residuals.setups[i].name.clone(), &|p| p.setup == i))
        .collect();
    cuts.push(("setup".into(), groups));
    if let Some((first, last)) = time_range_s(residuals) {
        let third = (last - first) / 3.0;
        let names = ["first third", "middle third", "last third"];
        let index = |t: f64| (((t - first) / third) as usize).min(2);
        let groups = (0..3).map(|i| group(names[i].into(), &|p| p.time_s.is_some_and(|t| index(t) == i)));
        cuts.push(("time".into(), groups.collect()));
    }
    cuts.retain(|(_, groups)| !groups.is_empty());
    cuts
}

/// First and last finite time, s, when they differ.
pub fn time_range_s(residuals: &Residuals) -> Option<(f64, f64)> {
    let times = || residuals.points.iter().filter_map(|p| p.time_s).filter(|t| t.is_finite());
    let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max));
    (last > first).then_some((first, last))
}

/// Longer series are drawn as means of neighbours.
const MOST_MARKS: usize = 500;

/// At most [`MOST_MARKS`] places, neighbours taken together.
pub fn thinned(places: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let together = places.len().div_ceil(MOST_MARKS).max(1);
    let middle = |chunk: &[(f64, f64)]| (mean(chunk.iter().map(|p| p.0)), mean(chunk.iter().map(|p| p.1)));
    places.chunks(together).map(middle).collect()
}
