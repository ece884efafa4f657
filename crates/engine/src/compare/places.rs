//! The places where a model fails most, in words: `Z, B −60° and below, both directions, both setups, +4.1 µm`.
//!
//! A place is a box: one component × a range of one or two axes × direction × setup × time. A box of n readings with mean m
//! explains n m² of the residual's sum of squares. The box that explains most, less the price of naming it, is taken, its mean
//! subtracted, and the scan repeated; boxes of one component never overlap. The price is what the best of as many random boxes
//! would explain, 2 ln(choices) variances of a mean; readings of one pass depend on each other, so that variance is widened by
//! the design effect 1 + (m̄ − 1)ρ of the clusters they come in (Kish, Survey Sampling, 1965, §8.2). What does not pay its price
//! does not stand out of the noise: the list may be empty.

mod found;
mod readings;
mod scan;

use crate::Experiment;
use nalgebra::DVector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use trunnion_core::Joint;
use trunnion_core::number::{signed, trimmed};

use found::{Found, Way};
use readings::{Dimension, Readings};

/// Most places reported.
const MOST_PLACES: usize = 3;
/// A place explains at least this share of the residual's sum of squares.
const LEAST_SHARE: f64 = 0.04;

/// One place where the model fails.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Place {
    /// The place in words.
    pub words: String,
    /// `X`, `Y`, `Z` in machine axes, `table X`, … in the axes of the turned table; of an instrument that reads no three directions what it
    /// reads, e.g. `bar length` or `reading along the beam`. Positive: the tool stands further that way against the table than
    /// predicted, the bar is longer.
    pub component: String,
    /// Ranges of the axes that matter, e.g. `B −60° and below`; empty when it is everywhere.
    pub ranges: Vec<String>,
    /// `both directions`, `C forward`, …; empty when the axes have no known direction.
    pub direction: String,
    /// `setup low`, `both setups`; empty when there is only one.
    pub setup: String,
    /// `in the first 12 min`, …; empty when time does not matter.
    pub time: String,
    /// Mean of measured − predicted, µm; with `turns_with` the mean with that axis going forward.
    pub mean_um: f64,
    /// The axis whose direction of travel turns the sign over: `C`, or `B and C` where both always went the same way.
    pub turns_with: Option<String>,
    /// Scalar readings in it.
    pub readings: usize,
    /// Share of the residual's sum of squares that its mean explains, 0…1.
    pub share: f64,
    /// The same in numbers.
    #[serde(default)]
    pub region: Region,
}

/// Which readings belong to a place.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Region {
    /// 0–2: machine X Y Z; 3–5: table X Y Z; 6: what an instrument reads that reads no three directions.
    pub component: usize,
    /// Ranges of the axes that matter.
    pub axes: Vec<AxisRange>,
    /// First and last time, s; null when the time does not matter.
    pub time_s: Option<[f64; 2]>,
    /// Index of the setup, when only one.
    pub setup: Option<usize>,
    /// Only points with this axis going forward.
    pub forward: Option<String>,
    /// Only points with this axis going back.
    pub back: Option<String>,
    /// Points with this axis going either way, the sign turned over with it.
    pub turns: Option<String>,
}

/// A range of one axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisRange {
    /// Name of the axis.
    pub axis: String,
    /// First position, mm or degrees, inside the range.
    pub from: f64,
    /// Last position, inside it; on a full turn it may lie below the first.
    pub to: f64,
}

impl Place {
    /// Where and when, without the size: `Z, B −60° and below, both directions`.
    pub fn location(&self) -> String {
        let mut parts = vec![self.component.clone()];
        parts.extend(self.ranges.iter().cloned());
        let rest = [&self.direction, &self.setup, &self.time];
        parts.extend(rest.into_iter().filter(|part| !part.is_empty()).cloned());
        parts.join(", ")
    }

    /// Signed size: `+4.1 µm`, or `+2.0 µm with C forward, −2.0 µm with C back`.
    pub fn size(&self) -> String {
        let um = |um: f64| format!("{} µm", signed(um, 1));
        match &self.turns_with {
            None => um(self.mean_um),
            Some(axis) => {
                let (forward, back) = (um(self.mean_um), um(-self.mean_um));
                format!("{forward} with {axis} forward, {back} with {axis} back")
            }
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {} ({} readings)", self.location(), self.size(), self.readings)
    }
}

/// The places where `residual_mm` (all rows, measured − predicted) is worst, worst first, at most three; points with `used`
/// false take no part. Empty when no place stands out of the noise.
pub fn places(experiment: &Experiment, residual_mm: &DVector<f64>, used: &[bool]) -> Vec<Place> {
    let mut readings = Readings::new(experiment, residual_mm, used);
    let total = readings.sum_of_squares();
    let mut chosen: Vec<Found> = Vec::new();
    let mut places = Vec::new();
    while places.len() < MOST_PLACES && total > 0.0 {
        let Some(found) = scan::best(&readings, &chosen) else { break };
        if found.explains < LEAST_SHARE * total {
            break;
        }
        places.push(in_words(&readings, experiment, &found, total));
        readings.subtract(&found);
        chosen.push(found);
    }
    places
}

fn in_words(readings: &Readings, experiment: &Experiment, found: &Found, total: f64) -> Place {
    let mut ranges = Vec::new();
    let mut time = String::new();
    for &(dimension, from, to) in &found.ranges {
        let dimension = &readings.dimensions[dimension];
        let text = range_in_words(dimension, from, to);
        if dimension.letter.is_some() { ranges.push(text) } else { time = text }
    }
    let name = |letter: Joint| readings.name_of_way(letter);
    let direction = match found.way {
        Way::Forward(letter) => format!("{} forward", name(letter)),
        Way::Back(letter) => format!("{} back", name(letter)),
        Way::Turns(_) => String::new(),
        Way::All if readings.both_ways.is_empty() && readings.any_direction => "one direction only".into(),
        Way::All if readings.both_ways.is_empty() => String::new(),
        Way::All => "both directions".into(),
    };
    let setup = match (found.setup, experiment.setups.len()) {
        (_, 1) => String::new(),
        (Some(setup), _) => format!("setup {}", experiment.setups[setup].name),
        (None, 2) => "both setups".into(),
        (None, _) => "all setups".into(),
    };
    let place = Place {
        words: String::new(),
        component: readings.components[found.component].into(),
        ranges,
        direction,
        setup,
        time,
        mean_um: found.mean_um,
        turns_with: match found.way {
            Way::Turns(letter) => Some(name(letter)),
            Way::All | Way::Forward(_) | Way::Back(_) => None,
        },
        readings: found.readings * readings.every,
        share: found.explains / total,
        region: region(readings, found),
    };
    Place { words: place.to_string(), ..place }
}

fn region(readings: &Readings, found: &Found) -> Region {
    let name = |of: Option<Joint>| of.map(|joint| joint.to_string());
    let mut region = Region {
        component: found.component,
        setup: found.setup,
        forward: name(if let Way::Forward(joint) = found.way { Some(joint) } else { None }),
        back: name(if let Way::Back(joint) = found.way { Some(joint) } else { None }),
        turns: name(if let Way::Turns(joint) = found.way { Some(joint) } else { None }),
        ..Region::default()
    };
    for &(dimension, first, last) in &found.ranges {
        let dimension = &readings.dimensions[dimension];
        let (from, to) = (dimension.bins[first].0, dimension.bins[last].1);
        match dimension.letter {
            Some(joint) => region.axes.push(AxisRange { axis: joint.to_string(), from, to }),
            None => region.time_s = Some([from, to]),
        }
    }
    region
}

/// Bins `from..=to` of a dimension; on a full turn `to` may lie before `from`.
fn range_in_words(dimension: &Dimension, from: usize, to: usize) -> String {
    let (low, high) = (dimension.bins[from].0, dimension.bins[to].1);
    let last = dimension.bins.len() - 1;
    let Some(letter) = dimension.letter else {
        let minutes = |s: f64| format!("{:.0} min", (s - dimension.bins[0].0) / 60.0);
        return match (from, to) {
            (0, _) => format!("in the first {}", minutes(high)),
            (_, to) if to == last => format!("after {}", minutes(low)),
            _ => {
                format!("from {} to {}", minutes(low).trim_end_matches(" min"), minutes(high))
            }
        };
    };
    let unit = if letter.is_rotary() { "°" } else { " mm" };
    let number = |x: f64| format!("{}{unit}", trimmed(x, 1));
    match (from, to) {
        _ if low == high => format!("{letter} at {}", number(low)),
        _ if dimension.is_full_turn => format!("{letter} {} to {}", number(low), number(high)),
        (0, _) => format!("{letter} {} and below", number(high)),
        (_, to) if to == last => format!("{letter} {} and above", number(low)),
        _ => format!("{letter} {} to {}", number(low), number(high)),
    }
}

#[cfg(test)]
mod tests;
