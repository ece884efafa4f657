//! Volumetric accuracy of a machine by a fitted model.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trunnion_core::AxisLetter;
use trunnion_core::convert::{deg_from_rad, um_from_mm, urad_from_rad};
use trunnion_methods::NotTabulated;
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
    /// First and last position of each axis, mm and degrees.
    pub volume: BTreeMap<String, [f64; 2]>,
    /// Places of the grid.
    pub places: usize,
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
    /// Value in `unit`.
    pub value: f64,
    /// Standard uncertainty in `unit`.
    pub u: f64,
    /// Unit.
    pub unit: String,
    /// Axis positions of the lowest deviation, mm and degrees.
    pub from: BTreeMap<String, f64>,
    /// Axis positions of the highest.
    pub to: BTreeMap<String, f64>,
}

/// A direction in parameter space that is not observed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Unseen {
    /// Its parameters.
    pub direction: String,
    /// Components of the deviation that it changes.
    pub moves: Vec<String>,
}

/// An effect that is not in the figures, or only partly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LeftOutEffect {
    /// Effect id.
    pub effect: String,
    /// Why.
    pub why: String,
}

impl Volumetric {
    /// The figures of a map of a machine with these axes.
    pub fn new(map: &methods::VolumetricMap, axes: &[AxisLetter]) -> Self {
        let at = |k: usize| -> BTreeMap<String, f64> {
            axes.iter().map(|&axis| (axis.to_string(), screen(axis, map.points[k].position[axis]))).collect()
        };
        let value = |name: String, rotation: bool, extreme: &methods::Extreme| {
            let scaled = if rotation { urad_from_rad } else { um_from_mm };
            VolumetricValue {
                name,
                value: scaled(extreme.value),
                u: scaled(extreme.u),
                unit: if rotation { "urad" } else { "um" }.into(),
                from: at(extreme.low),
                to: at(extreme.high),
            }
        };
        let ranges = AxisLetter::ALL.into_iter().zip(&map.ranges);
        let ranges =
            ranges.map(|(axis, range)| value(format!("range-{}", axis.lower()), axis.is_rotary(), range));
        let range_of = |&axis: &AxisLetter| {
            let (low, high) = map.volume.range[axis];
            (axis.to_string(), [screen(axis, low), screen(axis, high)])
        };
        Self {
            format: VolumetricFormat::V1,
            machine: map.machine.clone(),
            runs: map.runs.clone(),
            volume: axes.iter().map(range_of).collect(),
            places: map.points.len(),
            datum: match map.datum {
                methods::Datum::BestFit => Datum::Fit,
                methods::Datum::Model => Datum::Model,
            },
            values: ranges.chain([value("longest-vector".into(), false, &map.longest)]).collect(),
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

impl From<&NotTabulated> for LeftOutEffect {
    fn from(left_out: &NotTabulated) -> Self {
        Self { effect: left_out.effect.clone(), why: left_out.why.clone() }
    }
}

fn screen(axis: AxisLetter, position: f64) -> f64 {
    if axis.is_rotary() { deg_from_rad(position) } else { position }
}
