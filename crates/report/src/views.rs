//! Cuts through the residual: by axis position, direction, setup, time and component.
//!
//! A point set aside by the fit, and any value that is not finite, is left out of every figure here.

use crate::number::degrees;
use crate::{CompareInput, PointView};
use trunnion_core::AxisLetter;
use trunnion_core::convert::{rad_from_deg, um_from_mm};

/// More stations than this are gathered in sectors.
const MOST_STATIONS: usize = 36;
const SECTOR_RAD: f64 = rad_from_deg(10.0);

/// The rotary axes that moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// The one with the most stations, usually C.
    pub turning: Option<AxisLetter>,
    /// The other, usually B or A.
    pub tilting: Option<AxisLetter>,
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

impl Axes {
    /// Which rotary axes moved in these points.
    pub fn of(rotary: &[AxisLetter], points: &[PointView]) -> Self {
        let mut moved: Vec<_> = rotary
            .iter()
            .map(|&letter| (stations(points, letter).len(), letter))
            .filter(|(count, _)| *count > 1)
            .collect();
        moved.sort();
        let turning = moved.pop().map(|(_, letter)| letter);
        Self { turning, tilting: moved.pop().map(|(_, letter)| letter) }
    }
}

/// Positions at which an axis was read, rising, rad; sectors of 10° when it was read while turning.
pub fn stations(points: &[PointView], letter: AxisLetter) -> Vec<f64> {
    let distinct = |grid_rad: f64| {
        let mut indices: Vec<i64> = points
            .iter()
            .map(|p| p.position[letter])
            .filter(|q| q.is_finite())
            .map(|q| (q / grid_rad).round() as i64)
            .collect();
        indices.sort_unstable();
        indices.dedup();
        indices.into_iter().map(|i| i as f64 * grid_rad).collect::<Vec<_>>()
    };
    let fine = distinct(rad_from_deg(0.01));
    if fine.len() > MOST_STATIONS { distinct(SECTOR_RAD) } else { fine }
}

/// True when a point belongs to the station at `station_rad` of `stations`.
pub fn at_station(point: &PointView, letter: AxisLetter, station_rad: f64, stations: &[f64]) -> bool {
    let gap = stations.windows(2).map(|w| w[1] - w[0]).fold(SECTOR_RAD, f64::min);
    let offset = point.position[letter] - station_rad;
    -gap / 2.0 <= offset && offset < gap / 2.0
}

/// Residual components of a point, µm, with the component's index: motion of the tool against the table in machine axes where
/// the instrument reads three components, else as read; nothing for a point set aside.
pub fn residuals_um<'a>(
    input: &'a CompareInput,
    point: &'a PointView,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let components = components(input, point.setup).len();
    let residual = if components == 3 { point.tool_residual_mm() } else { point.residual_mm() };
    (0..components)
        .filter(|_| !point.outlier)
        .map(move |k| (k, um_from_mm(residual[k])))
        .filter(|(_, r)| r.is_finite())
}

/// Names of the components of [`residuals_um`].
pub fn components(input: &CompareInput, setup: usize) -> Vec<&str> {
    match input.setups.get(setup).map(|setup| &setup.components) {
        Some(names) if names.len() == 3 => vec!["X", "Y", "Z"],
        Some(names) => names.iter().take(3).map(String::as_str).collect(),
        None => Vec::new(),
    }
}

/// Root mean square per component, µm; NaN of nothing.
pub fn rms_um<'a>(input: &'a CompareInput, points: impl Iterator<Item = &'a PointView>) -> f64 {
    rms(points.flat_map(|p| residuals_um(input, p)).map(|(_, r)| r))
}

/// Root mean square; NaN of nothing.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    (sum / count).sqrt()
}

/// Mean; NaN of nothing.
pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / count
}

/// Names of the components in the order they first appear in the setups.
pub fn component_names(input: &CompareInput) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for name in (0..input.setups.len()).flat_map(|setup| components(input, setup)) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Name of component `k` of the setup of `point`.
pub fn component_name<'a>(input: &'a CompareInput, point: &PointView, k: usize) -> &'a str {
    components(input, point.setup).get(k).copied().unwrap_or("?")
}

/// Directions of travel that occur, as signs of the tilting and the turning axis.
pub fn directions(points: &[PointView], axes: Axes) -> Vec<[i8; 2]> {
    let mut found: Vec<[i8; 2]> = points.iter().map(|p| direction(p, axes)).collect();
    found.sort_unstable_by(|a, b| b.cmp(a));
    found.dedup();
    found
}

/// Signs of travel of the tilting and the turning axis.
pub fn direction(point: &PointView, axes: Axes) -> [i8; 2] {
    [axes.tilting, axes.turning].map(|letter| letter.map_or(0, |l| sign(point.direction[l])))
}

/// `B forward, C back`.
pub fn direction_name(signs: [i8; 2], axes: Axes) -> String {
    let word = |sign: i8| match sign {
        1 => "forward",
        -1 => "back",
        _ => "direction unknown",
    };
    let both: Vec<_> = [axes.tilting, axes.turning]
        .into_iter()
        .zip(signs)
        .filter_map(|(letter, sign)| Some(format!("{} {}", letter?, word(sign))))
        .collect();
    if both.is_empty() { "all points".into() } else { both.join(", ") }
}

fn sign(value: f64) -> i8 {
    if value > 0.0 {
        1
    } else if value < 0.0 {
        -1
    } else {
        0
    }
}

/// Every cut of the compare table: title and groups.
pub fn cuts(input: &CompareInput) -> Vec<(String, Vec<Group>)> {
    let axes = Axes::of(&input.rotary, &input.points);
    let group = |name: String, keep: &dyn Fn(&PointView) -> bool| {
        let kept: Vec<_> = input.points.iter().filter(|p| !p.outlier && keep(p)).collect();
        Group { name, points: kept.len(), rms_um: rms_um(input, kept.into_iter()) }
    };
    let mut cuts = Vec::new();
    let names = component_names(input);
    let by_component = |name: &&str| {
        let named = |p: &PointView, k: usize| component_name(input, p, k) == *name;
        let of_point =
            |p| residuals_um(input, p).filter(|(k, _)| named(p, *k)).map(|(_, r)| r).collect::<Vec<_>>();
        let values: Vec<f64> = input.points.iter().flat_map(of_point).collect();
        Group { name: name.to_string(), points: values.len(), rms_um: rms(values.into_iter()) }
    };
    cuts.push(("component".into(), names.iter().map(by_component).collect()));
    for letter in [axes.tilting, axes.turning].into_iter().flatten() {
        let stations = stations(&input.points, letter);
        let groups = stations
            .iter()
            .map(|&q| group(format!("{letter} = {}", degrees(q)), &|p| at_station(p, letter, q, &stations)));
        cuts.push((format!("{letter} position"), groups.collect()));
    }
    let directions = directions(&input.points, axes);
    let groups: Vec<_> =
        directions.iter().map(|&d| group(direction_name(d, axes), &|p| direction(p, axes) == d)).collect();
    cuts.push(("direction".into(), groups));
    let groups =
        (0..input.setups.len()).map(|i| group(input.setups[i].name.clone(), &|p| p.setup == i)).collect();
    cuts.push(("setup".into(), groups));
    if let Some((first, last)) = time_range_s(input) {
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
pub fn time_range_s(input: &CompareInput) -> Option<(f64, f64)> {
    let times = || input.points.iter().filter_map(|p| p.time_s).filter(|t| t.is_finite());
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
