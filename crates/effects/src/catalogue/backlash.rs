//! Backlash: lost motion of the drive when the direction turns.
//!
//! e = ½ h · direction on the positioning error of the axis, direction −1, 0, +1       [docs/design/physics.md §5, §9.6; ISO 230-2 reversal value, ISO 230-4]
//! h = mean deviation coming up minus coming down: negative for lost motion (the axis stops short), positive for an
//! over-compensated control. Limits: direction known; both directions measured; no dependence on load.

use crate::subjects::{axis_of, every_axis};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::State;
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "backlash",
    role: Role::CAUSE,
    about: About {
        title: "Backlash of the drive",
        source: "docs/design/physics.md §5, §9.6; ISO 230-2; S4 table 2 (positioning mechanism)",
        equation: "e = ½ h · direction on the positioning error",
        symbols: "e positioning error, µm or µrad; h reversal value, µm or µrad: negative when the axis stops short, positive when the control over-compensates; direction −1, 0, +1",
        validity: "The direction of approach is known and both occur; the same at every place.",
        typical: "2 µm; 0.002–0.006°",
        explanation: "The axis stops short of its target by the same amount from either side.",
        cause: "Errors in the positioning mechanism: play in worm, gear, screw nut or coupling; wrong backlash compensation.",
        seen_by: "Approaching every pose from both directions of this axis.",
        needs: &[Need::Travel, Need::BothDirections],
        helps: &[Need::TwoFeeds],
    },
    subjects: every_axis,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example { id: "backlash:X", shape: &[], values: &[("h", -3.0)], view: View::Circle(&[3000.0]) },
    golden: Golden {
        source: "ISO 230-2 (reversal value: mean coming up minus mean coming down)",
        derivation: "A reversal value of −3 µm leaves X 1.5 µm short of its target from either side.",
        id: "backlash:X",
        shape: &[],
        values: &[("h", -3.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment {
                position: &[("X", 100.0)],
                direction: &[("X", 1.0)],
                read_um: Some([-1.5, 0.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment {
                position: &[("X", -100.0)],
                direction: &[("X", -1.0)],
                read_um: Some([1.5, 0.0, 0.0]),
                ..Moment::AT_REST
            },
        ],
        within_um: 0.05,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match axis_of(&scene.machine, subject) {
        Some(axis) if scene.moves(axis.letter) && scene.both_directions(axis.letter) => {
            vec![Parameter::new("h", if axis.is_rotary() { Unit::URAD } else { Unit::UM })]
        }
        _ => Vec::new(),
    }
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    emit(0, Site::Joint(axis.letter), axis.positioning_twist() * (0.5 * state.direction[axis.letter]));
}
