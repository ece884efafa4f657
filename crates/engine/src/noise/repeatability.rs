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
    let differences_mm: Vec<f64> = differences(&repeats).map(|(_, d)| d).collect();
    let (sigma_mm, count) = scatter(&differences_mm)?;
    // Equal readings of a coarse display repeat no better than its step.
    let hidden_mm = Display::of(experiment).map_or(0.0, |display| display.hidden_mm());
    Some(Repeatability {
        sigma_mm: sigma_mm.max(hidden_mm),
        repeats: repeats.len(),
        // Neighbouring differences share a visit: about two thirds as many degrees of freedom.
        degrees_of_freedom: count * 2 / 3,
    })
}

/// The same of every channel by itself, mm; `None` for one that does not say.
pub(crate) fn of_channels_mm(experiment: &Experiment, passes: &Passes) -> Vec<Option<f64>> {
    let repeats = repeats(experiment, passes);
    let channels = repeats.iter().map(|repeat| repeat.difference_mm.len()).max().unwrap_or(0);
    let of_channel = |channel: usize| {
        let own: Vec<f64> = differences(&repeats).filter(|(k, _)| *k == channel).map(|(_, d)| d).collect();
        scatter(&own).map(|(sigma_mm, _)| sigma_mm)
    };
    (0..channels).map(of_channel).collect()
}

/// d_{i+1} − d_i of every channel, mm.
fn differences(repeats: &[Repeat]) -> impl Iterator<Item = (usize, f64)> {
    let neighbours = repeats.windows(2).filter(|pair| pair[0].passes == pair[1].passes);
    neighbours.flat_map(|pair| {
        pair[0].difference_mm.iter().zip(&pair[1].difference_mm).map(|(a, b)| b - a).enumerate()
    })
}

/// σ, mm, and the number of differences that are no outliers.
fn scatter(differences_mm: &[f64]) -> Option<(f64, usize)> {
    let sizes_mm: Vec<f64> = differences_mm.iter().map(|d| d.abs()).collect();
    let robust_mm = upper_median(&sizes_mm).unwrap_or(0.0) / MEDIAN_OF_NORMAL;
    // Coarse readings may repeat exactly at most poses: then no distance is far.
    let near = sizes_mm.iter().filter(|size| robust_mm == 0.0 || **size <= SIGMAS * robust_mm);
    let (count, squares) =
        near.fold((0_usize, 0.0), |(count, squares), size| (count + 1, squares + size * size));
    (count >= FEWEST).then(|| ((squares / 4.0 / count as f64).sqrt(), count))
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
