//! Which axes of a machine an effect can be about, and directions that belong to an axis.

use crate::Subject;
use nalgebra::{Unit, UnitQuaternion, Vector3};
use trunnion_core::{Joint, State};
use trunnion_machine::{Axis, Machine, Site};

/// One subject for every rotary axis of the machine.
pub fn every_rotary(machine: &Machine) -> Vec<Subject> {
    machine.rotary().iter().map(|axis| Subject::Axis(axis.letter)).collect()
}

/// One subject for every linear axis of the machine.
pub fn every_linear(machine: &Machine) -> Vec<Subject> {
    machine.linear_joints().into_iter().map(Subject::Axis).collect()
}

/// One subject for every linear axis that slides on a guideway: legs in parallel have none.
pub fn every_slide(machine: &Machine) -> Vec<Subject> {
    let slides = |letter: &Joint| !machine.is_leg(*letter);
    machine.linear_joints().into_iter().filter(slides).map(Subject::Axis).collect()
}

/// One subject for every axis of the machine.
pub fn every_axis(machine: &Machine) -> Vec<Subject> {
    machine.axes().map(|axis| Subject::Axis(axis.letter)).collect()
}

/// The axis of an axis effect.
pub(crate) fn axis_of(machine: &Machine, subject: Subject) -> Option<&Axis> {
    match subject {
        Subject::Axis(letter) => machine.axis(letter),
        Subject::Whole | Subject::Pair(..) => None,
    }
}

/// The next rotary axis towards the bed on the same side that turns about another direction.
pub(crate) fn rotary_below(machine: &Machine, letter: Joint) -> Option<&Axis> {
    let from_bed = machine.from_bed(machine.side(letter)?);
    let place = from_bed.iter().position(|axis| axis.letter == letter)?;
    let own = from_bed[place].direction;
    from_bed[..place]
        .iter()
        .rev()
        .copied()
        .find(|axis| axis.is_rotary() && axis.direction.cross(&own).norm() > 1e-3)
}

/// True for a rotary axis whose line is not vertical: gravity acts differently at each angle on what it carries, a table or a head.
pub(crate) fn tilts(axis: &Axis) -> bool {
    axis.is_rotary() && axis.direction.cross(&Vector3::z()).norm() > 1e-3
}

/// The two directions across an axis, right-handed with it, with the letters they are nearest to (X, Y, Z by index).
pub(crate) struct Across {
    pub first: Vector3<f64>,
    pub second: Vector3<f64>,
    /// Index 0..3 of the coordinate directions `first`, `second` and the axis itself are nearest to.
    pub index: [usize; 3],
}

pub(crate) fn across(direction: &Unit<Vector3<f64>>) -> Across {
    let along = direction.iamax();
    let near = Vector3::ith((along + 1) % 3, 1.0);
    let first = (near - direction.into_inner() * direction.dot(&near)).normalize();
    let second = direction.cross(&first) * direction[along].signum();
    Across { first, second, index: [(along + 1) % 3, (along + 2) % 3, along] }
}

/// X, Y, Z for 0, 1, 2.
pub(crate) fn linear_name(index: usize) -> &'static str {
    Joint::LINEAR[index].as_str()
}

/// A, B, C for 0, 1, 2.
pub(crate) fn rotary_name(index: usize) -> &'static str {
    Joint::ROTARY[index].as_str()
}

/// Carrier from carried axes of a rotary axis at its nominal angle.
pub(crate) fn carrier_from_carried(axis: &Axis, state: &State) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&axis.direction, axis.sense * state.position[axis.letter])
}

/// Unit vector of gravity in the axes of the component that carries `axis`.
pub(crate) fn gravity_in_carrier(machine: &Machine, axis: &Axis, state: &State) -> Vector3<f64> {
    let gravity_in_machine = -Vector3::z();
    machine
        .joint_frame(axis.letter, &state.position)
        .map_or(gravity_in_machine, |frame| frame.machine_from_carrier.inverse() * gravity_in_machine)
}

/// A place on the tool side that moves the whole tool branch, and its axes from machine axes.
pub(crate) fn whole_tool_side(machine: &Machine, state: &State) -> (Site, UnitQuaternion<f64>) {
    machine.whole_tool_side(&state.position)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_directions_across_an_axis_are_the_other_two_coordinates() {
        let across = across(&Vector3::y_axis());
        assert_eq!((across.first, across.second, across.index), (Vector3::z(), Vector3::x(), [2, 0, 1]));
    }
}
