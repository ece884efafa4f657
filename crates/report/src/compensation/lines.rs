//! Where the lines of the rotary axes really are against the tool, all axes at zero, and what of it a control can hold.
//!
//! p' = p + Σ_j δ_j + ω_j × (p − o_j)    d' = d + Σ_j ω_j × d    [docs/design/physics.md §2.1, all frames parallel at zero]
//! p, d point and direction of the line of an axis; δ_j, ω_j location errors of this axis and of those that carry it; o_j where they
//! act. The joints of the tool move the tool as well, by s + Ω × (t − t₀), Ω = Σ ω_j, s their sum at the measured point t₀ of the tool. A control
//! that turns about lines moved by p' − p − s differs from the machine by the constant displacement s, which its datum takes up, and by the lean
//! Ω of the tool. Along the tool it does nothing, and about the last axis before the tool it is a shift of the zero of that axis. The rest
//! leaves Ω × (t − t₀): nothing for a tool of the measured length. To first order: what is left out is a µrad of a µm.

use super::format::number;
use nalgebra::Vector3;
use trunnion_core::convert::urad_from_rad;
use trunnion_results::{AxisErrors, AxisTable, Chain, ChainJoint, LeftOutEffect};

/// A lean of less is none, rad.
const NOTHING_RAD: f64 = 1e-12;

/// How far the line of a rotary axis is from the nominal one, seen from the tool.
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

/// Whether a control can shift the zero of a rotary axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Zeros {
    /// It can.
    Shifted,
    /// No public document says how.
    Fixed,
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
pub(super) fn lines<'a>(chain: &'a Chain, errors: &AxisErrors, zeros: Zeros) -> [Vec<Line<'a>>; 2] {
    let tool = Tool::of(chain, errors);
    let shifted_mm = tool.moved_mm - tool.zero(chain, zeros).map_or(Vector3::zeros(), |zero| zero.moves_mm);
    [&chain.table, &chain.tool].map(|side| {
        let carried = |k: usize| {
            let joint = &side[k];
            let carriers = &side[..=k];
            let moved_mm = moved_mm(carriers, errors, Vector3::from(joint.through_mm)) - shifted_mm;
            Line { joint, moved_mm, turned: turned(carriers, errors).cross(&Vector3::from(joint.direction)) }
        };
        (0..side.len()).filter(|&k| side[k].is_rotary_axis()).map(carried).collect()
    })
}

/// By how much the zero of the last rotary axis before the tool is shifted, rad about its direction; `None` where there is none.
pub(super) fn zero_of_last<'a>(chain: &'a Chain, errors: &AxisErrors) -> Option<(&'a ChainJoint, f64)> {
    let zero = Tool::of(chain, errors).zero(chain, Zeros::Shifted)?;
    Some((zero.joint, zero.angle_rad))
}

/// The errors without the lean of the tool for which the control has no place, which is named.
pub(super) fn without_lean(chain: &Chain, mut errors: AxisErrors, zeros: Zeros) -> AxisErrors {
    let tool = Tool::of(chain, &errors);
    let lean = tool.lean(chain, zeros);
    if lean.amax() <= NOTHING_RAD {
        return errors;
    }
    let spindle = chain.tool.iter().find(|joint| joint.spindle);
    let acts_at = spindle.map_or(Vector3::zeros(), |joint| Vector3::from(joint.through_mm));
    // Nothing at the measured point.
    let moved_mm = lean.cross(&(tool.point_mm - acts_at));
    let taken_off = [moved_mm.x, moved_mm.y, moved_mm.z, -lean.x, -lean.y, -lean.z];
    let target = match spindle {
        None => &mut errors.tool,
        Some(spindle) => {
            let at = errors.axes.iter().position(|table| table.axis == spindle.axis).unwrap_or_else(|| {
                let table = AxisTable { axis: spindle.axis.clone(), rotary: true, ..AxisTable::default() };
                errors.axes.push(table);
                errors.axes.len() - 1
            });
            &mut errors.axes[at].location
        }
    };
    target.iter_mut().zip(taken_off).for_each(|(value, taken_off)| *value += taken_off);
    let length_mm = tool.point_mm.norm();
    errors.left_out.push(LeftOutEffect {
        effect: format!("lean of the tool, {:.0} µrad", urad_from_rad(lean.norm())),
        why: format!("the control has no place for it; the vectors are right for a tool of {length_mm:.0} mm, the mean of those measured"),
    });
    errors
}

/// What the joints of the tool do to it.
struct Tool {
    /// t₀, machine axes, mm.
    point_mm: Vector3<f64>,
    /// s, mm.
    moved_mm: Vector3<f64>,
    /// Ω, rad.
    turned: Vector3<f64>,
}

/// A shift of the zero of an axis.
struct Zero<'a> {
    joint: &'a ChainJoint,
    angle_rad: f64,
    /// What it does to the tool at t₀, mm.
    moves_mm: Vector3<f64>,
}

impl Tool {
    fn of(chain: &Chain, errors: &AxisErrors) -> Self {
        let point_mm = Vector3::from(chain.measured_in_tool_mm);
        let [x, y, z, a, b, c] = errors.tool;
        let own_rad = Vector3::new(a, b, c);
        let own_mm = Vector3::new(x, y, z) + own_rad.cross(&point_mm);
        Self {
            point_mm,
            moved_mm: moved_mm(&chain.tool, errors, point_mm) + own_mm,
            turned: turned(&chain.tool, errors) + own_rad,
        }
    }

    /// What of the lean is about the last rotary axis before the tool.
    fn zero<'a>(&self, chain: &'a Chain, zeros: Zeros) -> Option<Zero<'a>> {
        let joint = chain.tool.iter().rev().find(|joint| joint.is_rotary_axis())?;
        let direction = Vector3::from(joint.direction);
        let angle_rad = self.turned.dot(&direction);
        let arm_mm = self.point_mm - Vector3::from(joint.through_mm);
        let moves_mm = direction.cross(&arm_mm) * angle_rad;
        (zeros == Zeros::Shifted).then_some(Zero { joint, angle_rad, moves_mm })
    }

    /// What of Ω leans the tool and is no shift of a zero, rad.
    fn lean(&self, chain: &Chain, zeros: Zeros) -> Vector3<f64> {
        let of_zero = self.zero(chain, zeros);
        let rest = self.turned
            - of_zero.map_or(Vector3::zeros(), |zero| Vector3::from(zero.joint.direction) * zero.angle_rad);
        let along = self.point_mm.try_normalize(f64::EPSILON).unwrap_or_else(Vector3::zeros);
        rest - along * rest.dot(&along)
    }
}

/// Σ δ + ω × (p − o) over the joints that carry the point p.
fn moved_mm(carriers: &[ChainJoint], errors: &AxisErrors, point_mm: Vector3<f64>) -> Vector3<f64> {
    let by = |carrier: &ChainJoint| {
        let (place_mm, rotation) = location(carrier, errors);
        place_mm + rotation.cross(&(point_mm - Vector3::from(carrier.through_mm)))
    };
    carriers.iter().map(by).sum()
}

/// Σ ω over the joints.
fn turned(carriers: &[ChainJoint], errors: &AxisErrors) -> Vector3<f64> {
    carriers.iter().map(|carrier| location(carrier, errors).1).sum()
}

/// δ and ω of a joint; zero of a linear one, of which a control of lines holds nothing.
fn location(joint: &ChainJoint, errors: &AxisErrors) -> (Vector3<f64>, Vector3<f64>) {
    let table = errors.axes.iter().find(|table| table.axis == joint.axis);
    let [x, y, z, a, b, c] = table.map_or([0.0; 6], |table| table.location);
    (Vector3::new(x, y, z), Vector3::new(a, b, c))
}

/// `+0.012` or `-0.012`: what is added to a value that stands in the control; `None` for nothing.
pub(super) fn added(value: f64) -> Option<String> {
    let text = number(value);
    let nothing = text.chars().all(|c| matches!(c, '0' | '.' | '-'));
    (!nothing).then(|| if value < 0.0 { text } else { format!("+{text}") })
}
