//! Which points stand at the same pose.
//!
//! Recorded positions scatter: an axis stops a little elsewhere each time and its encoder flickers. Two positions of a joint are one stand
//! when no step between them is longer than [`same_position`] and the steps from one stand to the next are much longer than those within.
//! Else they are those of a joint in motion, or of a finer grid: there only equal positions are one. Rotary joints are asked first, and
//! linear ones among points at one pose of these: where they only follow the ball, they come as close to each other as they please.

use std::collections::HashMap;
use std::hash::Hash;
use trunnion_core::{AxisValues, Joint, State};
use trunnion_effects::same_position;

/// Positions that go on without a step for longer than this many times [`same_position`] are no stand.
const LONGEST_STAND: f64 = 4.0;
/// The shortest step between stands is at least this many times the longest within one: positions of an uneven grid have steps of any size.
const APART: f64 = 4.0;
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

/// The joints of which the side counts from which a pose was reached: of none, of all, of each. An axis may come back badly from the other side.
pub(crate) fn sides_asked(joints: &[Joint]) -> Vec<&[Joint]> {
    [&[], joints].into_iter().chain(joints.iter().map(std::slice::from_ref)).collect()
}

/// From which side some joints came: up, or down.
pub(crate) fn side(state: &State, joints: &[Joint]) -> Vec<(bool, bool)> {
    let direction = |&joint: &Joint| state.direction[joint];
    joints.iter().map(direction).map(|way| (way > 0.0, way < 0.0)).collect()
}

/// Numbers groups of positions within the groups given, in order of appearance.
pub(crate) fn same_pose(groups: Vec<usize>, positions: &[&AxisValues<f64>], joints: &[Joint]) -> Vec<usize> {
    let (rotary, linear): (Vec<Joint>, Vec<Joint>) =
        joints.iter().copied().partition(|joint| joint.is_rotary());
    rotary.iter().chain(&linear).fold(number(groups), |groups, &joint| {
        let within = stands_within(&groups, positions, joint);
        number(groups.into_iter().zip(within))
    })
}

/// Which stand of its group each position of a joint belongs to.
fn stands_within(groups: &[usize], positions: &[&AxisValues<f64>], joint: Joint) -> Vec<i64> {
    let at = |i: usize| positions[i][joint];
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|&i, &j| groups[i].cmp(&groups[j]).then(at(i).total_cmp(&at(j))));
    let mut stand = vec![0; order.len()];
    for group in order.chunk_by(|&i, &j| groups[i] == groups[j]) {
        let sorted: Vec<f64> = group.iter().map(|&i| at(i)).collect();
        let numbers = stands_of(&sorted, same_position(joint.slot()));
        group.iter().zip(numbers).for_each(|(&i, number)| stand[i] = number);
    }
    stand
}

/// The stand of each of the positions of a joint, in ascending order.
fn stands_of(sorted: &[f64], same: f64) -> Vec<i64> {
    let (mut longest_within, mut shortest_between, mut first) = (0.0_f64, f64::INFINITY, sorted[0]);
    let (mut numbers, mut goes_on) = (vec![0], false);
    for pair in sorted.windows(2) {
        let step = pair[1] - pair[0];
        let is_next = step > same;
        if is_next {
            (shortest_between, first) = (shortest_between.min(step), pair[1]);
        } else {
            longest_within = longest_within.max(step);
            goes_on |= pair[1] - first > LONGEST_STAND * same;
        }
        numbers.push(numbers[numbers.len() - 1] + i64::from(is_next));
    }
    if goes_on || shortest_between < APART * longest_within {
        return sorted.iter().map(|position| (position * EQUAL).round() as i64).collect();
    }
    numbers
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
    fn positions_of_an_uneven_grid_are_poses_of_their_own() {
        let x_mm: Vec<f64> =
            (0..12).map(|i| 0.06 * f64::from(i) + 0.02 * (f64::from(i) * 2.4).sin()).collect();
        assert_eq!(numbered(&x_mm, &[0.5; 12]), (0..12).collect::<Vec<_>>());
    }

    #[test]
    fn neighbours_of_a_fine_grid_are_poses_of_their_own() {
        let x_mm: Vec<f64> = (0..40).chain(0..40).map(|i| 0.017 * f64::from(i)).collect();
        let expected: Vec<usize> = (0..40).chain(0..40).collect();
        assert_eq!(numbered(&x_mm, &[0.5; 80]), expected);
    }
}
