//! Off-centre mass on a turning table that tilts: its weight turns and tilts the table.
//!
//! M(C) = e(C) × g,  e(C) = R(C) e_i the place of the mass, g the unit vector of gravity in the carrier of C   [docs/design/physics.md §9.2]
//! ω = twist · (M·d) d + tilt · (M − (M·d) d): about the axis d ∝ sin B·sin(C + φ), across it ∝ cos B.
//! Limits: one load for the whole experiment; position held by a drive of constant stiffness.

use crate::subjects::{across, axis_of, carrier_from_carried, gravity_in_carrier, rotary_below};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::{State, Twist};
use trunnion_machine::{Machine, Side, Site};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "unbalance",
    role: Role::CAUSE,
    about: About {
        title: "Off-centre mass on the turning table",
        source: "docs/design/physics.md §9.2; S4 table 2 (gravity influence)",
        equation: "ω = twist·(M·d) d + tilt·(M − (M·d) d), M = R(C) e_i × g",
        symbols: "ω turn of the table, µrad; d its axis; e_i place of the mass, unit vector; g unit vector of gravity in the carrier of the axis; twist, tilt compliance × weight × distance, µrad",
        validity: "Same load during the whole experiment; needs a tilted table to turn it.",
        typical: "1–5 µm at the ball",
        explanation: "A weight off the axis of the tilted table pulls it round, and over.",
        cause: "Workpiece or fixture off the centre; weak position loop or bearing of the table.",
        seen_by: "Turning C at several tilts B; with the load moved by 180° the sign flips.",
        needs: &[Need::Travel, Need::SeveralTilts],
        helps: &[Need::AnotherLoad, Need::TwoHeights],
    },
    subjects: |machine: &Machine| {
        machine
            .rotary()
            .into_iter()
            .filter(|axis| machine.side(axis.letter) == Some(Side::Table))
            .filter(|axis| rotary_below(machine, axis.letter).is_some())
            .map(|axis| Subject::Axis(axis.letter))
            .collect()
    },
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "unbalance:C",
        shape: &[],
        values: &[("twist.1", 20.0), ("tilt.2", 10.0)],
        view: View::Poses,
    },
    golden: Golden {
        source: "Meriam & Kraige, Statics, ch. 2 (moment of a force, M = r × F)",
        derivation: "On a vertical table a weight off the axis at half height pulls with its full moment: 20 µrad at 150 mm are 3 µm; above the axis with none.",
        id: "unbalance:C",
        shape: &[],
        values: &[("twist.1", 20.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("B", 90.0)], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment {
                position: &[("B", 90.0), ("C", 90.0)],
                read_um: Some([0.0, 3.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment {
                position: &[("B", 90.0), ("C", -90.0)],
                read_um: Some([0.0, -3.0, 0.0]),
                ..Moment::AT_REST
            },
        ],
        within_um: 0.005,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject) else { return Vec::new() };
    let tilts = rotary_below(&scene.machine, axis.letter).is_some_and(|below| scene.moves(below.letter));
    if !tilts || !scene.moves(axis.letter) {
        return Vec::new();
    }
    ["twist.1", "twist.2", "tilt.1", "tilt.2"].map(|name| Parameter::new(name, Unit::URAD)).into()
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let site = Site::Joint(axis.letter);
    let d = axis.direction.into_inner();
    let g = gravity_in_carrier(&scene.machine, axis, state);
    let across = across(&axis.direction);
    for (i, e) in [across.first, across.second].into_iter().enumerate() {
        let moment = (carrier_from_carried(axis, state) * e).cross(&g);
        let about_axis = d * moment.dot(&d);
        emit(i, site, Twist::rotation(about_axis));
        emit(2 + i, site, Twist::rotation(moment - about_axis));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instance;
    use trunnion_core::Joint;
    use trunnion_machine::shipped;

    #[test]
    fn an_off_centre_mass_turns_the_table_as_sin_b_sin_c() {
        let machine = shipped::machine("table-bc").unwrap();
        let mut state = State::default();
        let scene = Scene::new(machine.clone(), Vec::new(), Vec::new(), [State::default()].iter());
        let instance = Instance::find("unbalance:C", &machine).unwrap();
        for (b, c) in [(0.0f64, 0.7f64), (0.4, 1.1), (-1.2, 2.5)] {
            state.position[Joint::B] = b;
            state.position[Joint::C] = c;
            let mut turned = 0.0;
            instance.motions(&scene, &[], &state, &mut |i, _, twist| {
                turned += if i == 0 { twist.rotation_rad.z } else { 0.0 };
            });
            // Weight at (cos C, sin C) on a slope falling along g_x = sin B: torque −sin C · sin B about C.
            assert!((turned - -b.sin() * c.sin()).abs() < 1e-12, "{b} {c} {turned}");
        }
    }
}
