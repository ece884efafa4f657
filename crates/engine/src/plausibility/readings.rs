//! Do the readings depend on the poses, and do they belong to them?

use super::exchanged::{self, GROSS_UM};
use super::found::Implausible;
use super::looked::Looked;
use super::path;
use crate::problem::poses::{number, same_pose, side, sides_asked};
use std::collections::HashMap;
use trunnion_core::Point;
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::Run;

/// Readings of one pose scatter by at least this share of the scatter of all poses: they do not depend on the pose. Of noise alone the
/// share is 1 with the standard deviation 1/√(2f) of f repeats [Neumann 1941]: this is two of them below at 32 repeats, so that
/// fewer are doubted a little too seldom.
const NO_STRUCTURE: f64 = 0.75;
/// Fewer points say nothing.
pub const FEWEST_POINTS: usize = 12;

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    let looked: Vec<Looked> = runs
        .iter()
        .filter_map(Looked::at)
        .filter(|looked| looked.run.points.len() >= FEWEST_POINTS)
        .collect();
    let found: Vec<Implausible> =
        looked.iter().filter_map(|looked| nothing_but_scatter(&looked.run)).collect();
    if !found.is_empty() {
        return found;
    }
    let of_run = |looked| {
        exchanged::exchanged(looked)
            .or_else(|| exchanged::delayed::by_rows(looked))
            .or_else(|| exchanged::repeated::late(looked))
            .or_else(|| exchanged::small::small(looked))
            .or_else(|| exchanged::plain::plain(looked))
            .or_else(|| path::left(looked))
    };
    looked.iter().filter_map(of_run).collect()
}

/// Readings that depend neither on the pose nor on those before. Backlash differs at one pose, but not where the axis comes from the same side;
/// drift does, but not from one reading to the next.
fn nothing_but_scatter(run: &Run) -> Option<Implausible> {
    let first = run.setups.first()?.instrument;
    if !first.deflects_probes() || run.setups.iter().any(|setup| setup.instrument != first) {
        return None;
    }
    let components = first.components().len();
    let joints = run.machine.joints();
    let setup: Vec<usize> = run.points.iter().map(|point| point.state.setup).collect();
    let positions: Vec<_> = run.points.iter().map(|point| &point.state.position).collect();
    let poses = same_pose(setup.clone(), &positions, &joints);
    let within = sides_asked(&joints).into_iter().filter_map(|joints| {
        let from_one_side =
            run.points.iter().zip(&poses).map(|(point, pose)| (pose, side(&point.state, joints)));
        scatter_um(run, components, &number(from_one_side))
    });
    let (within_um, all_um) = (within.reduce(f64::min)?, scatter_um(run, components, &setup)?);
    let is_nothing_else = |scatter_um: f64| scatter_um > GROSS_UM && scatter_um > NO_STRUCTURE * all_um;
    let is_scatter = is_nothing_else(within_um) && is_nothing_else(from_next_um(run, components));
    is_scatter.then(|| Implausible {
        finding: format!(
            "{}: readings of one pose scatter by {within_um:.1} µm, nothing but noise next to the {all_um:.1} µm of all poses.",
            run.name
        ),
        hypothesis: "The readings do not depend on the pose. Check that ball, nest and probes are firm, and the file.".into(),
        rms_um_with_it: None,
    })
}

/// Scatter of the readings of groups about their means, rms, µm; `None` of too few.
fn scatter_um(run: &Run, components: usize, groups: &[usize]) -> Option<f64> {
    let mut of_group: HashMap<usize, Vec<&Point>> = HashMap::new();
    groups.iter().zip(&run.points).for_each(|(group, point)| of_group.entry(*group).or_default().push(point));
    let (mut sum, mut freedom) = (0.0, 0);
    for points in of_group.values() {
        for k in 0..components {
            let mean = points.iter().map(|point| point.reading_mm[k]).sum::<f64>() / points.len() as f64;
            sum += points.iter().map(|point| (point.reading_mm[k] - mean).powi(2)).sum::<f64>();
        }
        freedom += (points.len() - 1) * components;
    }
    (freedom >= FEWEST_POINTS).then(|| um_from_mm((sum / freedom as f64).sqrt()))
}

/// Scatter from one reading to the next of a setup, root mean square of the differences / √2 [Neumann 1941], µm.
fn from_next_um(run: &Run, components: usize) -> f64 {
    let pairs = run.points.windows(2).filter(|pair| pair[0].state.setup == pair[1].state.setup);
    let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), pair| {
        let square = |k: usize| (pair[1].reading_mm[k] - pair[0].reading_mm[k]).powi(2);
        (sum + (0..components).map(square).sum::<f64>(), count + components as f64)
    });
    if count > 0.0 { um_from_mm((0.5 * sum / count).sqrt()) } else { 0.0 }
}
