//! Errors of one axis that explain readings as well as a mistake does: the mistake is not believed then.
//!
//! A free angle, or a long arm between axes, lets wrong readings imitate an error of an axis that the base model lacks. A mistake does not
//! look like one error of one axis: it moves all that the readings hold.

use super::Trial;
use trunnion_effects::{Instance, Role, Subject};

impl Trial<'_> {
    /// The least that the base model leaves with one more error of one axis, mm rms. Errors with shape numbers are not tried.
    pub(super) fn of_an_axis_mm(&self) -> f64 {
        let scene = &self.experiment.scene;
        let is_of_axis = |instance: &Instance| {
            instance.subject() != Subject::Whole
                && !matches!(instance.role(), Role::Setting | Role::Description)
        };
        let can_be = |instance: &Instance| {
            !instance.parameters(scene).is_empty() && instance.shapes(scene).names.is_empty()
        };
        let readings_mm = self.experiment.readings_mm();
        let left = |instance: Instance| {
            self.model.rms_with_mm(&self.experiment.columns(&instance, &[]), &readings_mm)
        };
        let all = Instance::all(self.experiment.machine()).into_iter();
        all.filter(is_of_axis).filter(can_be).map(left).fold(f64::INFINITY, f64::min)
    }
}
