//! The order in which points were taken.

use crate::Experiment;

/// Points by run and time; without time the order of the points is the time.
pub(crate) fn in_order_taken(experiment: &Experiment) -> Vec<usize> {
    let mut order: Vec<usize> = (0..experiment.points.len()).collect();
    order.sort_by(|&i, &j| {
        let ((run_i, time_i), (run_j, time_j)) = (run_and_time(experiment, i), run_and_time(experiment, j));
        run_i.cmp(&run_j).then(time_i.total_cmp(&time_j))
    });
    order
}

/// Run of a point, and its time in units of time of the order: s, or its number where nothing is timed.
pub(crate) fn run_and_time(experiment: &Experiment, i: usize) -> (usize, f64) {
    let timed = experiment.scene.time_range_s.is_some();
    let time_s = experiment.points[i].state.time_s.filter(|_| timed);
    (experiment.run_of_point[i], time_s.unwrap_or(i as f64))
}
