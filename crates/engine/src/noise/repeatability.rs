//! Noise of one scalar reading.
//!
//! From repeats: the same pose of the same setup visited again. d = second − first visit of the residual, in the order
//! of the first visit; σ² = mean (d_{i+1} − d_i)² / 4. The difference of differences removes what the two
//! passes have in common or what drifts between them slowly (backlash of the fast axis, thermal drift), which a model may still lack.
//! Without repeats: σ of the residual.
//! Limits: white from pose to pose; direction-dependent errors that change within one step of the fast axis count as noise.

use crate::Experiment;
use crate::fit::identification::{Noise, NoiseOrigin};
use crate::problem::passes::{Passes, pose_key};
use nalgebra::DVector;
use std::collections::HashMap;

/// Fewer differences than this say nothing.
const FEWEST: usize = 6;

pub(crate) fn noise(
    experiment: &Experiment,
    passes: &Passes,
    residual_mm: &DVector<f64>,
    used: &[bool],
    from_residual: Noise,
) -> Noise {
    let mut first_visit = HashMap::new();
    // (group, index of the first visit, difference); a group is a pair of passes.
    let mut repeats: Vec<((usize, usize), usize, Vec<f64>)> = Vec::new();
    for i in (0..experiment.points.len()).filter(|&i| used[i]) {
        let state = &experiment.points[i].state;
        let key = (experiment.run_of_point[i], state.setup, pose_key(&state.position));
        let Some(first) = first_visit.insert(key, i) else { continue };
        let difference = experiment
            .rows_of(i)
            .zip(experiment.rows_of(first))
            .map(|(b, a)| residual_mm[b] - residual_mm[a])
            .collect();
        repeats.push(((passes.pass[first], passes.pass[i]), first, difference));
    }
    repeats.sort_by_key(|(group, first, _)| (*group, *first));
    let (mut squares, mut count) = (0.0, 0);
    for pair in repeats.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        for (a, b) in pair[0].2.iter().zip(&pair[1].2) {
            squares += (b - a) * (b - a) / 4.0;
            count += 1;
        }
    }
    if count < FEWEST {
        return from_residual;
    }
    // Neighbouring differences share a visit: about two thirds as many degrees of freedom.
    Noise {
        sigma_mm: (squares / f64::from(count as u32)).sqrt(),
        origin: NoiseOrigin::Repeats,
        degrees_of_freedom: count * 2 / 3,
    }
}

/// The figure when nothing was repeated.
pub(crate) fn noise_of_residual(sigma_mm: f64, degrees_of_freedom: usize) -> Noise {
    Noise { sigma_mm, origin: NoiseOrigin::Residual, degrees_of_freedom }
}
