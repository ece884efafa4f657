//! Error motions from the shapes.

use super::causes::ErrorKind;
use super::shape::{AxisShapes, Contour};
use super::track::Axis;
use trunnion_core::number::fixed;
use trunnion_effects::Unit;

/// One error motion over the turn.
pub(super) struct ErrorMotion {
    pub name: String,
    pub unit: Unit,
    pub points: Contour,
    pub kind: ErrorKind,
    pub axis: Axis,
    /// The axis is upright: gravity does not turn about it.
    pub upright: bool,
    /// What it is, and where it holds.
    pub about: String,
}

/// Radial, axial and tilt error motions of an axis, those that were measured.
pub(super) fn error_motions(of_axis: &AxisShapes) -> Vec<ErrorMotion> {
    let axis = of_axis.axis;
    let upright = axis.is_upright();
    let mut motions = Vec::new();
    for (k, points) in of_axis.translation.iter().enumerate() {
        let (kind, about) = match of_axis.radial_at_mm.get(k) {
            None => (ErrorKind::Axial, "axial error motion".into()),
            Some(at) => {
                let at = at.unwrap_or(0.0);
                (
                    ErrorKind::Radial,
                    format!("radial error motion at height {} mm over the reference point", fixed(at, 0)),
                )
            }
        };
        let name = axis.symbol(axis.frame[k], false);
        motions.push(ErrorMotion {
            name,
            unit: Unit::UM,
            points: points.clone(),
            kind,
            axis,
            upright,
            about,
        });
    }
    for (k, points) in of_axis.tilt.iter().enumerate() {
        let name = axis.symbol(axis.rotations()[k], false);
        let (kind, about) = (ErrorKind::Tilt, "tilt error motion".into());
        motions.push(ErrorMotion {
            name,
            unit: Unit::URAD,
            points: points.clone(),
            kind,
            axis,
            upright,
            about,
        });
    }
    motions.retain(|motion| !motion.points.is_empty());
    motions
}
