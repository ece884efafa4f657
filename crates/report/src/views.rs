//! Cuts through the residual: by axis position, direction, setup, time and component.
//!
//! A point set aside by the fit, and any value that is not finite, is left out of every figure here.

use crate::number::{degrees, um};
use crate::{CompareInput, PointView};
use trunnion_units::AxisLetter;
use trunnion_units::convert::{rad_from_deg, um_from_mm};

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
    pub fn of(points: &[PointView]) -> Self {
        let mut moved: Vec<_> = AxisLetter::ROTARY
            .into_iter()
            .map(|letter| (stations(points, letter).len(), letter))
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

/// Residual components of a point, µm, with the component's index; nothing for a point set aside.
pub fn residuals_um<'a>(
    input: &'a CompareInput,
    point: &'a PointView,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let components = input.setups.get(point.setup).map_or(0, |setup| setup.components.len());
    let residual = point.residual_mm();
    (0..components.min(3))
        .filter(|_| !point.outlier)
        .map(move |k| (k, um_from_mm(residual[k])))
        .filter(|(_, r)| r.is_finite())
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
pub fn component_names(input: &CompareInput) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in input.setups.iter().flat_map(|setup| &setup.components) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

/// Name of component `k` of the setup of `point`.
pub fn component_name<'a>(input: &'a CompareInput, point: &PointView, k: usize) -> &'a str {
    input.setups.get(point.setup).and_then(|s| s.components.get(k)).map_or("?", String::as_str)
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
    let axes = Axes::of(&input.points);
    let group = |name: String, keep: &dyn Fn(&PointView) -> bool| {
        let kept: Vec<_> = input.points.iter().filter(|p| !p.outlier && keep(p)).collect();
        Group { name, points: kept.len(), rms_um: rms_um(input, kept.into_iter()) }
    };
    let mut cuts = Vec::new();
    let names = component_names(input);
    let by_component = |name: &String| {
        let named = |p: &PointView, k: usize| component_name(input, p, k) == name;
        let of_point = |p| residuals_um(input, p).filter(move |(k, _)| named(p, *k)).map(|(_, r)| r);
        let values: Vec<f64> = input.points.iter().flat_map(of_point).collect();
        Group { name: name.clone(), points: values.len(), rms_um: rms(values.into_iter()) }
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

/// The three places where the model fails most, in words, worst first.
pub fn worst_places(input: &CompareInput) -> Vec<String> {
    let axes = Axes::of(&input.points);
    let letter = axes.tilting.or(axes.turning);
    let stations = letter.map_or(Vec::new(), |letter| stations(&input.points, letter));
    let mut places: Vec<(f64, String)> = Vec::new();
    for setup in 0..input.setups.len() {
        for &station in if stations.is_empty() { &[0.0][..] } else { &stations[..] } {
            let here = |p: &&PointView| {
                let at = letter.is_none_or(|l| at_station(p, l, station, &stations));
                p.setup == setup && at && !p.outlier
            };
            let size = rms_um(input, input.points.iter().filter(here));
            if size.is_finite() {
                let place = letter.map_or(String::new(), |l| format!("at {l} = {}, ", degrees(station)));
                let points: Vec<_> = input.points.iter().filter(here).collect();
                let words = shape_in_words(input, &points, axes);
                let name = &input.setups[setup].name;
                places.push((size, format!("{place}setup {name}: {} rms; {words}.", um(size))));
            }
        }
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    places.into_iter().take(3).map(|(_, words)| uppercase_first(&words)).collect()
}

/// Which component, which sign, and whether it turns over with direction.
fn shape_in_words(input: &CompareInput, points: &[&PointView], axes: Axes) -> String {
    let values = |k: usize, keep: &dyn Fn(&PointView) -> bool| -> Vec<f64> {
        let kept = points.iter().filter(|p| keep(p));
        kept.flat_map(|p| residuals_um(input, p)).filter(|(j, _)| *j == k).map(|(_, r)| r).collect()
    };
    let size = |k: usize| rms(values(k, &|_| true).into_iter());
    let Some(largest) = (0..3).filter(|&k| size(k).is_finite()).max_by(|&a, &b| size(a).total_cmp(&size(b)))
    else {
        return "nothing readable".into();
    };
    let name = points.first().map_or("?", |p| component_name(input, p, largest));
    let overall = mean(values(largest, &|_| true).into_iter());
    let one_way = |s: i8| mean(values(largest, &|p| direction(p, axes)[1] == s).into_iter());
    let (forward, back) = (one_way(1), one_way(-1));
    let head = format!("largest along {name} ({} rms)", um(size(largest)));
    if (forward - back).abs() > size(largest) && forward * back < 0.0 {
        return format!("{head}, and it changes sign with the direction of travel");
    }
    if overall.abs() > 0.7 * size(largest) {
        let side = if overall > 0.0 { "above" } else { "below" };
        return format!(
            "{head}, the reading lies {} {side} the prediction nearly everywhere",
            um(overall.abs())
        );
    }
    match axes.turning {
        Some(turning) if axes.tilting.is_some() => format!("{head}, changing with {turning}"),
        _ => head,
    }
}

fn uppercase_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| first.to_uppercase().chain(chars).collect())
}
