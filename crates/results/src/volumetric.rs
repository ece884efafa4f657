//! Volumetric accuracy of a machine by a fitted model.

use crate::axis_errors::components;
use crate::left_out::LeftOutEffect;
use crate::residuals::ResidualAxis;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trunnion_core::convert::{deg_from_rad, um_from_mm, urad_from_rad};
use trunnion_core::{Joint, Twist};
use trunnion_methods::volumetric as methods;

/// `trunnion-volumetric/1`: ranges of the deviation of tool against table over a volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Volumetric {
    /// Format and version.
    pub format: VolumetricFormat,
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs that the model was fitted to.
    pub runs: Vec<String>,
    /// Axes of the machine.
    #[serde(default)]
    pub axes: Vec<ResidualAxis>,
    /// First and last position of each axis, mm and degrees.
    pub volume: BTreeMap<String, [f64; 2]>,
    /// Places of the grid.
    pub places: usize,
    /// How densely each axis that moves was looked at.
    #[serde(default)]
    pub looked: Vec<Looked>,
    /// What the deviations are against.
    pub datum: Datum,
    /// Largest ranges, and the longest vector.
    pub values: Vec<VolumetricValue>,
    /// True when something that the runs do not observe would change the figures.
    pub lower_bound: bool,
    /// Directions that the runs do not observe and that would change the figures.
    pub unseen: Vec<Unseen>,
    /// Axes of the volume that stood still in the runs.
    pub stood_still: Vec<String>,
    /// Effects that are not in the figures.
    pub left_out: Vec<LeftOutEffect>,
}

/// Format and version of a volumetric accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum VolumetricFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-volumetric/1")]
    V1,
}

/// What deviations are against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Datum {
    /// The rigid displacement that fits the whole volume best is removed.
    Fit,
    /// The coordinate system of the model.
    Model,
}

/// One figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VolumetricValue {
    /// `range-x` … `range-c`, or `longest-vector`.
    pub name: String,
    /// Value in `unit`; null where no effect of the model changes it over the volume, so that it is not known.
    pub value: Option<f64>,
    /// Standard uncertainty in `unit`.
    pub u: Option<f64>,
    /// By how much more it may be between the places of the grid.
    #[serde(default)]
    pub missed: f64,
    /// Unit.
    pub unit: String,
    /// Axis positions of the lowest deviation, mm and degrees; empty where it is not known.
    pub from: BTreeMap<String, f64>,
    /// Axis positions of the highest; empty where it is not known.
    pub to: BTreeMap<String, f64>,
}

/// How densely one axis was looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Looked {
    /// The axis.
    pub axis: String,
    /// Places along it.
    pub places: usize,
    /// Their distance, mm or degrees.
    pub step: f64,
}

/// A direction in parameter space that is not observed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Unseen {
    /// Its parameters.
    pub direction: String,
    /// Components of the deviation that it changes.
    pub moves: Vec<String>,
}

/// `trunnion-error-map/1`: the deviation of tool against table at every place of a volume.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorMap {
    /// Format and version.
    pub format: ErrorMapFormat,
    /// Name of the machine.
    pub machine: String,
    /// Axes of the machine; the positions of the places are in this order.
    pub axes: Vec<ResidualAxis>,
    /// Places of the grid.
    pub places: Vec<ErrorAt>,
}

/// Format and version of an error map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ErrorMapFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-error-map/1")]
    V1,
}

/// The deviation at one place, in the order X Y Z A B C, µm and µrad.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorAt {
    /// Axis positions, mm and degrees.
    pub position: Vec<f64>,
    /// Nominal tool point, table axes, mm.
    pub in_table_mm: [f64; 3],
    /// Deviation of tool against table, table axes; null where no effect of the model moves it at any place.
    pub error: [Option<f64>; 6],
    /// Its standard uncertainty.
    pub u: [Option<f64>; 6],
}

impl ErrorMap {
    /// The deviations of a map of a machine with these axes.
    pub fn new(map: &methods::VolumetricMap, axes: &[Joint]) -> Self {
        let um_urad = |twist: &Twist| {
            let inside = components(twist);
            std::array::from_fn(|k| {
                let known = map.moves(k).then_some(inside[k]);
                known.map(if k < 3 { um_from_mm } else { urad_from_rad })
            })
        };
        let at = |point: &methods::MapPoint| ErrorAt {
            position: axes.iter().map(|&axis| screen(axis, point.position[axis])).collect(),
            in_table_mm: point.in_table_mm.coords.into(),
            error: um_urad(&point.error),
            u: um_urad(&point.u),
        };
        Self {
            format: ErrorMapFormat::V1,
            machine: map.machine.clone(),
            axes: named(axes),
            places: map.points.iter().map(at).collect(),
        }
    }
}

impl Volumetric {
    /// True where the grid is too coarse for a figure: of each axis it may miss no more than a grid that is dense enough.
    pub fn is_coarse(&self, figure: &VolumetricValue) -> bool {
        let enough = |(value, u): (f64, f64)| self.looked.len() as f64 * u.max(methods::MISSES * value);
        figure.value.zip(figure.u).is_some_and(|known| figure.missed > enough(known))
    }

    /// The figures of a map of a machine with these axes.
    pub fn new(map: &methods::VolumetricMap, axes: &[Joint]) -> Self {
        let at = |k: usize| -> BTreeMap<String, f64> {
            axes.iter().map(|&axis| (axis.to_string(), screen(axis, map.points[k].position[axis]))).collect()
        };
        let value = |name: String, rotation: bool, missed: f64, extreme: &methods::Extreme| {
            let extreme = Some(extreme).filter(|found| found.is_known());
            let scaled = if rotation { urad_from_rad } else { um_from_mm };
            let place = |of: fn(&methods::Extreme) -> usize| extreme.map(|found| at(of(found)));
            VolumetricValue {
                name,
                value: extreme.map(|found| scaled(found.value)),
                u: extreme.map(|found| scaled(found.u)),
                missed: extreme.map_or(0.0, |_| scaled(missed)),
                unit: if rotation { "urad" } else { "um" }.into(),
                from: place(|found| found.low).unwrap_or_default(),
                to: place(|found| found.high).unwrap_or_default(),
            }
        };
        let missed = |k: usize| map.looked.iter().map(|looked| looked.missed[k]).sum::<f64>();
        let ranges = Joint::ALL.into_iter().zip(&map.ranges).enumerate();
        let ranges = ranges.map(|(k, (axis, range))| {
            value(format!("range-{}", axis.lower()), axis.is_rotary(), missed(k), range)
        });
        let missed_mm = missed(0).hypot(missed(1)).hypot(missed(2));
        let looked = |looked: &methods::Looked| Looked {
            axis: looked.axis.to_string(),
            places: looked.places,
            step: screen(looked.axis, looked.step),
        };
        let range_of = |&axis: &Joint| {
            let (low, high) = map.volume.range[axis];
            (axis.to_string(), [screen(axis, low), screen(axis, high)])
        };
        Self {
            format: VolumetricFormat::V1,
            machine: map.machine.clone(),
            runs: map.runs.clone(),
            axes: named(axes),
            volume: axes.iter().map(range_of).collect(),
            places: map.points.len(),
            looked: map.looked.iter().map(looked).collect(),
            datum: match map.datum {
                methods::Datum::BestFit => Datum::Fit,
                methods::Datum::Model => Datum::Model,
            },
            values: ranges.chain([value("longest-vector".into(), false, missed_mm, &map.longest)]).collect(),
            lower_bound: map.lower_bound(),
            unseen: map
                .unseen
                .iter()
                .map(|unseen| Unseen {
                    direction: unseen.direction.clone(),
                    moves: unseen.moves.iter().map(ToString::to_string).collect(),
                })
                .collect(),
            stood_still: map.stood_still.iter().map(ToString::to_string).collect(),
            left_out: map.left_out.iter().map(LeftOutEffect::from).collect(),
        }
    }
}

fn named(axes: &[Joint]) -> Vec<ResidualAxis> {
    axes.iter().map(ResidualAxis::from).collect()
}

fn screen(axis: Joint, position: f64) -> f64 {
    if axis.is_rotary() { deg_from_rad(position) } else { position }
}
