//! Where a model fails: the residual by axis position, direction, setup, time and component.
//!
//! Root mean squares per scalar reading. The worst places are those of [`places()`].

mod frames;
mod places;

pub use places::{AxisRange, Place, Region, places};

use crate::Experiment;
use frames::in_frames;
use nalgebra::{DVector, Vector3};
use trunnion_core::{Joint, State, convert};

/// Most bins of one axis.
const MOST_BINS: usize = 13;

/// The residual seen from several sides.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualViews {
    /// Root mean square of all readings used, µm.
    pub rms_um: f64,
    /// Share of the measured deviations' mean square that the model explains, 0…1.
    pub explained_fraction: f64,
    /// One view per axis, direction, setup, third of the time, component and frame.
    pub views: Vec<View>,
    /// Where the model fails most, worst first; at most three, none when no place stands out of the noise.
    pub worst: Vec<Place>,
}

/// One way to sort the points.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// What it is sorted by, e.g. `B position`, `direction of C`, `component in machine axes`.
    pub by: String,
    /// Its bins in order.
    pub bins: Vec<Bin>,
}

/// One bin of a view.
#[derive(Clone, Debug, PartialEq)]
pub struct Bin {
    /// E.g. `-60°`, `+`, `low`, `Z`.
    pub label: String,
    /// Number of scalar readings.
    pub readings: usize,
    /// Root mean square, µm.
    pub rms_um: f64,
}

/// Sorts `residual_mm` (all rows, measured − predicted); points with `used` false take no part.
pub fn residual_views(experiment: &Experiment, residual_mm: &DVector<f64>, used: &[bool]) -> ResidualViews {
    let points: Vec<usize> = (0..experiment.points.len()).filter(|&i| used[i]).collect();
    let square =
        |i: usize| -> f64 { experiment.rows_of(i).map(|row| residual_mm[row] * residual_mm[row]).sum() };
    let bin = |label: String, members: &[usize]| {
        let readings: usize = members.iter().map(|&i| experiment.rows_of(i).len()).sum();
        let sum: f64 = members.iter().map(|&i| square(i)).sum();
        Bin { label, readings, rms_um: (sum / readings.max(1) as f64).sqrt() * 1e3 }
    };
    let view = |by: String, groups: &[(String, Vec<usize>)]| View {
        by,
        bins: groups.iter().map(|(label, members)| bin(label.clone(), members)).collect(),
    };
    let state = |i: usize| -> &State { &experiment.points[i].state };
    let mut views = Vec::new();
    for axis in experiment.machine().axes() {
        let groups = stations(&points, |i| state(i).position[axis.letter], axis.letter);
        if groups.len() > 1 {
            views.push(view(format!("{} position", axis.letter), &groups));
        }
        let by_direction = sorted(&points, |i| sign(state(i).direction[axis.letter]).to_string());
        if by_direction.len() > 1 {
            views.push(view(format!("direction of {}", axis.letter), &by_direction));
        }
    }
    let setups = sorted(&points, |i| experiment.setups[state(i).setup].name.clone());
    views.push(view("setup".into(), &setups));
    if let Some((first, last)) = experiment.scene.time_range_s.filter(|(first, last)| last > first) {
        let third = |i: usize| {
            let share = (state(i).time_s.unwrap_or(first) - first) / (last - first);
            ["first third", "middle third", "last third"][((share * 3.0) as usize).min(2)].to_string()
        };
        views.push(view("time".into(), &sorted(&points, third)));
    }
    views.extend(component_views(experiment, residual_mm, &points));
    let total = bin(String::new(), &points);
    let readings = experiment.readings_mm();
    let measured: f64 =
        points.iter().flat_map(|&i| experiment.rows_of(i)).map(|row| readings[row] * readings[row]).sum();
    let left: f64 = points.iter().map(|&i| square(i)).sum();
    let explained_fraction = if measured > 0.0 { (1.0 - left / measured).clamp(0.0, 1.0) } else { 0.0 };
    let worst = places(experiment, residual_mm, used);
    ResidualViews { rms_um: total.rms_um, explained_fraction, views, worst }
}

fn sign(direction: f64) -> &'static str {
    match direction {
        d if d > 0.0 => "+",
        d if d < 0.0 => "−",
        _ => "unknown",
    }
}

/// Points by label, in order of first appearance.
fn sorted(points: &[usize], label: impl Fn(usize) -> String) -> Vec<(String, Vec<usize>)> {
    let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
    for &i in points {
        let name = label(i);
        match groups.iter_mut().find(|(other, _)| *other == name) {
            Some((_, members)) => members.push(i),
            None => groups.push((name, vec![i])),
        }
    }
    groups
}

/// Points by position of one axis: its stations when few, else equal bins.
fn stations(points: &[usize], position: impl Fn(usize) -> f64, letter: Joint) -> Vec<(String, Vec<usize>)> {
    let screen = |x: f64| if letter.is_rotary() { convert::deg_from_rad(x) } else { x };
    let unit = if letter.is_rotary() { "°" } else { " mm" };
    let values: Vec<f64> = points.iter().map(|&i| screen(position(i))).collect();
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let mut distinct: Vec<i64> = values.iter().map(|v| (v * 10.0).round() as i64).collect();
    distinct.sort_unstable();
    distinct.dedup();
    let width = (high - low) / MOST_BINS as f64;
    let mut groups: Vec<(i64, Vec<usize>)> = Vec::new();
    for (&i, value) in points.iter().zip(&values) {
        let key = if distinct.len() <= MOST_BINS {
            (value * 10.0).round() as i64
        } else {
            (((value - low) / width.max(1e-12)) as i64).min(MOST_BINS as i64 - 1)
        };
        match groups.iter_mut().find(|(other, _)| *other == key) {
            Some((_, members)) => members.push(i),
            None => groups.push((key, vec![i])),
        }
    }
    groups.sort_by_key(|(key, _)| *key);
    let label = |key: i64| {
        if distinct.len() <= MOST_BINS {
            format!("{:.0}{unit}", key as f64 / 10.0)
        } else {
            let from = low + key as f64 * width;
            format!("{from:.0}…{:.0}{unit}", from + width)
        }
    };
    groups.into_iter().map(|(key, members)| (label(key), members)).collect()
}

fn component_views(experiment: &Experiment, residual_mm: &DVector<f64>, points: &[usize]) -> Vec<View> {
    let vectors: Vec<[Vector3<f64>; 2]> = points
        .iter()
        .filter_map(|&i| in_frames(experiment, residual_mm, i))
        .map(|(in_machine, table_from_machine)| [in_machine, table_from_machine * in_machine])
        .collect();
    if vectors.is_empty() {
        return Vec::new();
    }
    let bins = |frame: usize| {
        (0..3)
            .map(|k| {
                let sum: f64 = vectors.iter().map(|v| v[frame][k] * v[frame][k]).sum();
                let rms_um = (sum / vectors.len() as f64).sqrt() * 1e3;
                Bin { label: ["X", "Y", "Z"][k].into(), readings: vectors.len(), rms_um }
            })
            .collect()
    };
    vec![
        View { by: "component in machine axes".into(), bins: bins(0) },
        View { by: "component in table axes".into(), bins: bins(1) },
    ]
}
