//! Readings in axes that turn otherwise than the nest does: a control or a program turned them with a rotary axis, or did not.

use super::Trial;
use crate::plausibility::fitted::Tried;
use nalgebra::{Rotation3, Vector3};

impl Trial<'_> {
    /// With each rotary axis, each way.
    pub(super) fn turning(&self) -> Vec<Tried> {
        let machine = self.experiment.machine();
        let both = |axis: &trunnion_machine::Axis| {
            let of_sense = |sense: f64| {
                let left_mm = self.left_mm(|readings| {
                    for (reading, point) in readings.iter_mut().zip(&self.experiment.points) {
                        let angle = sense * axis.sense * point.state.position[axis.letter];
                        let turned =
                            Rotation3::from_axis_angle(&axis.direction, angle) * Vector3::from(*reading);
                        *reading = turned.into();
                    }
                });
                let sign = if sense < 0.0 { "−" } else { "" };
                let words = format!(
                    "the readings turned by {sign}{0}: they are in axes that turn otherwise with {0} than the nest",
                    axis.letter.as_str()
                );
                (words, left_mm)
            };
            [of_sense(1.0), of_sense(-1.0)]
        };
        machine.rotary().into_iter().flat_map(both).collect()
    }
}
