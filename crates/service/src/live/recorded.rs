//! What is missing from a recording, as it would have been said live.

use super::remounts::{FIRST_MOTION_S, Remounts};
use std::path::Path;
use trunnion::cycles::Cycle;
use trunnion_core::Gap;
use trunnion_record::Item;

/// Name of the cycle of a recording, and the holes in what was asked; `None` when it cannot be read.
pub fn gaps_of(recording: &Path) -> Option<(String, Vec<Gap>)> {
    let (mut gaps, mut remounts) = (Vec::new(), Remounts::default());
    let mut take = |item: Item| {
        match item {
            Item::Gap(gap) if gap.to_s > FIRST_MOTION_S => gaps.push(gap),
            Item::Point(point) => remounts.take(&point, point.state.time_s.unwrap_or(0.0)),
            _ => {}
        }
        true
    };
    let (header, _) = trunnion_record::visit(recording, &mut take).ok()?;
    gaps.retain(|gap| !remounts.hold(gap));
    // A recording without a cycle is judged by the model of any.
    let cycle = Cycle::parse("recorded cycle", &header.cycle_text).map_or_else(|_| String::new(), |c| c.name);
    Some((cycle, gaps))
}
