//! What a technician reads at a few poses: without a correction, with its right sign, and with the wrong one.
//!
//! now f(x̂),  right f(x̂) − Δ,  wrong f(x̂) + Δ
//! f the exact prediction of the whole model, settings of ball and instrument as fitted; Δ what the errors in the file change of it (to first order).
//! What a control does not take is in all three: the right sign alone may leave most of a reading.

use super::shown::seen_mm;
use crate::{Error, Fit};
use nalgebra::Vector3;
use trunnion_core::convert::{deg_from_rad, um_from_mm};
use trunnion_core::{AxisValues, Joint, State};
use trunnion_machine::Machine;
use trunnion_results::{AxisErrors, SignCheck};

/// Readings at one pose, mm.
pub(super) struct Signs {
    pub without_mm: Vector3<f64>,
    pub change_mm: Vector3<f64>,
}

impl Signs {
    /// At each of these states, of the runs of `fit`.
    ///
    /// # Errors
    /// A model that does not suit the runs.
    pub fn at(fit: &Fit, errors: &AxisErrors, states: &[State]) -> Result<Vec<Self>, Error> {
        let points = fit.experiment().points();
        let model = fit.model().entries();
        let without_mm = trunnion_engine::readings_at(points, model, fit.identification(), states)?;
        let change_mm = |state: &State| seen_mm(points.machine(), &points.setups[state.setup], state, errors);
        let of_state = |(without_mm, state)| Self { without_mm, change_mm: change_mm(state) };
        Ok(without_mm.into_iter().zip(states).map(of_state).collect())
    }

    /// The mean over poses.
    pub fn mean(all: &[Self]) -> Self {
        let mean = |of: fn(&Self) -> Vector3<f64>| {
            all.iter().map(of).sum::<Vector3<f64>>() / all.len().max(1) as f64
        };
        Self { without_mm: mean(|signs| signs.without_mm), change_mm: mean(|signs| signs.change_mm) }
    }

    /// The same about other readings.
    pub fn about(&self, other: &Self) -> Self {
        Self { without_mm: self.without_mm - other.without_mm, change_mm: self.change_mm - other.change_mm }
    }

    /// Without the correction, with the right sign and with the wrong one, µm, of so many components.
    pub fn um(&self, components: usize) -> [Vec<f64>; 3] {
        [0.0, -1.0, 1.0].map(|share| {
            let reading_mm = self.without_mm + self.change_mm * share;
            (0..components).map(|k| um_from_mm(reading_mm[k])).collect()
        })
    }
}

/// Two measured points as a check: zero at one, read at the other. Both at the time and the temperatures of the first, as the check takes a minute.
///
/// # Errors
/// A model that does not suit the runs.
pub(super) fn check(fit: &Fit, errors: &AxisErrors, [from, to]: [usize; 2]) -> Result<SignCheck, Error> {
    let points = fit.experiment().points();
    let zeroed = points.points[from].state.clone();
    let State { time_s, temperature_degc, .. } = zeroed.clone();
    let read = State { time_s, temperature_degc, ..points.points[to].state.clone() };
    let setup = &points.setups[zeroed.setup];
    let components = setup.instrument.components();
    let pose = |state: &State| pose(points.machine(), &state.position);
    let (from, to) = (pose(&zeroed), pose(&read));
    let signs = Signs::at(fit, errors, &[zeroed, read])?;
    let [without_um, right_um, wrong_um] = signs[1].about(&signs[0]).um(components.len());
    let components = components.iter().map(ToString::to_string).collect();
    Ok(SignCheck { setup: setup.name.clone(), from, to, components, without_um, right_um, wrong_um })
}

/// Positions of the rotary axes, or of the linear ones where there are none.
pub(super) fn pose(machine: &Machine, position: &AxisValues<f64>) -> String {
    let rotary = machine.rotary_joints();
    let joints = if rotary.is_empty() { machine.linear_joints() } else { rotary };
    let one = |joint: &Joint| match joint.is_rotary() {
        true => format!("{joint} {:.3}°", deg_from_rad(position[*joint])),
        false => format!("{joint} {:.3}", position[*joint]),
    };
    joints.iter().map(one).collect::<Vec<_>>().join(" ")
}
