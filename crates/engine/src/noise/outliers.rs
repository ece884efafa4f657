//! Outliers: points far from the rest, excluded from a fit.
//!
//! A point is flagged when its residual is longer than 5 robust standard deviations (median length over the median of the
//! χ distribution; of a channel that scatters more by itself its own). More than two flagged one after the other, as they were taken, are structure that the model lacks, and more
//! than 6 % flagged means that the model is wrong, not the points: then none is excluded. One that is far beyond all the others of such a row is
//! no structure: it pulls the fit, and the others with it. So is what comes back at its pose: a point
//! that leaves as much as another visit of its pose is the machine, however far it is from the rest. Hard deletion, iterated by
//! [`excluded`] until it stays the same.

use crate::Experiment;
use crate::problem::sequence::in_order_taken;
use nalgebra::DVector;
use std::collections::HashMap;
use trunnion_core::statistics::{MEDIAN_OF_NORMAL, upper_median};

const SIGMAS: f64 = 5.0;
const LONGEST_RUN: usize = 2;
const LARGEST_SHARE: f64 = 0.06;
/// A reading that is wrong by e leaves (1 − h)e, h its leverage, and moves what others of that leverage leave by no more than he [Hoaglin 1978]:
/// by less than a fifth of its own where h is less than a sixth. A bump of the machine is not so sharp.
const PEAK: f64 = 5.0;
/// Readings are never trusted below this, mm: ten times under the resolution of any probe.
const FINEST_MM: f64 = 1e-6;
/// Median of the length of a standard normal vector of one and of three components.
const MEDIAN_LENGTH: [f64; 2] = [MEDIAN_OF_NORMAL, 1.5382];
/// Rounds of excluding points.
const MOST_ROUNDS: usize = 6;

/// Fits, excludes what is far, and fits again until the same points stay: `fit` of the points used gives a fit and its residual,
/// rows as they count in the fit, mm.
pub(crate) fn excluded<T, E>(
    experiment: &Experiment,
    fit: impl Fn(&[bool]) -> Result<T, E>,
    residual_mm: impl Fn(&T) -> &DVector<f64>,
) -> Result<(Vec<bool>, T), E> {
    let sequence = in_order_taken(experiment);
    let poses = experiment.poses();
    let mut used = vec![true; experiment.points.len()];
    let mut fitted = fit(&used)?;
    for _ in 0..MOST_ROUNDS {
        let kept = without_outliers(experiment, (&sequence, &poses), residual_mm(&fitted));
        if kept == used {
            break;
        }
        used = kept;
        fitted = fit(&used)?;
    }
    Ok((used, fitted))
}

/// True for points to use.
fn without_outliers(
    experiment: &Experiment,
    (sequence, poses): (&[usize], &[usize]),
    residual_mm: &DVector<f64>,
) -> Vec<bool> {
    let sigma_mm = sigmas_mm(experiment, residual_mm);
    let in_sigma = residual_mm.component_div(&sigma_mm);
    let of_point = |i: usize| in_sigma.rows_range(experiment.rows_of(i));
    let is_far = |i: usize| of_point(i).norm() > SIGMAS;
    let mut far_at: HashMap<usize, Vec<usize>> = HashMap::new();
    (0..poses.len()).filter(|&i| is_far(i)).for_each(|i| far_at.entry(poses[i]).or_default().push(i));
    // Two readings of one error differ by √2 times the scatter of one.
    let comes_back = |i: usize| {
        let others = far_at[&poses[i]].iter().filter(|&&j| j != i);
        let mut apart = others.map(|&j| (of_point(i) - of_point(j)).norm());
        apart.any(|apart| apart <= SIGMAS * 2f64.sqrt())
    };
    let flags = sequence.iter().map(|&i| (is_far(i) && !comes_back(i)).then(|| of_point(i).norm()));
    let mut used = vec![true; experiment.points.len()];
    for (&i, far) in sequence.iter().zip(isolated(&flags.collect::<Vec<_>>())) {
        used[i] = !far;
    }
    used
}

/// Robust standard deviation of every row: of all points, and of its own channel where that is larger.
fn sigmas_mm(experiment: &Experiment, residual_mm: &DVector<f64>) -> DVector<f64> {
    let points = 0..experiment.points.len();
    let length_in_sigma = |i: usize| {
        let rows = experiment.rows_of(i);
        residual_mm.rows_range(rows.clone()).norm() / MEDIAN_LENGTH[usize::from(rows.len() == 3)]
    };
    let lengths: Vec<f64> = points.clone().map(length_in_sigma).collect();
    let of_all_mm = upper_median(&lengths).unwrap_or(0.0).max(FINEST_MM);
    // Channels of instruments that read as many.
    let channel_of_row: Vec<(usize, usize)> = points
        .map(|i| experiment.rows_of(i).len())
        .flat_map(|count| (0..count).map(move |k| (count, k)))
        .collect();
    let mut of_channels: HashMap<(usize, usize), Vec<f64>> = HashMap::new();
    for (channel, r) in channel_of_row.iter().zip(residual_mm.iter()) {
        of_channels.entry(*channel).or_default().push(r.abs());
    }
    let of_channels: HashMap<(usize, usize), f64> = of_channels
        .into_iter()
        .map(|(channel, sizes)| (channel, upper_median(&sizes).unwrap_or(0.0) / MEDIAN_OF_NORMAL))
        .collect();
    DVector::from_iterator(
        channel_of_row.len(),
        channel_of_row.iter().map(|channel| of_channels[channel].max(of_all_mm)),
    )
}

/// Of the points flagged in the order they were taken, each with how far it is, those that are no structure; none when there are too many.
fn isolated(far: &[Option<f64>]) -> Vec<bool> {
    let count = far.len();
    let mut flagged: Vec<bool> = far.iter().map(Option::is_some).collect();
    let mut start = 0;
    while start < count {
        let end = (start..count).find(|&k| !flagged[k]).unwrap_or(count);
        if end - start > LONGEST_RUN {
            flagged[start..end].fill(false);
            if let Some(peak) = peak(&far[start..end]) {
                flagged[start + peak] = true;
            }
        }
        start = end + 1;
    }
    let share = flagged.iter().filter(|far| **far).count() as f64 / count.max(1) as f64;
    if share > LARGEST_SHARE {
        flagged.fill(false);
    }
    flagged
}

/// The one of several that is far beyond all others.
fn peak(far: &[Option<f64>]) -> Option<usize> {
    let size = |k: &usize| far[*k].unwrap_or(0.0);
    let mut order: Vec<usize> = (0..far.len()).collect();
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let [first, second, ..] = order[..] else { return None };
    (size(&first) > PEAK * size(&second)).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::isolated;

    fn flagged(count: usize, far: &[usize]) -> Vec<bool> {
        (0..count).map(|k| far.contains(&k)).collect()
    }

    /// All as far as each other.
    fn kept_apart(count: usize, far: &[usize]) -> Vec<bool> {
        isolated(&flagged(count, far).into_iter().map(|far| far.then_some(6.0)).collect::<Vec<_>>())
    }

    #[test]
    fn single_points_and_pairs_are_outliers_a_longer_stretch_is_structure() {
        assert_eq!(kept_apart(100, &[3, 10, 11, 99]), flagged(100, &[3, 10, 11, 99]));
        assert_eq!(kept_apart(100, &[3, 10, 11, 12]), flagged(100, &[3]));
    }

    #[test]
    fn one_that_pulls_the_others_of_its_stretch_is_an_outlier() {
        let mut far = [None; 100];
        far[48..53].copy_from_slice(&[20.0, 40.0, 4000.0, 40.0, 20.0].map(Some));
        assert_eq!(isolated(&far), flagged(100, &[50]));
        // A sharp bump of the machine.
        far[50] = Some(150.0);
        assert_eq!(isolated(&far), flagged(100, &[]));
    }

    #[test]
    fn where_many_points_are_far_the_model_is_wrong_and_none_is_excluded() {
        assert_eq!(kept_apart(100, &[0, 10, 20, 30, 40, 50]), flagged(100, &[0, 10, 20, 30, 40, 50]));
        assert_eq!(kept_apart(100, &[0, 10, 20, 30, 40, 50, 60]), flagged(100, &[]));
    }
}
