//! Location errors from the shapes.

use super::causes::ErrorKind;
use super::shape::{AxisShapes, Shape};
use super::track::Kind;
use crate::common::shares::{Shares, u_under_noise};
use crate::recipes::{Convention, MethodError};
use trunnion_core::Joint;
use trunnion_effects::Unit;
use trunnion_engine::{BeyondModel, Patterns, Problem};

/// A location error, right-handed, inside units.
pub(super) struct Location {
    pub name: String,
    pub value: f64,
    pub unit: Unit,
    pub u: f64,
    /// What each reading counts in it.
    pub shares: Shares,
    pub kind: ErrorKind,
    /// S4 prints it with the opposite sign.
    pub opposite_in_source: bool,
}

impl Location {
    pub fn shown(&self, convention: Convention) -> f64 {
        if convention == Convention::Source && self.opposite_in_source { -self.value } else { self.value }
    }
}

/// Location errors by S4 eq. 1–7, in the signs of docs/design/physics.md §1.
pub(super) fn locations(shapes: &[Shape], axes: &[AxisShapes]) -> Vec<Location> {
    let mut found = Vec::new();
    for of_axis in axes {
        let axis = of_axis.axis;
        let [tilt_u, tilt_v, _] = axis.rotations();
        // S4 eq. 1 and 3 are of C.
        let of_c = axis.frame[2] == Joint::Z;
        let squareness = |direction, value, u, shares: &Shares, opposite_in_source| Location {
            name: axis.symbol(direction, true),
            value,
            unit: Unit::URAD,
            u,
            shares: shares.clone(),
            kind: ErrorKind::Squareness,
            opposite_in_source,
        };
        if let Some(line) = of_axis.line[1] {
            found.push(squareness(tilt_u, -line.slope, line.u_slope, &of_axis.shares_of_line[1][1], false));
        }
        if let Some(line) = of_axis.line[0] {
            found.push(squareness(tilt_v, line.slope, line.u_slope, &of_axis.shares_of_line[0][1], of_c));
        }
        for (k, line) in of_axis.line.iter().enumerate() {
            let Some(line) = line.filter(|_| of_axis.calibrated) else { continue };
            found.push(Location {
                name: axis.symbol(axis.frame[k], true),
                value: line.at_zero,
                unit: Unit::UM,
                u: line.u_at_zero,
                shares: of_axis.shares_of_line[k][0].clone(),
                kind: ErrorKind::Place,
                opposite_in_source: of_c,
            });
        }
    }
    for shape in shapes {
        let Kind::Followed { axis, .. } = shape.kind else { continue };
        for k in 0..2 {
            found.push(Location {
                name: format!("{} by {}", axis.symbol(axis.rotations()[k], true), shape.label),
                value: shape.centre[k],
                unit: Unit::URAD,
                u: shape.u_centre[k],
                shares: shape.shares_of_centre[k].clone(),
                kind: ErrorKind::Squareness,
                opposite_in_source: false,
            });
        }
    }
    found
}

/// With u under the noise that all readings show together; false where they show none, so that u stays what the centring leaves.
pub(super) fn under_noise(found: &mut [Location], problem: &Problem<'_>) -> Result<bool, MethodError> {
    let shares: Vec<&Shares> = found.iter().map(|location| &location.shares).collect();
    let beyond = BeyondModel { patterns: Patterns::Described, ..BeyondModel::NOTHING };
    let Some(u) = u_under_noise(problem, &shares, beyond)? else { return Ok(false) };
    found.iter_mut().zip(u).for_each(|(location, u)| location.u = u);
    Ok(true)
}
