//! The order in which points were taken.

use crate::Experiment;

/// Points by clock and time; without time the order of the points is the time.
pub(crate) fn in_order_taken(experiment: &Experiment) -> Vec<usize> {
    let key = clocks_and_times(experiment);
    let mut order: Vec<usize> = (0..experiment.points.len()).collect();
    order.sort_by(|&i, &j| key[i].0.cmp(&key[j].0).then(key[i].1.total_cmp(&key[j].1)));
    order
}

/// Clock of every point, and its time in units of time of the order: s, or its number where nothing is timed.
///
/// A run has one clock, unless its time begins again with another setup: from the beginning of the run or before it. How long after the last
/// point that was, nobody knows.
pub(crate) fn clocks_and_times(experiment: &Experiment) -> Vec<(usize, f64)> {
    let timed = experiment.scene.time_range_s.is_some();
    let time = |i: usize| experiment.points[i].state.time_s.filter(|_| timed).unwrap_or(i as f64);
    let (mut clock, mut begun) = (0, 0.0);
    let of_point = |i: usize| {
        if i == 0 || experiment.run_of_point[i] != experiment.run_of_point[i - 1] {
            (clock, begun) = (clock + 1, time(i));
        } else if time(i) <= begun
            && time(i - 1) > time(i)
            && setup(experiment, i) != setup(experiment, i - 1)
        {
            clock += 1;
        }
        (clock, time(i))
    };
    (0..experiment.points.len()).map(of_point).collect()
}

fn setup(experiment: &Experiment, i: usize) -> usize {
    experiment.points[i].state.setup
}
