//! Directions of the axes that a points file does not state: from one commanded position to the next.

use crate::{AxisLetter, Point, Slot};

/// Smallest travel that counts as motion, mm or rad.
const STANDSTILL: f64 = 1e-6;

/// Fills the direction of every axis in `letters` with the sign of its last travel (0 before the first),
/// and `since_reversal` of all axes with the travel since they last turned round.
pub fn fill_directions(points: &mut [Point], letters: &[AxisLetter]) {
    for slot in Slot::ALL {
        let (mut heading, mut travelled) = (0.0, 0.0);
        for i in 1..points.len() {
            let step = points[i].state.position[slot] - points[i - 1].state.position[slot];
            if step.abs() > STANDSTILL {
                travelled = if step.signum() == heading { travelled + step.abs() } else { step.abs() };
                heading = step.signum();
            }
            points[i].state.since_reversal[slot] = travelled;
            if letters.iter().any(|letter| letter.slot() == slot) {
                points[i].state.direction[slot] = heading;
            }
        }
    }
}
