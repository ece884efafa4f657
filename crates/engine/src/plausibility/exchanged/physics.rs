//! Errors of one axis, or one slip of the ball, that explain readings as well as a mistake does: the mistake is not believed then.
//!
//! A free angle, or a long arm between axes, lets wrong readings imitate an error of an axis that the base model lacks. A mistake does not
//! look like one error of one axis: it moves all that the readings hold. A slip on a machine with small errors has location errors of its own from
//! then on, some of which imitate it where the table turns: rows of another day have others, which no slip imitates.

use super::Trial;
use trunnion_core::State;
use trunnion_effects::{Instance, Role};

/// The effect.
const SLIP: &str = "setup-slip";
/// Moments of a slip that are tried at once, evenly; then those next to the best. For time only.
const TRIED_AT_ONCE: usize = 100;

impl Trial<'_> {
    /// The least that the base model leaves with one more effect of the catalogue, mm rms.
    pub(super) fn of_an_effect_mm(&self) -> f64 {
        self.model.rms_with_an_axis_mm(self.experiment, |_| true).min(self.of_a_slip_mm())
    }

    /// The same with an effect of which every machine has a little, and none has much, left out.
    pub(super) fn of_a_large_effect_mm(&self) -> f64 {
        let is_large = |instance: &Instance| instance.role() != Role::Natural;
        self.model.rms_with_an_axis_mm(self.experiment, is_large).min(self.of_a_slip_mm())
    }

    /// With one slip of the ball or nest on the table, at whatever point; infinite without times.
    fn of_a_slip_mm(&self) -> f64 {
        let (scene, points) = (&self.experiment.scene, &self.experiment.points);
        let readings_mm = self.experiment.readings_mm();
        let elapsed_s = |state: &State| scene.elapsed_s(state);
        let is_slip = |instance: &Instance| instance.id() == SLIP && !instance.parameters(scene).is_empty();
        let Some(slip) = Instance::all(self.experiment.machine()).into_iter().find(is_slip) else {
            return f64::INFINITY;
        };
        let least = |first: usize, end: usize, every: usize| {
            let left = |at: usize| {
                let columns = self.experiment.columns(&slip, &[elapsed_s(&points[at].state)?]);
                Some((at, self.model.rms_with_mm(&columns, &readings_mm)))
            };
            (first..end).step_by(every).filter_map(left).min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let every = points.len().div_ceil(TRIED_AT_ONCE).max(1);
        let near = least(1, points.len(), every)
            .and_then(|(at, _)| least(at.saturating_sub(every).max(1), (at + every).min(points.len()), 1));
        near.map_or(f64::INFINITY, |(_, left_mm)| left_mm)
    }
}
