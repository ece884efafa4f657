//! How an axis went from point to point, and what was stated of it.

use std::f64::consts::TAU;
use trunnion_core::{Joint, Point};

/// Share of the steps that must go against one stated direction: in a cycle of one direction each pass, of four steps or more, may be
/// followed by one step back.
const AGAINST: f64 = 0.2;
/// Steps of an axis below which nothing is said of its direction: two passes.
pub(crate) const FEWEST_STEPS: usize = 8;

/// From one point to the next of a setup.
pub(crate) struct Step {
    /// By the positions, mm or rad.
    pub moved: f64,
    /// The short way round; half a turn goes either way.
    pub way: f64,
    /// Direction from which the point was reached, as stated.
    pub stated: f64,
}

impl Step {
    pub fn is_contrary(&self) -> bool {
        self.way * self.stated < 0.0
    }
}

/// Steps of one run at which the axis moved and a direction is stated.
pub(crate) fn steps(points: &[Point], joint: Joint) -> Vec<Step> {
    steps_by(points, joint, joint)
}

/// Steps of `joint` with the direction that is stated of another one.
pub(crate) fn steps_by(points: &[Point], joint: Joint, stated_of: Joint) -> Vec<Step> {
    points
        .windows(2)
        .filter(|pair| pair[0].state.setup == pair[1].state.setup)
        .map(|pair| {
            let moved = pair[1].state.position[joint] - pair[0].state.position[joint];
            let turns = if joint.is_rotary() { (moved / TAU).round() } else { 0.0 };
            Step { moved, way: moved - turns * TAU, stated: pair[1].state.direction[stated_of] }
        })
        .filter(|step| step.moved != 0.0 && step.stated != 0.0)
        .collect()
}

/// The one direction that is stated at every point.
pub(crate) fn only_direction(points: &[Point], joint: Joint) -> Option<f64> {
    let stated = points.first()?.state.direction[joint];
    let is_only = stated != 0.0 && points.iter().all(|point| point.state.direction[joint] == stated);
    is_only.then_some(stated)
}

/// One stated direction of an axis that went both ways.
pub(crate) struct OneDirection {
    pub stated: f64,
    /// Steps that went the other way, and all.
    pub contrary: [usize; 2],
}

/// `None` where both directions are stated, or the axis hardly went the other way.
pub(crate) fn one_direction(points: &[Point], joint: Joint) -> Option<OneDirection> {
    let stated = only_direction(points, joint)?;
    let steps = steps(points, joint);
    let contrary = [steps.iter().filter(|step| step.is_contrary()).count(), steps.len()];
    let went_both_ways = steps.len() >= FEWEST_STEPS && contrary[0] as f64 > AGAINST * contrary[1] as f64;
    went_both_ways.then_some(OneDirection { stated, contrary })
}
