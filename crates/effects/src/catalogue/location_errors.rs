//! Location errors: constant errors of place and direction of the axis average lines.
//!
//! Rotary axis R:  δ = (EX0R, EY0R, EZ0R),  ω = (EA0R, EB0R, EC0R) at the joint of R  [ISO 230-1; S1 eq. 6–7; S2 tables 2–5].
//! No rotary axis: squareness EC0Y (X to Y), EB0Z (X to Z), EA0Z (Y to Z), as rotations of the Y and Z joints.
//! All six of each rotary axis are carried; which of them nobody can see is for the fit to say, and
//! [`conventional_zeros`] names those that ISO's minimum set leaves out.
//! Limits: constant over the run; small angles.

use crate::{
    About, Effect, Emit, Example, Golden, Limit, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit,
    View,
};
use nalgebra::Vector3;
use trunnion_core::{Joint, State, Twist};
use trunnion_machine::{Axis, Machine, Side, Site};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "location-errors",
    role: Role::Location,
    about: About {
        title: "Location errors of the axis average lines",
        source: "ISO 230-1 §3; S1 eq. 6–7; S2 tables 2–5",
        equation: "δ = (EX0R, EY0R, EZ0R), ω = (EA0R, EB0R, EC0R) at the joint of each rotary axis R",
        symbols: "δ place of the axis line, µm; ω its direction, µrad; both in the axes of what carries R",
        validity: "Constant over the run; small angles.",
        typical: "10 µm, 50 µrad",
        explanation: "The axis average line is not where, or not in the direction, that the control believes.",
        cause: "Assembly and alignment of the axes, or wrong pivot data in the control.",
        seen_by: "Any cycle that turns the axis; tilts need two heights.",
        needs: &[],
        helps: &[Need::Travel, Need::TwoHeights],
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "location-errors",
        shape: &[],
        values: &[("EX0C", 20.0), ("EA0C", 100.0)],
        view: View::Poses,
    },
    golden: Golden {
        source: "S4 §4.2 (C axis: r_x1 = +3.2 µm, r_x2 = −1.0 µm, dz = 100 mm)",
        derivation: "EB0C = −4.2 µm/100 mm = −42 µrad: 100 mm above the pivot the table axis is 4.2 µm towards −X, so the tool reads +4.2 µm.",
        id: "location-errors",
        shape: &[],
        values: &[("EB0C", -42.0)],
        balls_mm: &[[0.0, 0.0, 0.0], [0.0, 0.0, 100.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { setup: 1, read_um: Some([4.2, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.05,
    },
};

/// A millimetre: machines with linear axes are aligned to hundredths. A judgement, tuned on no data; the lines of a robot may be off by more.
const PLACE: Limit = Limit {
    largest: 1000.0,
    beyond: "no axis of a machine tool is placed so badly. A work offset, a tool length or a stylus radius may be in the positions or readings. \
             Or the ball is not where the setup has it, or the pivot in the machine file is that of another machine",
    resembles: false,
};

fn carriers(machine: &Machine) -> Vec<Joint> {
    machine.rotary().iter().map(|axis| axis.letter).collect()
}

/// (site, unit rotation, symbol) of the squareness errors of a machine without rotary axes.
fn squareness() -> [(Joint, Vector3<f64>, &'static str); 3] {
    [(Joint::Y, Vector3::z(), "EC0Y"), (Joint::Z, Vector3::y(), "EB0Z"), (Joint::Z, Vector3::x(), "EA0Z")]
}

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let carriers = carriers(&scene.machine);
    if carriers.is_empty() {
        return squareness().map(|(_, _, name)| Parameter::new(name, Unit::URAD)).into();
    }
    let is_machine_tool = !scene.machine.linear_joints().is_empty();
    let symbol = |direction: Joint, axis: Joint| {
        let name = format!("E{direction}0{axis}");
        match direction.is_rotary() {
            true => Parameter::new(name, Unit::URAD),
            false if is_machine_tool => Parameter::new(name, Unit::UM).at_most(PLACE),
            false => Parameter::new(name, Unit::UM),
        }
    };
    carriers.iter().flat_map(|&axis| Joint::ALL.map(|direction| symbol(direction, axis))).collect()
}

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let carriers = carriers(&scene.machine);
    if carriers.is_empty() {
        for (k, (letter, axis, _)) in squareness().into_iter().enumerate() {
            // The tool end of the later axis leans: the angle acts on the travel of that axis.
            let travel = scene.machine.axis(letter).map_or(0.0, |a| a.sense) * state.position[letter];
            let along = scene.machine.axis(letter).map_or(Vector3::zeros(), |a| a.direction.into_inner());
            emit(k, Site::Joint(letter), Twist::translation(axis.cross(&(along * travel))));
        }
        return;
    }
    for (i, &axis) in carriers.iter().enumerate() {
        for k in 0..3 {
            let unit = Vector3::ith(k, 1.0);
            emit(6 * i + k, Site::Joint(axis), Twist::translation(unit));
            emit(6 * i + 3 + k, Site::Joint(axis), Twist::rotation(unit));
        }
    }
}

/// Location errors that the minimum set (8 for two rotary axes, S2 tables 2–5) defines to be zero, weakest first: when
/// one of these cannot be distinguished from others, it is the one that gets no number.
pub fn conventional_zeros(machine: &Machine) -> Vec<String> {
    let mut names = Vec::new();
    // Along the axis itself nothing distinguishes the axis line; its zero position belongs to the axis scale.
    for axis in machine.rotary().into_iter().rev() {
        let k = axis.direction.iamax();
        names.push(format!("E{}0{}", Joint::LINEAR[k], axis.letter));
        names.push(format!("E{}0{}", Joint::ROTARY[k], axis.letter));
    }
    // Across the line of a spindle only its distance from the line of another rotary axis shows: it is the spindle's own where an axis of
    // the tool turns that distance, else it is booked on the table [S2 tables 2–3, with the zeros of X and Y as the control has them].
    if let Some(spindle) = machine.spindle.and_then(|spindle| machine.axis(spindle)) {
        let turned_about: Vec<usize> = machine
            .tool
            .iter()
            .filter(|axis| axis.is_rotary() && axis.letter != spindle.letter)
            .map(|axis| axis.direction.iamax())
            .collect();
        let along = spindle.direction.iamax();
        let fixed = (0..3).filter(|&k| k != along && turned_about.iter().all(|&about| about == k));
        names.extend(fixed.map(|k| format!("E{}0{}", Joint::LINEAR[k], spindle.letter)));
    }
    // Relative notation: an error of an outer axis that the inner one can also make is booked on the inner axis
    // for rotations, on the outer for translations (EX0C, EY0C relative to B).
    let rotary = machine.rotary();
    for pair in rotary.windows(2) {
        let (inner, outer) = (pair[0], pair[1]);
        let k = inner.direction.iamax();
        names.push(format!("E{}0{}", Joint::ROTARY[k], outer.letter));
    }
    // One axis turns the table and one the tool: across both axis lines only the distance between the lines shows. It is
    // booked on the axis of the table.
    let turns = |axis: &Axis| axis.is_rotary() && machine.spindle != Some(axis.letter);
    let rotary_of = |side| machine.from_bed(side).into_iter().filter(|axis| turns(axis)).collect::<Vec<_>>();
    if let ([table], [tool]) = (&rotary_of(Side::Table)[..], &rotary_of(Side::Tool)[..]) {
        let along = [table, tool].map(|axis| axis.direction.iamax());
        let across = (0..3).filter(|k| !along.contains(k));
        names.extend(across.map(|k| format!("E{}0{}", Joint::LINEAR[k], tool.letter)));
    }
    // A zero position of the inner axis is only defined against the outer one: keep it (EB0B), give up the outer's tilt.
    if rotary.len() > 1 {
        let inner = rotary[0];
        let keep = format!("E{}0{}", Joint::ROTARY[inner.direction.iamax()], inner.letter);
        names.retain(|name| *name != keep);
        names.push(keep);
    }
    names
}
