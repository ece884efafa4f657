//! Repeatability of one scalar reading: how the readings of one pose of one setup scatter when it is measured again.
//!
//! d = second − first visit of the reading, in the order of the first visit; σ² = mean (d_{i+1} − d_i)² / 4. The difference of
//! differences removes what the two passes have in common or what drifts between them slowly (backlash of the fast axis, thermal
//! drift). Of the readings, not of a residual: at one commanded pose every error of position and mounting is the same, so no model
//! enters, and every model of a recording shares one figure. Pairs longer than 5 robust standard deviations are excluded.
//! Limits: white from pose to pose; direction-dependent errors that change within one step of the fast axis count as scatter.

use crate::Experiment;
use crate::fit::identification::Repeatability;
use crate::noise::learned::display::{Display, nominal_mm};
use crate::problem::passes::Passes;
use nalgebra::Vector3;
use std::collections::HashMap;
use trunnion_core::statistics::{MEDIAN_OF_NORMAL, upper_median};

/// Fewer differences than this say nothing.
const FEWEST: usize = 6;
/// A difference of differences beyond this many robust standard deviations holds an outlier; as for points of a fit.
const SIGMAS: f64 = 5.0;

/// A pose measured again.
struct Repeat {
    /// Passes of the two visits.
    passes: (usize, usize),
    first: usize,
    /// Second − first visit, mm.
    difference_mm: Vec<f64>,
}

/// `None` where too few poses were measured again to say.
pub(crate) fn repeatability(experiment: &Experiment, passes: &Passes) -> Option<Repeatability> {
    let repeats = repeats(experiment, passes);
    let neighbours = repeats.windows(2).filter(|pair| pair[0].passes == pair[1].passes);
    let differences_mm: Vec<f64> = neighbours
        .flat_map(|pair| pair[0].difference_mm.iter().zip(&pair[1].difference_mm).map(|(a, b)| b - a))
        .collect();
    let sizes_mm: Vec<f64> = differences_mm.iter().map(|d| d.abs()).collect();
    let robust_mm = upper_median(&sizes_mm).unwrap_or(0.0) / MEDIAN_OF_NORMAL;
    // Coarse readings may repeat exactly at most poses: then no distance is far.
    let near = differences_mm.iter().filter(|d| robust_mm == 0.0 || d.abs() <= SIGMAS * robust_mm);
    let (count, squares) = near.fold((0, 0.0), |(count, squares), d| (count + 1, squares + d * d));
    // Equal readings of a coarse display repeat no better than its step.
    let hidden_mm = Display::of(experiment).map_or(0.0, |display| display.hidden_mm());
    (count >= FEWEST).then(|| Repeatability {
        sigma_mm: (squares / 4.0 / f64::from(count as u32)).sqrt().max(hidden_mm),
        repeats: repeats.len(),
        // Neighbouring differences share a visit: about two thirds as many degrees of freedom.
        degrees_of_freedom: count * 2 / 3,
    })
}

/// Reading minus what a machine without errors would read, mm.
fn deviation_mm(experiment: &Experiment, i: usize) -> Vector3<f64> {
    Vector3::from(experiment.points[i].reading_mm) - nominal_mm(experiment, i)
}

fn repeats(experiment: &Experiment, passes: &Passes) -> Vec<Repeat> {
    let mut last_visit = HashMap::new();
    let mut repeats = Vec::new();
    for (i, pose) in experiment.poses().into_iter().enumerate() {
        let key = (experiment.run_of_point[i], pose);
        let Some(first) = last_visit.insert(key, i) else { continue };
        let readings = 0..experiment.rows_of(i).len();
        let (again_mm, first_mm) = (deviation_mm(experiment, i), deviation_mm(experiment, first));
        let difference = |k: usize| again_mm[k] - first_mm[k];
        repeats.push(Repeat {
            passes: (passes.pass[first], passes.pass[i]),
            first,
            difference_mm: readings.map(difference).collect(),
        });
    }
    repeats.sort_by_key(|repeat| (repeat.passes, repeat.first));
    repeats
}
