//! Which points stand at the same pose.
//!
//! Recorded positions scatter: an axis stops a little elsewhere each time and its encoder flickers. Two positions of a joint are one
//! when no step between them is longer than [`same_position`]. Positions that go on like this for longer than a stand are those of a
//! joint in motion, or of a finer grid: there only equal positions are one.

use std::collections::HashMap;
use std::hash::Hash;
use trunnion_core::{AxisValues, Joint};
use trunnion_effects::same_position;

/// Positions that go on without a step for longer than this many times [`same_position`] are no stand.
const LONGEST_STAND: f64 = 4.0;
/// Equal positions, as steps per mm and rad: nm and nrad.
const EQUAL: f64 = 1e6;

/// Where a joint stood, mm or rad: the mean of the positions of each stand.
pub(crate) fn stood(positions: &[&AxisValues<f64>], joint: Joint) -> Vec<f64> {
    let stand = same_pose(vec![0; positions.len()], positions, &[joint]);
    let mut sums = vec![(0.0, 0.0); count(&stand)];
    for (position, &stand) in positions.iter().zip(&stand) {
        let (sum, number) = &mut sums[stand];
        (*sum, *number) = (*sum + position[joint], *number + 1.0);
    }
    stand.iter().map(|&stand| sums[stand].0 / sums[stand].1).collect()
}

/// Numbers groups of positions within the groups given, in order of appearance.
pub(crate) fn same_pose(groups: Vec<usize>, positions: &[&AxisValues<f64>], joints: &[Joint]) -> Vec<usize> {
    let near = |groups: Vec<usize>, joint: &Joint| {
        let steps = steps(positions, *joint);
        number(groups.into_iter().zip(steps))
    };
    let apart = |groups: Vec<usize>, joint: &Joint| {
        let wide = wide(&groups, positions, *joint);
        let equal = |(i, group): (usize, usize)| {
            (group, wide[group].then(|| (positions[i][*joint] * EQUAL).round() as i64))
        };
        number(groups.into_iter().enumerate().map(equal))
    };
    let groups = joints.iter().fold(number(groups), near);
    joints.iter().fold(groups, apart)
}

/// Number of the stretch without a step in which each position lies.
fn steps(positions: &[&AxisValues<f64>], joint: Joint) -> Vec<usize> {
    let at = |i: usize| positions[i][joint];
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|&i, &j| at(i).total_cmp(&at(j)));
    let (mut stretch, mut number) = (vec![0; order.len()], 0);
    for pair in order.windows(2) {
        number += usize::from(at(pair[1]) - at(pair[0]) > same_position(joint.slot()));
        stretch[pair[1]] = number;
    }
    stretch
}

/// Whether the positions of a joint in each group go on for longer than a stand.
fn wide(groups: &[usize], positions: &[&AxisValues<f64>], joint: Joint) -> Vec<bool> {
    let mut range = vec![(f64::INFINITY, f64::NEG_INFINITY); count(groups)];
    for (position, &group) in positions.iter().zip(groups) {
        let (low, high) = range[group];
        range[group] = (low.min(position[joint]), high.max(position[joint]));
    }
    range.into_iter().map(|(low, high)| high - low > LONGEST_STAND * same_position(joint.slot())).collect()
}

/// Numbers keys in order of appearance.
pub(crate) fn number<K: Eq + Hash>(keys: impl IntoIterator<Item = K>) -> Vec<usize> {
    let mut numbers = HashMap::new();
    keys.into_iter()
        .map(|key| {
            let next = numbers.len();
            *numbers.entry(key).or_insert(next)
        })
        .collect()
}

/// How many groups these numbers name.
pub(crate) fn count(numbers: &[usize]) -> usize {
    numbers.iter().max().map_or(0, |most| most + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(x_mm: &[f64], c_rad: &[f64]) -> Vec<usize> {
        let at = |(x, c): (&f64, &f64)| {
            let mut position = AxisValues::default();
            (position[Joint::X], position[Joint::C]) = (*x, *c);
            position
        };
        let positions: Vec<_> = x_mm.iter().zip(c_rad).map(at).collect();
        let positions: Vec<_> = positions.iter().collect();
        same_pose(vec![0; x_mm.len()], &positions, &[Joint::X, Joint::C])
    }

    #[test]
    fn a_pose_that_is_approached_again_is_the_same_though_positions_scatter() {
        let x_mm = [0.0, 10.0, 10.02, 0.0003, 10.0002, 10.0199];
        let c_rad = [0.0, 0.1, 0.2, 1e-5, 0.1 - 1e-5, 0.2 + 1e-5];
        assert_eq!(numbered(&x_mm, &c_rad), [0, 1, 2, 0, 1, 2]);
    }

    #[test]
    fn neighbours_of_a_fine_grid_are_poses_of_their_own() {
        let x_mm: Vec<f64> = (0..40).chain(0..40).map(|i| 0.017 * f64::from(i)).collect();
        let expected: Vec<usize> = (0..40).chain(0..40).collect();
        assert_eq!(numbered(&x_mm, &[0.5; 80]), expected);
    }
}
