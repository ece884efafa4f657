//! Where the lines of the rotary axes really are, all axes at zero.
//!
//! p' = p + Σ_j δ_j + ω_j × (p − o_j)    d' = d + Σ_j ω_j × d    [docs/design/physics.md §2.1, all frames parallel at zero]
//! p, d point and direction of the line of an axis; δ_j, ω_j location errors of this axis and of those that carry it; o_j where they
//! act. A control that turns about these lines differs from the machine by a constant displacement of the workpiece or the tool,
//! which its datum takes up. To first order: what is left out is a µrad of a µm.

use super::format::number;
use nalgebra::Vector3;
use trunnion_results::{AxisErrors, Chain, ChainJoint};

/// How far the line of a rotary axis is from the nominal one.
pub(super) struct Line<'a> {
    pub joint: &'a ChainJoint,
    /// Of its point, machine axes, mm.
    pub moved_mm: Vector3<f64>,
    /// Of its direction, machine axes.
    pub turned: Vector3<f64>,
}

/// A kind of five-axis machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Both rotary axes carry the workpiece.
    TwoTable,
    /// Both carry the tool.
    TwoTool,
    /// One of each.
    Mixed,
}

/// The kind of machine; `None` where it has not two rotary axes.
pub(super) fn kind(chain: &Chain) -> Option<Kind> {
    match chain.rotary().map(|side| side.len()) {
        [2, 0] => Some(Kind::TwoTable),
        [0, 2] => Some(Kind::TwoTool),
        [1, 1] => Some(Kind::Mixed),
        _ => None,
    }
}

/// The lines of the rotary axes of both sides, each from the bed outward.
pub(super) fn lines<'a>(chain: &'a Chain, errors: &AxisErrors) -> [Vec<Line<'a>>; 2] {
    [&chain.table, &chain.tool].map(|side| {
        let carried = |k: usize| {
            let joint: &ChainJoint = &side[k];
            let (point, direction) = (Vector3::from(joint.through_mm), Vector3::from(joint.direction));
            let (mut moved_mm, mut turned) = (Vector3::zeros(), Vector3::zeros());
            for carrier in &side[..=k] {
                let Some(table) = errors.axes.iter().find(|table| table.axis == carrier.axis) else {
                    continue;
                };
                let [x, y, z, a, b, c] = table.location;
                let rotation = Vector3::new(a, b, c);
                moved_mm +=
                    Vector3::new(x, y, z) + rotation.cross(&(point - Vector3::from(carrier.through_mm)));
                turned += rotation.cross(&direction);
            }
            Line { joint, moved_mm, turned }
        };
        (0..side.len()).filter(|&k| side[k].is_rotary_axis()).map(carried).collect()
    })
}

/// `+0.012` or `-0.012`: what is added to a value that stands in the control; `None` for nothing.
pub(super) fn added(value: f64) -> Option<String> {
    let text = number(value);
    let nothing = text.chars().all(|c| matches!(c, '0' | '.' | '-'));
    (!nothing).then(|| if value < 0.0 { text } else { format!("+{text}") })
}
