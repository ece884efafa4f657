//! Where axes on the fly turn round, from row to row.
//!
//! An axis goes where its speed at the row points: it may have turned since the row before, although it has gone farther than there. It turned
//! where the parabola through the rows has its crest, q − v²/2a, if that lies between the two; else at the farther one of them.

use super::moving::Moving;
use trunnion_core::direction::STANDSTILL;
use trunnion_core::{AxisValues, Slot};

/// Directions and turning points so far.
#[derive(Default)]
pub(super) struct Turning {
    last: Option<AxisValues<f64>>,
    /// 0 before the first motion.
    heading: AxisValues<f64>,
    /// Where each axis last turned, or began.
    turned_at: AxisValues<f64>,
}

impl Turning {
    /// Direction of every axis at the next row, and its travel since it turned.
    pub fn follow(
        &mut self,
        position: &AxisValues<f64>,
        moving: &AxisValues<Moving>,
    ) -> (AxisValues<f64>, AxisValues<f64>) {
        let last = self.last.replace(*position).unwrap_or_else(|| {
            self.turned_at = *position;
            *position
        });
        for slot in Slot::ALL {
            let (q, Moving { back, ahead, speed, acceleration }) = (position[slot], moving[slot]);
            let moves = |way: f64| way.abs() > STANDSTILL;
            let on_path = back.is_some() || ahead.is_some();
            let is_moving = back.is_some_and(|(_, way)| moves(way)) || ahead.is_some_and(moves);
            let heading = match on_path {
                true if is_moving && speed != 0.0 => speed.signum(),
                false if moves(q - last[slot]) => (q - last[slot]).signum(),
                _ => continue,
            };
            let before = std::mem::replace(&mut self.heading[slot], heading);
            if before == heading || before == 0.0 {
                continue;
            }
            let crest_s = -speed / acceleration;
            let crest = back.filter(|(back_s, _)| *back_s <= crest_s && crest_s <= 0.0);
            let farther = if before > 0.0 { q.max(last[slot]) } else { q.min(last[slot]) };
            self.turned_at[slot] = crest.map_or(farther, |_| q + 0.5 * speed * crest_s);
        }
        let since_reversal = AxisValues::from_fn(|slot| (position[slot] - self.turned_at[slot]).abs());
        (self.heading, since_reversal)
    }
}
