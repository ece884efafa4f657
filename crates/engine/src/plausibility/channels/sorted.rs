//! Readings that rise, or fall, from row to row while an axis goes there and back.
//!
//! What depends on the pose comes back with it. A drift alone rises so only where it is larger, from one row to the next, than all that the pose does.

use super::Channels;
use crate::plausibility::exchanged::GROSS_UM;
use crate::plausibility::found::{Implausible, plain};
use crate::plausibility::shown::SAME_MM;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::fixed;

/// Fewer rows may rise by chance, or along with an axis.
const FEWEST: usize = 24;
/// An axis turns so often at least: three passes, or rows of a grid.
const FEWEST_TURNS: usize = 6;
impl Channels<'_> {
    pub(super) fn sorted(&self) -> Option<Implausible> {
        let count = self.points.len();
        let joints = self.run.machine.joints();
        let turns = joints.into_iter().map(|joint| (joint, self.turns(joint)));
        let enough = turns.filter(|(_, turns)| count >= FEWEST && *turns >= FEWEST_TURNS);
        // Linear axes may only follow the ball.
        let (joint, turns) = enough.max_by_key(|(joint, turns)| (joint.is_rotary(), *turns))?;
        self.names().iter().enumerate().find_map(|(channel, name)| {
            let steps: Vec<f64> =
                (1..count).map(|at| self.value_mm(channel, at) - self.value_mm(channel, at - 1)).collect();
            let rising = steps.iter().filter(|step| **step > SAME_MM).count();
            let falling = steps.iter().filter(|step| **step < -SAME_MM).count();
            let way = match (rising, falling) {
                (_, 0) => "rises",
                (0, _) => "falls",
                _ => return None,
            };
            let span_um = um_from_mm(steps.iter().sum::<f64>().abs());
            // A display shows what rises slowly as a few steps, and a rise that is not gross may be nothing but a display.
            (2 * (rising + falling) > count && span_um > GROSS_UM).then(|| {
                plain(
                    format!(
                        "{}: {name} {way} from row to row through all {count} points of setup {}, by {} µm, while {joint} turns back {turns} times.",
                        self.run.name,
                        self.run.setups[self.setup].name,
                        fixed(span_um, 1)
                    ),
                    "The readings were sorted without their positions, and which belongs to which pose is lost. Import the table as it was measured.",
                )
            })
        })
    }

    /// How often an axis turns back.
    fn turns(&self, joint: trunnion_core::Joint) -> usize {
        let moved =
            self.points.windows(2).map(|pair| pair[1].state.position[joint] - pair[0].state.position[joint]);
        let ways: Vec<bool> = moved.filter(|moved| moved.abs() > SAME_MM).map(|moved| moved > 0.0).collect();
        ways.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }
}
