//! Servo lag of one axis against the others.
//!
//! e = −T v on the positioning error, v velocity, T = 1/Kv beyond the others' lag        [docs/design/physics.md §5 (45° oval that flips with direction), docs/design/physics.md §9.8]
//! Limits: on the fly; velocity changes slowly against T. A lag common to all axes keeps the path; one of all rotary axes is `sync-delay`.

use crate::subjects::{axis_of, every_axis};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::State;
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "servo-lag",
    role: Role::CAUSE,
    about: About {
        title: "Lag of one axis behind the others",
        source: "docs/design/physics.md §5, §9.8; ISO 230-4; S4 §2 (synchronisation of linear and rotary axes)",
        equation: "e = −T v on the positioning error",
        symbols: "e positioning error; T lag beyond that of the other axes, ms; v velocity",
        validity: "Read on the fly; smooth motion.",
        typical: "0.1–1 ms: 21 µm per ms at 360°/min on R 200 mm",
        explanation: "One axis follows its command a little later than the others.",
        cause: "Servo gain (Kv) or feed-forward not matched to the other axes.",
        seen_by: "Both directions and two feeds: the error flips with direction and doubles with the feed.",
        needs: &[Need::OnTheFly],
        helps: &[Need::BothDirections, Need::TwoFeeds],
    },
    subjects: every_axis,
    parameters: |scene, subject| match axis_of(&scene.machine, subject) {
        Some(axis) if scene.read_in_motion(axis.letter) => vec![Parameter::new("lag", Unit::MS)],
        _ => Vec::new(),
    },
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "servo-lag:X",
        shape: &[],
        values: &[("lag", 0.2)],
        view: View::Circle(&[3000.0]),
    },
    golden: Golden {
        source: "Siemens SINUMERIK 840Di sl Manual 01/2007, 11.5 (Kv factor 1: following error 1 mm at 1 m/min)",
        derivation: "Kv = 1 (m/min)/mm is a lag of 60 ms: 1000 µm behind at 16.667 mm/s, and the other way coming back.",
        id: "servo-lag:X",
        shape: &[],
        values: &[("lag", 60.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { velocity: &[("X", 16.6667)], read_um: Some([-1000.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { velocity: &[("X", -16.6667)], read_um: Some([1000.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.5,
    },
};

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    emit(0, Site::Joint(axis.letter), axis.positioning_twist() * -state.velocity[axis.letter]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instance;
    use nalgebra::Point3;
    use trunnion_core::Joint;
    use trunnion_machine::shipped;

    #[test]
    fn one_millisecond_of_c_at_360_degrees_a_minute_is_21_um_on_a_200_mm_radius() {
        let machine = shipped::machine("table-bc").unwrap();
        let mut state = State::default();
        state.velocity[Joint::C] = 360f64.to_radians() / 60.0;
        let scene = Scene::new(machine.clone(), Vec::new(), Vec::new(), [state.clone()].iter());
        for id in ["servo-lag:C", "sync-delay"] {
            let mut moved_um = 0.0;
            Instance::find(id, &machine).unwrap().motions(&scene, &[], &state, &mut |_, site, twist| {
                if site == Site::Joint(Joint::C) {
                    let frame = machine.joint_frame(Joint::C, &state.position).unwrap();
                    moved_um += frame.displacement_mm(&Point3::new(200.0, 0.0, 0.0), &(twist * 1e-3)).y * 1e3;
                }
            });
            // 2π·200 mm / 60 s · 1 ms (docs/design/physics.md §9.8 says 21 µm).
            assert!((moved_um + 20.94).abs() < 0.01, "{id} {moved_um}");
        }
    }
}
