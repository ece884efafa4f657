//! u of the location errors under the noise that the readings of all heights show together.
//!
//! The noise is learned from what the error motions leave: each is a mean of the passes, so what changes from pass to pass and from height to
//! height stays. A height with a single pass has no error motion of its own, and nothing is taken off.

use super::fit::{HeightFit, Heights};
use crate::common::shares::{Shares, u_under_noise};
use crate::recipes::MethodError;
use nalgebra::Vector3;
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::{BeyondModel, Experiment, Patterns, Problem};

/// Of the tilts about u and v, then of the places along u and v; `None` where the readings do not say what is noise.
pub(super) fn u_of_lines(runs: &[Run], heights: &Heights) -> Result<Option<Vec<f64>>, MethodError> {
    let mut runs = runs.to_vec();
    let mut readings: Vec<&mut [f64; 3]> = runs
        .iter_mut()
        .flat_map(|run| run.points.iter_mut())
        .filter(|point| point.is_good())
        .map(|point| &mut point.reading_mm)
        .collect();
    let repeated = || heights.sets.iter().filter(|set| set.repeated);
    for (number, motion_mm) in repeated().flat_map(|set| &set.motion_of_readings_mm) {
        *readings[*number] = (Vector3::from(*readings[*number]) - motion_mm).into();
    }
    let found = |set: &HeightFit| 3 * set.motion_mm.iter().flatten().count();
    let taken_off = repeated().map(found).sum();
    let experiment = Experiment::of_points(&runs)?;
    let problem = Problem::new(&experiment, &Model::base(&experiment.machine().name))?;
    let [[u_at_zero, u_slope], [v_at_zero, v_slope]] = &heights.shares_of_centre;
    let shares: [&Shares; 4] = [v_slope, u_slope, u_at_zero, v_at_zero];
    u_under_noise(&problem, &shares, BeyondModel { patterns: Patterns::Described, taken_off })
}
