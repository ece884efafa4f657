//! Directions of the axes that a points file does not state: from one commanded position to the next.

use crate::{AxisValues, Joint, Slot, State};

/// Smallest travel that counts as motion, mm or rad.
pub const STANDSTILL: f64 = 1e-6;

/// The travel of all axes so far, from point to point.
#[derive(Clone, Debug, Default)]
pub struct Travel {
    last: Option<AxisValues<f64>>,
    heading: AxisValues<f64>,
    travelled: AxisValues<f64>,
}

impl Travel {
    /// Fills the direction of every axis in `letters` with the sign of its last travel (0 before the first), and
    /// `since_reversal` of all axes with the travel since they last turned round; one point after the other.
    pub fn fill(&mut self, state: &mut State, letters: &[Joint]) {
        let Some(last) = self.last.replace(state.position) else { return };
        for slot in Slot::ALL {
            let step = state.position[slot] - last[slot];
            if step.abs() > STANDSTILL {
                let goes_on = step.signum() == self.heading[slot];
                self.travelled[slot] = if goes_on { self.travelled[slot] + step.abs() } else { step.abs() };
                self.heading[slot] = step.signum();
            }
            state.since_reversal[slot] = self.travelled[slot];
            if letters.iter().any(|letter| letter.slot() == slot) {
                state.direction[slot] = self.heading[slot];
            }
        }
    }
}
