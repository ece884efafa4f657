//! Sag of the tilting frame or head under its own weight, and wind-up of its drive.
//!
//! u(B) = R K⁻¹ Rᵀ g − K⁻¹ g,  g = −z unit vector in the carrier of the tilting axis, R = rotation by B    [docs/design/physics.md §9.1; S1 §5.3; S4 table 2]
//! K⁻¹ = [[p, q], [q, −p]] across the axis line: an equal compliance in all directions gives a constant, which is a
//! location error, so only the anisotropy p and the skewness q survive (1 − cos 2B and sin 2B terms).
//! Wind-up of the drive: ω = (s·(sin B) + c·(cos B − 1)) along the axis, ∝ sin(B + φ) − sin φ of the centre of mass.
//! Limits: the load on the table does not change; a frame symmetric about the plane across its axis.

use crate::subjects::{across, axis_of, carrier_from_carried, gravity_in_carrier, tilts};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::{Matrix3, Vector3};
use trunnion_core::{State, Twist};
use trunnion_machine::{Machine, Side, Site};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "gravity-sag",
    role: Role::CAUSE,
    about: About {
        title: "Sag of the tilting frame or head under its own weight",
        source: "S1 §5.3; S4 table 2; docs/design/physics.md §9.1",
        equation: "u = R K⁻¹ Rᵀ g − K⁻¹ g (terms 1 − cos 2B and sin 2B across the axis); wind-up ω ∝ sin(B + φ) − sin φ about it",
        symbols: "u displacement of the frame or head, µm; K⁻¹ its compliance across the axis with anisotropy p and skewness q times the weight, µm; R turn by B; g unit vector of gravity; ω turn about the axis, µrad; φ place of the centre of mass",
        validity: "The load on the table, or the tool, stays the same; gravity along −Z; zero at the zero position.",
        typical: "5–10 µm",
        explanation: "The tilting frame or head and its drive give way under the weight, differently at every tilt.",
        cause: "Deformation of the rotating unit and angular error of its positioning under gravity: an uneven stiffness of frame and bearings, missing counterbalance.",
        seen_by: "Static poses over the whole tilt at two heights; another load on the table, or a heavier tool in the head, separates it from radial error motion and encoder error.",
        needs: &[Need::Travel],
        helps: &[Need::TwoHeights, Need::AnotherLoad],
    },
    subjects: |machine: &Machine| {
        machine
            .rotary()
            .into_iter()
            .filter(|axis| tilts(axis))
            .map(|axis| Subject::Axis(axis.letter))
            .collect()
    },
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "gravity-sag:B",
        shape: &[],
        values: &[("anisotropy", 4.0), ("windup.sin", 20.0)],
        view: View::Poses,
    },
    golden: Golden {
        source: "S1 §5.3 (δz of B: 13 µm at B = 0, 19 µm at B = −90°)",
        derivation: "Upright to lying changes the sag by 2p = 6 µm along machine Z, so p = 3 µm; at B = −90° the table's x is machine Z.",
        id: "gravity-sag:B",
        shape: &[],
        values: &[("anisotropy", 3.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("B", -90.0)], read_um: Some([-6.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.5,
    },
};

/// What gives way more upright, and more lying on its side.
const FRAME: [&str; 2] = [
    "the frame gives way more upright than lying on its side",
    "the frame gives way more lying on its side than upright",
];
const HEAD: [&str; 2] = [
    "the head or arm gives way more upright than lying on its side",
    "the head or arm gives way more lying on its side than upright",
];

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match axis_of(&scene.machine, subject) {
        Some(axis) if scene.moves(axis.letter) => {
            // p is the compliance along e₁, which is vertical at the zero position of what tilts about Y and horizontal about X.
            let across = across(&axis.direction);
            let mut of_signs = match scene.machine.side(axis.letter) {
                Some(Side::Tool) => HEAD,
                _ => FRAME,
            };
            if across.first.z.abs() <= across.second.z.abs() {
                of_signs.reverse();
            }
            vec![
                Parameter::new("anisotropy", Unit::UM).meaning(of_signs),
                Parameter::new("skewness", Unit::UM),
                Parameter::new("windup.sin", Unit::URAD),
                Parameter::new("windup.cos", Unit::URAD),
            ]
        }
        _ => Vec::new(),
    }
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let site = Site::Joint(axis.letter);
    let across = across(&axis.direction);
    let (e1, e2): (Vector3<f64>, Vector3<f64>) = (across.first, across.second);
    let g = gravity_in_carrier(&scene.machine, axis, state);
    let r = *carrier_from_carried(axis, state).to_rotation_matrix().matrix();
    let anisotropy = e1 * e1.transpose() - e2 * e2.transpose();
    let skewness = e1 * e2.transpose() + e2 * e1.transpose();
    let sag = |compliance: Matrix3<f64>| r * compliance * r.transpose() * g - compliance * g;
    let angle = axis.sense * state.position[axis.letter];
    emit(0, site, Twist::translation(sag(anisotropy)));
    emit(1, site, Twist::translation(sag(skewness)));
    emit(2, site, Twist::rotation(axis.direction.into_inner()) * angle.sin());
    emit(3, site, Twist::rotation(axis.direction.into_inner()) * (angle.cos() - 1.0));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instance;
    use trunnion_core::Joint;
    use trunnion_machine::shipped;

    /// Along machine Z the frame, or the head, is lower lying than upright where it gives way more lying.
    #[test]
    fn the_sign_says_in_which_position_the_frame_gives_way_more() {
        for (machine, id, axis, which) in [
            ("table-bc", "gravity-sag:B", Joint::B, FRAME),
            ("table-ac", "gravity-sag:A", Joint::A, FRAME),
            ("head-bc", "gravity-sag:B", Joint::B, HEAD),
            ("head-a-table-c", "gravity-sag:A", Joint::A, HEAD),
        ] {
            let machine = shipped::machine(machine).unwrap();
            let mut state = State::default();
            state.position[axis] = std::f64::consts::FRAC_PI_2;
            let scene =
                Scene::new(machine.clone(), Vec::new(), Vec::new(), [State::default(), state.clone()].iter());
            let instance = Instance::find(id, &machine).unwrap();
            let anisotropy = instance.parameters(&scene).remove(0);
            let mut lower = 0.0;
            instance.motions(&scene, &[], &state, &mut |i, _, twist| {
                lower -= if i == 0 { twist.translation_mm.z } else { 0.0 };
            });
            assert_eq!(anisotropy.meaning.unwrap()[0], which[usize::from(lower > 0.0)], "{id}: {lower}");
        }
    }

    #[test]
    fn sag_is_zero_upright_and_grows_as_one_minus_cos_2b() {
        let machine = shipped::machine("table-bc").unwrap();
        let state = |b: f64| {
            let mut state = State::default();
            state.position[Joint::B] = b;
            state
        };
        let states = [state(0.0), state(1.0)];
        let scene = Scene::new(machine.clone(), Vec::new(), Vec::new(), states.iter());
        let instance = Instance::find("gravity-sag:B", &machine).unwrap();
        let seen = |b: f64| {
            let mut seen = [Twist::default(); 4];
            instance.motions(&scene, &[], &state(b), &mut |i, _, twist| seen[i] += twist);
            seen
        };
        assert!(seen(0.0).iter().all(|t| t.translation_mm.norm() + t.rotation_rad.norm() < 1e-15));
        for b in [0.3f64, 0.9, -1.4] {
            // R(b) diag(1,−1) R(b)ᵀ(0,−1) worked by hand in the plane (z, x): −z → (−cos 2b, −sin 2b).
            let [anisotropy, ..] = seen(b);
            let expected = Vector3::new(-(2.0 * b).sin(), 0.0, 1.0 - (2.0 * b).cos());
            assert!((anisotropy.translation_mm - expected).norm() < 1e-12, "{b} {anisotropy:?}");
        }
    }
}
