//! An interferometer that lost counts, or was zeroed again, while it was read.
//!
//! Deviations e = reading − nominal at one pose, approached from one side, come again. With a step s from row k on they are
//! e_i = μ_pose + s·[i ≥ k]; s = h·e/h·h of both less the mean of their pose. Where every pose was read once, or all of them before k, nothing shows it:
//! it may be the axis. Over a pause material may grow as fast: no step is sought there. Of more readings than are looked at elsewhere none is asked.

use super::exchanged::{BELIEVED, GROSS_UM};
use super::found::Implausible;
use super::looked::MOST_POINTS;
use super::readings::FEWEST_POINTS;
use crate::Experiment;
use crate::noise::learned::display::nominal_readings_mm;
use crate::problem::poses::same_pose;
use std::collections::{HashMap, HashSet};
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::signed;
use trunnion_core::{InstrumentKind, Point, statistics};
use trunnion_cycles::Run;

/// Poses that are read before and after a step; fewer agree about one by chance, and a turning point that is read twice is one.
const FEWEST_ACROSS: usize = 6;
/// A pause is longer than so many usual steps.
const PAUSE_STEPS: f64 = 10.0;

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    runs.iter().filter_map(|run| (0..run.setups.len()).find_map(|setup| of_setup(run, setup))).collect()
}

fn of_setup(run: &Run, setup: usize) -> Option<Implausible> {
    let placed = &run.setups[setup];
    if placed.instrument != InstrumentKind::Diagonal || run.points.iter().any(|point| point.samples > 1) {
        return None;
    }
    let own = |(_, point): &(usize, &Point)| point.state.setup == setup && point.is_good();
    let (rows, points): (Vec<usize>, Vec<Point>) =
        (1..).zip(&run.points).filter(own).map(|(row, point)| (row, point.clone())).unzip();
    if !(FEWEST_POINTS..=MOST_POINTS).contains(&points.len()) {
        return None;
    }
    let experiment = Experiment::of_points(&[Run { points: points.clone(), ..run.clone() }]).ok()?;
    let error_mm = experiment.readings_mm() - nominal_readings_mm(&experiment);
    let poses = poses(run, &points);
    let error_mm = less_means(error_mm.as_slice(), &poses);
    let before_mm = statistics::rms(error_mm.iter().copied())?;
    let is_pause = pauses(&points);
    let steps = (1..points.len()).filter(|at| !is_pause[*at]).filter_map(|at| {
        let step: Vec<f64> = (0..points.len()).map(|i| f64::from(u8::from(i >= at))).collect();
        if across(&poses, at) < FEWEST_ACROSS {
            return None;
        }
        let step = less_means(&step, &poses);
        let squares: f64 = step.iter().map(|h| h * h).sum();
        let size_mm = step.iter().zip(&error_mm).map(|(h, e)| h * e).sum::<f64>() / squares;
        let left_mm = statistics::rms(step.iter().zip(&error_mm).map(|(h, e)| e - size_mm * h))?;
        size_mm.is_finite().then_some((at, size_mm, left_mm))
    });
    let (at, size_mm, left_mm) = steps.min_by(|a, b| a.2.total_cmp(&b.2))?;
    let [size_um, before_um, left_um] = [size_mm, before_mm, left_mm].map(um_from_mm);
    (size_um.abs() > GROSS_UM && BELIEVED * left_um < before_um).then(|| Implausible {
        finding: format!(
            "{}: from row {} on, all readings of setup {} are {} µm off those of the same poses before: they repeat within {before_um:.1} µm, \
             without this step within {left_um:.1} µm.",
            run.name,
            rows[at],
            placed.name,
            signed(size_um, 1)
        ),
        hypothesis: "The interferometer lost counts (the beam was interrupted, or an axis too fast for it) or was zeroed again. Measure again, or \
                     take the step off the readings from this row on."
            .into(),
        rms_um_with_it: Some(left_um),
    })
}

/// Poses, apart by the side from which they were approached.
fn poses(run: &Run, points: &[Point]) -> Vec<usize> {
    let joints = run.machine.joints();
    let mut sides: HashMap<Vec<i8>, usize> = HashMap::new();
    let side = |point: &Point| {
        let of_joints = joints.iter().map(|&joint| {
            let direction = point.state.direction[joint];
            if direction == 0.0 { 0 } else { direction.signum() as i8 }
        });
        let next = sides.len();
        *sides.entry(of_joints.collect()).or_insert(next)
    };
    let groups: Vec<usize> = points.iter().map(side).collect();
    let positions: Vec<_> = points.iter().map(|point| &point.state.position).collect();
    same_pose(groups, &positions, &joints)
}

/// How many poses are read both before a point and from it on.
fn across(poses: &[usize], at: usize) -> usize {
    let before: HashSet<usize> = poses[..at].iter().copied().collect();
    poses[at..].iter().copied().filter(|pose| before.contains(pose)).collect::<HashSet<_>>().len()
}

fn less_means(values: &[f64], poses: &[usize]) -> Vec<f64> {
    let mut sums: HashMap<usize, (f64, f64)> = HashMap::new();
    for (value, pose) in values.iter().zip(poses) {
        let sum = sums.entry(*pose).or_default();
        *sum = (sum.0 + value, sum.1 + 1.0);
    }
    values.iter().zip(poses).map(|(value, pose)| value - sums[pose].0 / sums[pose].1).collect()
}

/// Whether a pause is before each point.
fn pauses(points: &[Point]) -> Vec<bool> {
    let step_s = |at: usize| Some(points[at].state.time_s? - points[at.checked_sub(1)?].state.time_s?);
    let all_s: Vec<f64> = (1..points.len()).filter_map(step_s).collect();
    let usual_s = statistics::median(&all_s).unwrap_or(0.0);
    (0..points.len()).map(|at| step_s(at).is_some_and(|step_s| step_s > PAUSE_STEPS * usual_s)).collect()
}
