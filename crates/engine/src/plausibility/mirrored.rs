//! Machines that are mirror images of each other: positions cannot tell them apart.
//!
//! A mirror across the plane normal to a linear axis reverses this axis, and every turn about a line in the plane; turns about the normal keep their
//! sense (an angular velocity is a pseudovector). So all positions fit as well with the one sense reversed as with the others,
//! and readings fit in either as soon as their component along the normal is reversed too. Location errors have other signs in the mirror.
//! Limits: there is a mirror only where each rotary axis lies in the plane or along its normal, and where the balls fit as well; that is tried.

use super::claim::{Claim, TOGETHER_MM};
use trunnion_core::Joint;
use trunnion_machine::Machine;

/// A direction is along or across another within this cosine: as axes stand in machine files.
const SQUARE: f64 = 1e-6;

/// A linear axis and the rotary ones of which the senses are reversed by the mirror across it.
pub(super) struct Mirror {
    pub linear: Joint,
    pub rotary: Vec<Joint>,
}

impl Mirror {
    /// Every mirror of a machine.
    pub fn all(machine: &Machine) -> Vec<Self> {
        let of_linear = |linear: Joint| {
            let normal = machine.axis(linear)?.direction;
            let cosine = |axis: &trunnion_machine::Axis| axis.direction.dot(&normal).abs();
            let rotary = machine.rotary();
            let is_square = rotary.iter().all(|axis| cosine(axis) < SQUARE || cosine(axis) > 1.0 - SQUARE);
            let across = rotary.iter().filter(|axis| cosine(axis) < SQUARE).map(|axis| axis.letter);
            let mirror = Self { linear, rotary: across.collect() };
            (is_square && !machine.is_leg(linear) && !mirror.rotary.is_empty()).then_some(mirror)
        };
        machine.linear_joints().into_iter().filter_map(of_linear).collect()
    }

    /// "A and C".
    pub fn rotary_names(&self) -> String {
        names(&self.rotary)
    }

    /// What tells the two apart: nothing in the positions does.
    pub fn distinguished_by(&self) -> String {
        let turns: Vec<String> = self.rotary.iter().map(|axis| format!("+{axis}")).collect();
        format!(
            "Positions cannot distinguish these: they are mirror images, and in the wrong one values have the wrong sign. Look at the machine first: jog {} \
             and +{}, compare each with the machine file, and change what differs. Controls often count rotary axes the other way.",
            turns.join(", "),
            self.linear
        )
    }
}

/// "A and C".
pub(super) fn names(joints: &[Joint]) -> String {
    joints.iter().map(|joint| joint.as_str()).collect::<Vec<_>>().join(" and ")
}

/// A claim with the senses of some axes reversed.
pub(super) fn reversed_mm(claim: &Claim<'_>, joints: &[Joint]) -> f64 {
    let turned = claim.turned(|position| {
        let mut changed = *position;
        joints.iter().for_each(|&joint| changed[joint] = -changed[joint]);
        changed
    });
    turned.rms_mm()
}

/// The mirror of which positions fit on both sides, where they do not fit as they are.
pub(super) fn either_side(claim: &Claim<'_>) -> Option<Mirror> {
    let fits = |joints: &[Joint]| reversed_mm(claim, joints) < TOGETHER_MM;
    Mirror::all(claim.machine).into_iter().find(|mirror| fits(&[mirror.linear]) && fits(&mirror.rotary))
}

/// The mirror with which positions fit as they do without it, across the axis along which a probe reads.
pub(super) fn as_good(claim: &Claim<'_>, along: usize) -> Option<Mirror> {
    let is_along = |mirror: &Mirror| {
        claim.machine.axis(mirror.linear).is_some_and(|axis| axis.direction[along].abs() > 1.0 - SQUARE)
    };
    let fits = |mirror: &Mirror| {
        let joints: Vec<Joint> = mirror.rotary.iter().copied().chain([mirror.linear]).collect();
        reversed_mm(claim, &joints) < TOGETHER_MM
    };
    Mirror::all(claim.machine).into_iter().filter(is_along).find(fits)
}
