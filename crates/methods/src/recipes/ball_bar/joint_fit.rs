//! The same location errors from the joint fit: the recipe applied to what the fit of all location errors and settings predicts.
//!
//! So both are compared in the same quantities, whatever the joint fit shares out between an axis and what carries it.

use super::location::{Location, locations};
use super::shape::{AxisShapes, Shape};
use super::track::recognised;
use crate::recipes::{Method, MethodError};
use trunnion_core::{Joint, Point};
use trunnion_cycles::{Run, RunKind};
use trunnion_engine::Problem;

pub(super) fn locations_of(
    method: &Method,
    problem: &Problem<'_>,
    asked: Option<Joint>,
) -> Result<Vec<Location>, MethodError> {
    let (experiment, joint) = (problem.experiment(), problem.fit());
    let predicted = |(i, point): (usize, &Point)| {
        let mut point = point.clone();
        for (k, row) in experiment.rows_of(i).enumerate() {
            point.reading_mm[k] = joint.predicted_mm[row];
        }
        point
    };
    let predicted_run = Run {
        name: "joint fit".into(),
        machine: experiment.machine().clone(),
        kind: if experiment.kinds.contains(&RunKind::OnTheFly) { RunKind::OnTheFly } else { RunKind::Static },
        setups: experiment.setups.clone(),
        channels: Vec::new(),
        points: experiment.points.iter().enumerate().map(predicted).collect(),
    };
    let tracks = recognised(method, &[predicted_run], asked)?;
    let shapes = Shape::of_all(method, &tracks.all)?;
    Ok(locations(&shapes, &AxisShapes::of_all(&shapes)))
}
