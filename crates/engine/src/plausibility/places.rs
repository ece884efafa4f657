//! Mistakes with a number in them, which is fitted: a constant offset of an axis, the length of a bar, the place of a ball.

use super::claim::{Claim, TOGETHER_MM};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use std::f64::consts::{PI, TAU};
use trunnion_core::convert::deg_from_rad;
use trunnion_core::number::signed;
use trunnion_core::statistics::mean;
use trunnion_core::{AxisValues, Joint, Setup};
use trunnion_machine::JointErrors;

/// Gauss–Newton steps; the last change nothing that is shown.
const MOST_STEPS: usize = 20;
/// Beginnings of the search over a turn.
const STARTS: usize = 8;
/// Change of a position for a difference, mm or rad.
const NEAR: f64 = 1e-4;
/// Relative singular value of a direction in which a place is not seen: a bar about a line says nothing along it.
const UNSEEN: f64 = 1e-3;

/// Every axis with the one offset, the same at every point, that explains most.
pub(super) fn offsets(claim: &Claim<'_>) -> Vec<(String, f64)> {
    let of_joint = |joint: Joint| {
        let starts: Vec<f64> = match joint.is_rotary() {
            true => (0..STARTS).map(|k| k as f64 * TAU / STARTS as f64).collect(),
            false => vec![0.0],
        };
        let (offset, rms_mm) = starts
            .iter()
            .map(|start| offset_from(claim, joint, *start))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        let change = match joint.is_rotary() {
            true => format!("{}°", signed(deg_from_rad(offset - (offset / TAU).round() * TAU), 1)),
            false => format!("{} mm", signed(offset, 1)),
        };
        Some((
            format!("every position of {joint} changed by {change} (a constant offset, as of a wrong zero)"),
            rms_mm,
        ))
    };
    claim.machine.joints().into_iter().filter_map(of_joint).collect()
}

/// The offset near a start, mm or rad, and what the balls are off with it.
fn offset_from(claim: &Claim<'_>, joint: Joint, start: f64) -> (f64, f64) {
    let shifted = |offset: f64| {
        claim.turned(|position| {
            let mut changed = *position;
            changed[joint] += offset;
            changed
        })
    };
    let mut offset = start;
    for _ in 0..MOST_STEPS {
        let off = [offset, offset + NEAR, offset - NEAR].map(|offset| shifted(offset).off_mm());
        let (mut slope, mut square) = (0.0, 0.0);
        for (k, at) in off[0].iter().enumerate() {
            let derivative = (off[1][k] - off[2][k]) / (2.0 * NEAR);
            slope += derivative.dot(at);
            square += derivative.norm_squared();
        }
        if square <= 0.0 {
            break;
        }
        let step = slope / square;
        offset -= if joint.is_rotary() { step.clamp(-PI / 4.0, PI / 4.0) } else { step };
    }
    (offset, shifted(offset).rms_mm())
}

/// The balls where the axes say they are, on the table or in the tool; bars as long as the axes say.
pub(super) fn other_places(claim: &Claim<'_>) -> Vec<(String, f64)> {
    let none = JointErrors::default();
    let machine = claim.machine;
    let in_table = |position: &AxisValues<f64>, setup: &Setup| {
        machine.machine_from_table(position, &none).inverse()
            * (machine.machine_from_tool(position, &none) * setup.ball_in_tool_mm)
    };
    let in_tool = |position: &AxisValues<f64>, setup: &Setup| {
        machine.machine_from_tool(position, &none).inverse()
            * (machine.machine_from_table(position, &none) * setup.ball_in_table_mm)
    };
    let (mut on_table, mut on_tool, mut as_long) =
        (claim.setups.clone(), claim.setups.clone(), claim.setups.clone());
    let (mut moved_on_table, mut moved_on_tool, mut lengthened) = (Vec::new(), Vec::new(), Vec::new());
    let words = |setup: &Setup, key: &str, from: &Point3<f64>, to: &Point3<f64>| {
        format!(
            "the position of the ball of setup {}, {key}, at [{:.1}, {:.1}, {:.1}], not [{:.1}, {:.1}, {:.1}] mm",
            setup.name, to.x, to.y, to.z, from.x, from.y, from.z
        )
    };
    for (k, setup) in claim.setups.iter().enumerate() {
        let own: Vec<&AxisValues<f64>> =
            claim.positions.iter().filter(|(setup, _)| *setup == k).map(|(_, position)| position).collect();
        if own.is_empty() {
            continue;
        }
        let seen_in_table: Vec<Point3<f64>> = own.iter().map(|position| in_table(position, setup)).collect();
        let place = fitted(&seen_in_table, setup, &setup.ball_in_table_mm);
        if (place - setup.ball_in_table_mm).norm() > TOGETHER_MM {
            moved_on_table.push(words(setup, "ball_in_table_mm", &setup.ball_in_table_mm, &place));
        }
        on_table[k].ball_in_table_mm = place;
        let seen_in_tool: Vec<Point3<f64>> = own.iter().map(|position| in_tool(position, setup)).collect();
        let place = fitted(&seen_in_tool, setup, &setup.ball_in_tool_mm);
        if (place - setup.ball_in_tool_mm).norm() > TOGETHER_MM {
            moved_on_tool.push(words(setup, "ball_in_tool_mm", &setup.ball_in_tool_mm, &place));
        }
        on_tool[k].ball_in_tool_mm = place;
        if let Some(given_mm) = length_mm(setup) {
            let apart = seen_in_table.iter().map(|seen| (seen - setup.ball_in_table_mm).norm());
            let mean_mm = mean(apart).unwrap_or(given_mm);
            if (mean_mm - given_mm).abs() > TOGETHER_MM {
                lengthened.push(format!(
                    "the length of the bar of setup {}, bar_length_mm, {mean_mm:.1}, not {given_mm:.1} mm",
                    setup.name
                ));
            }
            as_long[k].bar_length_mm = Some(mean_mm);
        }
    }
    let tried = [(lengthened, as_long), (moved_on_table, on_table), (moved_on_tool, on_tool)];
    let tried = tried.into_iter().filter(|(words, _)| !words.is_empty());
    tried.map(|(words, setups)| (words.join(" and "), Claim { setups, ..claim.clone() }.rms_mm())).collect()
}

fn length_mm(setup: &Setup) -> Option<f64> {
    setup.bar_length_mm.filter(|_| setup.instrument.keeps_bar_length())
}

/// The place that is nearest to where the other ball was seen; of a bar, nearest to its length away from there.
fn fitted(seen: &[Point3<f64>], setup: &Setup, given: &Point3<f64>) -> Point3<f64> {
    let sum: Vector3<f64> = seen.iter().map(|seen| seen.coords).sum();
    let middle = Point3::from(sum / seen.len() as f64);
    let Some(length_mm) = length_mm(setup) else { return middle };
    let off = |place: &Point3<f64>| {
        DVector::from_iterator(seen.len(), seen.iter().map(|seen| (place - seen).norm() - length_mm))
    };
    let from = |start: Point3<f64>| {
        let mut place = start;
        for _ in 0..MOST_STEPS {
            let slopes = DMatrix::from_fn(seen.len(), 3, |k, i| {
                let apart = place - seen[k];
                if apart.norm() > 0.0 { apart[i] / apart.norm() } else { 0.0 }
            });
            let svd = slopes.svd(true, true);
            let unseen = UNSEEN * svd.singular_values.max();
            let Ok(step) = svd.solve(&off(&place), unseen) else { break };
            place -= Vector3::new(step[0], step[1], step[2]);
        }
        place
    };
    [from(*given), from(middle)]
        .into_iter()
        .min_by(|a, b| off(a).norm().total_cmp(&off(b).norm()))
        .unwrap_or(*given)
}
