//! Which axis made the deviation: the share of every axis in the error of the tool's path [S3 §3.1].
//!
//! `share_k(t) = f(q(t)) − f(q(t) with q_k ideal)`, q the positions that the axes' own encoders measured, f the exact pose of
//! the tool against the table: what disappears when the measured motion of axis k alone is replaced by its ideal motion.
//! Deviations of the tool point and rotations of the tool are in machine axes.
//! The ideal motion comes from the cycle where there is one (`ideal::of_cycle`), from the commanded positions where a table has
//! them, else it is a smooth path through the measured positions of each axis (S3: "an approximated curve").
//! Limits: an encoder sees what its own axis does: lag, reversal spikes, cyclic speed. Errors between encoders and tool
//! (geometry, backlash behind an encoder, bending) are in no share. A smooth path cannot bend within two knots: it is held against one
//! with twice the knots, and refused where the deviation is mostly such a bend.

mod error;
mod ideal;
mod motion;
mod present;
mod smooth;

pub use error::AttributionError;
pub use motion::{Ideal, LeftOut, Motion};

use crate::common::rounding::{ROUNDING_MM, without};
use nalgebra::{Point3, Vector3};
use std::ops::Range;
use trunnion_core::statistics::rms;
use trunnion_core::{AxisValues, Joint};
use trunnion_machine::JointErrors;

/// Shares of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribution {
    /// Name of the recording.
    pub run: String,
    /// Name of the machine.
    pub machine: String,
    /// Where the ideal motion comes from.
    pub ideal: Ideal,
    /// Times of the samples judged, s.
    pub time_s: Vec<f64>,
    /// Ideal position of the turning axis, or ideal angle on the curve, at these times, rad; empty without a cycle.
    pub angle_rad: Vec<f64>,
    /// First and last sample of every pass.
    pub passes: Vec<Range<usize>>,
    /// Samples that have no ideal motion: they are in no figure.
    pub left_out: LeftOut,
    /// Axes that move, largest share first.
    pub shares: Vec<Share>,
    /// All axes together: measured against ideal path.
    pub together: Deviation,
    /// Largest difference between the sum of the shares and all together, mm.
    pub beyond_sum_mm: f64,
}

/// What one axis did.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// Which axis.
    pub axis: Joint,
    /// Its own deviation, measured minus ideal, mm or rad.
    pub own: Vec<f64>,
    /// What it did to the tool.
    pub deviation: Deviation,
}

/// Deviation of the tool against the table over time, machine axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Of the tool point, mm.
    pub place_mm: Vec<Vector3<f64>>,
    /// Rotation of the tool, rad.
    pub turn_rad: Vec<Vector3<f64>>,
}

/// Fewest axis positions for a judgement.
const FEWEST: usize = 16;
/// Rounding of the rotation of a pose: nothing is smaller, rad.
const ROUNDING_RAD: f64 = 1e-12;

/// Share of the largest deviation that is left on a path with twice the knots. Scatter keeps √(2/3) = 0.82 of it at the fewest
/// samples, four a knot; what is shorter than half a knot keeps all; a bend keeps 1/16 (`smooth`).
const LEFT_WITH_TWICE_THE_KNOTS: f64 = 0.7;
/// Nothing below the last digit of a table shows, mm.
const SHOWN_MM: f64 = 1e-5;

/// Judges a motion.
///
/// # Errors
/// Too few positions, knots that do not fit them or the way an axis bends, a cycle or positions that do not fit the machine.
pub fn attribute(motion: &Motion<'_>) -> Result<Attribution, AttributionError> {
    let run = motion.run.to_string();
    if motion.samples.len() < FEWEST {
        return Err(AttributionError::NoAxes { run, found: motion.samples.len(), least: FEWEST });
    }
    let attribution = shared(motion, ideal::find(motion)?)?;
    if matches!(attribution.ideal, Ideal::Smooth { .. }) {
        let (peak_mm, axis) = attribution.largest_share();
        let (finer_mm, _) = shared(motion, ideal::smoothed_twice_as_fine(motion)?)?.largest_share();
        if peak_mm > SHOWN_MM && finer_mm < LEFT_WITH_TWICE_THE_KNOTS * peak_mm {
            let axis = axis.map_or_else(String::new, |axis| axis.to_string());
            let (peak_um, finer_um) = (1e3 * peak_mm, 1e3 * finer_mm);
            return Err(AttributionError::Bends { run, axis, knot_s: motion.knot_s, peak_um, finer_um });
        }
    }
    Ok(attribution)
}

/// The shares of the axes against an ideal motion.
fn shared(motion: &Motion<'_>, found: ideal::Found) -> Result<Attribution, AttributionError> {
    let run = motion.run.to_string();
    let none = JointErrors::default();
    let machine = motion.machine;
    let axes: Vec<Joint> = machine.axes().map(|axis| axis.letter).collect();
    let mut shares: Vec<Share> =
        axes.iter().map(|&axis| Share { axis, own: Vec::new(), deviation: Deviation::default() }).collect();
    let mut together = Deviation::default();
    let mut beyond_sum_mm = 0f64;
    for (&i, ideal) in found.samples.iter().zip(&found.positions) {
        let measured = &motion.samples[i].position;
        let machine_from_table = machine.machine_from_table(measured, &none);
        let against = |other: &AxisValues<f64>| {
            let tool = |q: &AxisValues<f64>| {
                machine_from_table
                    * machine.machine_from_table(q, &none).inverse()
                    * machine.machine_from_tool(q, &none)
            };
            let (is, was) = (tool(measured), tool(other));
            let place = is * Point3::origin() - was * Point3::origin();
            let turn = (is.rotation * was.rotation.inverse()).scaled_axis();
            (place.map(|mm| without(mm, ROUNDING_MM)), turn.map(|rad| without(rad, ROUNDING_RAD)))
        };
        let mut sum = Vector3::zeros();
        for share in &mut shares {
            let mut replaced = *measured;
            replaced[share.axis] = ideal[share.axis];
            let (place, turn) = against(&replaced);
            let rounding = if share.axis.is_rotary() { ROUNDING_RAD } else { ROUNDING_MM };
            share.own.push(without(measured[share.axis] - ideal[share.axis], rounding));
            share.deviation.place_mm.push(place);
            share.deviation.turn_rad.push(turn);
            sum += place;
        }
        let (place, turn) = against(ideal);
        if !(place.norm() + turn.norm() + sum.norm()).is_finite() {
            return Err(AttributionError::NoPose { run, time_s: motion.samples[i].time_s });
        }
        together.place_mm.push(place);
        together.turn_rad.push(turn);
        beyond_sum_mm = beyond_sum_mm.max((place - sum).norm());
    }
    shares.retain(|share| share.own.iter().any(|own| *own != 0.0));
    shares.sort_by(|a, b| b.deviation.peak_mm().total_cmp(&a.deviation.peak_mm()));
    Ok(Attribution {
        run,
        machine: machine.name.clone(),
        ideal: found.ideal,
        time_s: found.samples.iter().map(|&i| motion.samples[i].time_s).collect(),
        angle_rad: found.angle_rad,
        passes: found.passes,
        left_out: found.left_out,
        shares,
        together,
        beyond_sum_mm,
    })
}

impl Attribution {
    /// Largest deviation of the tool point that one axis made, mm, and which one.
    fn largest_share(&self) -> (f64, Option<Joint>) {
        self.shares.first().map_or((0.0, None), |share| (share.deviation.peak_mm(), Some(share.axis)))
    }
}

impl Deviation {
    /// Largest distance of the tool point from where it should be, mm.
    pub fn peak_mm(&self) -> f64 {
        self.place_mm.iter().map(Vector3::norm).fold(0.0, f64::max)
    }

    /// Largest deviation of the tool point along X, Y, Z, mm, with its sign.
    pub fn peaks_mm(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| largest(self.place_mm.iter().map(|place| place[k])))
    }

    /// Root mean square of the deviation along X, Y, Z, mm.
    pub fn rms_mm(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| rms(self.place_mm.iter().map(|place| place[k])).unwrap_or(0.0))
    }

    /// Largest rotation of the tool, rad.
    pub fn peak_rad(&self) -> f64 {
        self.turn_rad.iter().map(Vector3::norm).fold(0.0, f64::max)
    }

    /// Root mean square of the rotation of the tool, rad.
    pub fn rms_rad(&self) -> f64 {
        rms(self.turn_rad.iter().map(Vector3::norm)).unwrap_or(0.0)
    }
}

/// The value with the largest size, with its sign.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
}
