//! Repeatability of one scalar reading: how the readings of one pose of one setup scatter when it is measured again.
//!
//! d = second − first visit of the reading, in the order of the first visit; σ² = mean (d_{i+1} − d_i)² / 4. The difference of
//! differences removes what the two passes have in common or what drifts between them slowly (backlash of the fast axis, thermal
//! drift). Of the readings, not of a residual: at one commanded pose every error of position and mounting is the same, so no model
//! enters, and every model of a recording shares one figure. Differences longer than 5 robust standard deviations, of all or of their own
//! channel where that scatters more, are excluded.
//!
//! A pose that an axis comes to from the other side repeats with the backlash of that axis. Where visits from one side differ less than
//! all visits, by more than chance, they alone say how readings repeat (unidirectional repeatability, ISO 230-2).
//! Limits: white from pose to pose; where no pose is visited twice from one side, direction-dependent errors that change within one step
//! of the fast axis count as scatter. Where points are means of several readings, the figure is that of such means.

use crate::Experiment;
use crate::fit::identification::{Approach, Repeatability};
use crate::noise::learned::display::{Display, nominal_mm};
use crate::problem::passes::Passes;
use crate::problem::poses::{side, sides_asked};
use nalgebra::Vector3;
use std::collections::HashMap;
use trunnion_core::Joint;
use trunnion_core::statistics::{MEDIAN_OF_NORMAL, upper_median};

/// Fewer differences than this say nothing.
const FEWEST: usize = 6;
/// A difference of differences beyond this many robust standard deviations holds an outlier; as for points of a fit.
const SIGMAS: f64 = 5.0;
/// Two variances differ when the logarithm of their ratio is so many of its standard deviations, √(2/ν₁ + 2/ν₂), from zero: one in 700 by
/// chance [normal distribution].
const SURE: f64 = 3.0;

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
    let joints = experiment.machine().joints();
    let (all, from_one_side) = (repeats(experiment, passes, &[]), repeats(experiment, passes, &joints));
    let of_all = Scatter::of(&all)?;
    let of_one_side = Scatter::of(&from_one_side);
    let (scatter, approach) = match of_one_side {
        Some(of_one_side) if of_all.is_larger_than(&of_one_side) => (of_one_side, Approach::OneSide),
        // Where they differ by no more than chance, the larger number of visits says more.
        Some(_) => (of_all, Approach::NoMatter),
        None => (of_all, Approach::BothSides),
    };
    // Equal readings of a coarse display repeat no better than its step.
    let hidden_mm = Display::of(experiment).map_or(0.0, |display| display.hidden_mm());
    Some(Repeatability {
        sigma_mm: scatter.sigma_mm.max(hidden_mm),
        repeats: all.len(),
        degrees_of_freedom: scatter.degrees_of_freedom(),
        approach,
        readings: experiment.readings_of_point(),
    })
}

/// The same of every channel by itself, mm, of the visits that repeat best: from one side of all axes, of one, or from any. An axis may come back
/// badly from the other side. `None` for a channel that does not say.
pub(crate) fn of_channels_mm(experiment: &Experiment, passes: &Passes) -> Vec<Option<f64>> {
    let joints = experiment.machine().joints();
    let of_sides: Vec<Vec<Repeat>> =
        sides_asked(&joints).into_iter().map(|joints| repeats(experiment, passes, joints)).collect();
    let channels = of_sides[0].iter().map(|repeat| repeat.difference_mm.len()).max().unwrap_or(0);
    let of_channel = |channel: usize| {
        let sigmas_mm = of_sides.iter().filter_map(|repeats| {
            let own = differences(repeats).filter(|(k, _)| *k == channel).map(|(_, d)| d.abs());
            Scatter::of_channels(std::iter::once(own.collect())).map(|scatter| scatter.sigma_mm)
        });
        sigmas_mm.reduce(f64::min)
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

/// How differences scatter.
struct Scatter {
    sigma_mm: f64,
    /// As many differences of channels that scatter alike say as much [Welch–Satterthwaite, GUM G.4.1].
    count: f64,
}

impl Scatter {
    fn of(repeats: &[Repeat]) -> Option<Self> {
        let channels = repeats.iter().map(|repeat| repeat.difference_mm.len()).max().unwrap_or(0);
        let of_channel = |channel| differences(repeats).filter(move |(k, _)| *k == channel);
        Self::of_channels((0..channels).map(|channel| of_channel(channel).map(|(_, d)| d.abs()).collect()))
    }

    /// Sizes of differences, channel by channel.
    fn of_channels(sizes_mm: impl Iterator<Item = Vec<f64>>) -> Option<Self> {
        let sizes_mm: Vec<Vec<f64>> = sizes_mm.collect();
        let robust_mm = |sizes_mm: &[f64]| upper_median(sizes_mm).unwrap_or(0.0) / MEDIAN_OF_NORMAL;
        let of_all_mm = robust_mm(&sizes_mm.concat());
        let of_channel = |sizes_mm: &Vec<f64>| {
            let far_mm = SIGMAS * robust_mm(sizes_mm).max(of_all_mm);
            // Coarse readings may repeat exactly at most poses: then no distance is far.
            let near = sizes_mm.iter().filter(|size| far_mm == 0.0 || **size <= far_mm);
            near.fold((0_usize, 0.0), |(count, squares), size| (count + 1, squares + size * size))
        };
        let of_channels: Vec<(usize, f64)> = sizes_mm.iter().map(of_channel).collect();
        let differences: usize = of_channels.iter().map(|(count, _)| count).sum();
        let squares: f64 = of_channels.iter().map(|(_, squares)| squares).sum();
        let unlike: f64 =
            of_channels.iter().map(|(count, squares)| squares.powi(2) / (*count).max(1) as f64).sum();
        let count = if unlike > 0.0 { squares.powi(2) / unlike } else { differences as f64 };
        let sigma_mm = (squares / 4.0 / differences as f64).sqrt();
        (differences >= FEWEST).then_some(Self { sigma_mm, count })
    }

    /// Neighbouring differences share a visit: about two thirds as many as differences.
    fn degrees_of_freedom(&self) -> usize {
        (self.count * 2.0 / 3.0) as usize
    }

    /// By more than chance.
    fn is_larger_than(&self, other: &Self) -> bool {
        let chance =
            [self, other].map(|one| 2.0 / one.degrees_of_freedom() as f64).iter().sum::<f64>().sqrt();
        2.0 * (self.sigma_mm / other.sigma_mm).ln() > SURE * chance
    }
}

/// Reading minus what a machine without errors would read, mm.
fn deviation_mm(experiment: &Experiment, i: usize) -> Vector3<f64> {
    Vector3::from(experiment.points[i].reading_mm) - nominal_mm(experiment, i)
}

/// Every visit of a pose with the one before it, of those from the same side in some axes.
fn repeats(experiment: &Experiment, passes: &Passes, from_one_side: &[Joint]) -> Vec<Repeat> {
    let mut last_visit = HashMap::new();
    let mut repeats = Vec::new();
    for (i, pose) in experiment.poses().into_iter().enumerate() {
        let from = side(&experiment.points[i].state, from_one_side);
        let key = (experiment.run_of_point[i], pose, from);
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
