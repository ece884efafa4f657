//! Positions of the tool tip on the workpiece, as a control shows them where it compensates the turning of the rotary axes (RTCP, TCPM,
//! TRAORI): the tip stays at the ball, so that X, Y, Z stay while the rotary axes turn.

use super::claim::{Claim, TOGETHER_MM};
use trunnion_core::Joint;

/// Whether in every setup the linear axes stand while the rotary ones turn the ball away from the nest: a constant distance is another mistake.
pub(super) fn stands_while_turning(claim: &Claim<'_>) -> bool {
    let (linear, rotary) = (claim.machine.linear_joints(), claim.machine.rotary_joints());
    let span = |setup: usize, joint: Joint| {
        let own = claim.positions.iter().filter(|(of, _)| *of == setup).map(|(_, position)| position[joint]);
        let (least, most) =
            own.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), at| (least.min(at), most.max(at)));
        most - least
    };
    let own = |setup: usize| claim.positions.iter().any(|(of, _)| *of == setup);
    let setups: Vec<usize> = (0..claim.setups.len()).filter(|&setup| own(setup)).collect();
    let stands = |setup: usize| linear.iter().all(|&joint| span(setup, joint) < TOGETHER_MM);
    let turns = |setup: usize| rotary.iter().any(|&joint| span(setup, joint) > TOGETHER_MM);
    let off = claim.off_mm();
    let is_constant = off.iter().all(|at| (at - off[0]).norm() < TOGETHER_MM);
    // Lengths given in metres hardly move either.
    let of_metres = claim.turned(|position| {
        let mut changed = *position;
        linear.iter().for_each(|&joint| changed[joint] *= 1e3);
        changed
    });
    linear.len() == 3
        && !is_constant
        && of_metres.rms_mm() > TOGETHER_MM
        && setups.iter().all(|&setup| stands(setup))
        && setups.iter().any(|&setup| turns(setup))
}

pub(super) const HYPOTHESIS: &str = "X, Y and Z stand while the rotary axes turn: they are the position of the tool tip on the workpiece (RTCP, TCPM, \
     TRAORI), not of the axes. Log machine coordinates, as the encoders read.";
