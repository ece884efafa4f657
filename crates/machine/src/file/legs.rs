//! The part of a machine file about legs in parallel: `[tripod]` and the axes of `kind = "leg"`.

use super::moves::{FARTHEST_MM, Moves, moves};
use crate::Axis;
use crate::tripod::{Leg, Tripod, base_pose};
use nalgebra::{Point3, Vector3};
use trunnion_core::Joint;
use trunnion_core::input::Table;

/// Longest leg of a machine file, mm.
const LONGEST_MM: f64 = 20_000.0;

/// The legs and their axes; `tool` is the chain of the tool, whose first three axes they are.
pub(super) fn legs(
    root: &Table<'_>,
    axes: &Table<'_>,
    tool: Option<&[Joint]>,
) -> Option<(Tripod, [Axis; 3])> {
    let table = root.table("tripod")?;
    let origin = table.vector3("base_in_machine_mm");
    let tilt = table.number("base_tilt_deg", -180.0..=180.0);
    table.no_other_keys();
    let letters: [Joint; 3] = tool?.get(..3).and_then(|first| first.try_into().ok()).or_else(|| {
        root.problem("tool", "begins with fewer than three axes", "the strokes of legs 1, 2 and 3 first", "");
        None
    })?;
    let read = letters.map(|letter| leg(axes, letter));
    let [Some(first), Some(second), Some(third)] = read else { return None };
    let travels = [&first, &second, &third].map(|(_, moves)| moves.travel);
    let moves = [first.1, second.1, third.1];
    let legs = [first.0, second.0, third.0];
    let tripod = match Tripod::new(base_pose(origin?, tilt?), legs, travels) {
        Ok(tripod) => tripod,
        Err(error) => {
            let advice = "Check joints, lengths and travels of the three legs.";
            root.problem(
                "tripod",
                format!("does not close: {error}"),
                "legs that meet all over their travels",
                advice,
            );
            return None;
        }
    };
    let mut moves = moves.into_iter();
    let axes = letters.map(|letter| {
        let Moves { sense, travel, facts } = moves.next().expect("three legs");
        let direction = tripod.direction_at_zero(letter).expect("a leg of the tripod");
        Axis { letter, direction, through_mm: Point3::origin(), sense, travel, facts }
    });
    Some((tripod, axes))
}

fn leg(axes: &Table<'_>, letter: Joint) -> Option<(Leg, Moves)> {
    let table = axes.table(letter.as_str())?;
    let kind = table.one_of("kind", &["leg"]);
    if letter.is_rotary() {
        table.problem("kind", "does not fit the letter", "legs are linear", "");
    }
    let base_joint_mm = joint(&table, "base_joint_mm");
    let platform_joint_mm = joint(&table, "platform_joint_mm");
    let length_at_zero_mm = table.number("length_at_zero_mm", 1.0..=LONGEST_MM);
    let moves = moves(&table, false);
    table.no_other_keys();
    kind?;
    let moves = moves?;
    let leg = Leg {
        letter,
        base_joint_mm: base_joint_mm?,
        platform_joint_mm: platform_joint_mm?,
        length_at_zero_mm: length_at_zero_mm?,
        sense: moves.sense,
    };
    (!letter.is_rotary()).then_some((leg, moves))
}

fn joint(table: &Table<'_>, key: &str) -> Option<Vector3<f64>> {
    let joint = table.vector3(key)?;
    if joint.amax() > FARTHEST_MM {
        table.problem(key, "is out of reach", format!("within ±{FARTHEST_MM} mm"), "");
        return None;
    }
    Some(joint)
}
