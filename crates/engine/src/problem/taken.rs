//! How points were taken one after the other: passes, mountings, stops of the slow axis, times.
//!
//! A pass begins with another run or setup, where a pose of the present one comes back, and after a pause. This is the order of
//! things on the machine; [`crate::problem::passes`] groups by state (run × setup × directions × feed).

use crate::Experiment;
use crate::noise::learned::Real;
use crate::noise::machine_noise::Order;
use crate::problem::passes::passes;
use crate::problem::sequence::{clocks_and_times, in_order_taken};
use crate::solve::pairs::symmetric;
use nalgebra::DMatrix;
use std::collections::{HashMap, HashSet};
use trunnion_core::Joint;

/// A wait this many times longer than usual is a pause: somebody or something came between.
const PAUSE: f64 = 4.0;

/// Groups and times of each point, by its number in the experiment.
pub(crate) struct Taken {
    pub pass: Vec<usize>,
    /// Run × setup × directions.
    pub heading: Vec<usize>,
    pub visit: Vec<usize>,
    pub station: Vec<usize>,
    /// Position of the rotary axes.
    pub pose: Vec<usize>,
    /// The rotary axes that move least and most often.
    pub slow: Option<Joint>,
    pub fast: Option<Joint>,
    clock_and_time: Vec<(usize, f64)>,
    usual_step: f64,
    longest_run: f64,
}

impl Taken {
    pub fn new(experiment: &Experiment) -> Self {
        let points = experiment.points.len();
        let sequence = in_order_taken(experiment);
        let clock_and_time = clocks_and_times(experiment);
        let step = |pair: &[usize]| {
            let ((run, from), (next, to)) = (clock_and_time[pair[0]], clock_and_time[pair[1]]);
            (run == next).then_some(to - from)
        };
        let mut steps: Vec<f64> = sequence.windows(2).filter_map(step).collect();
        steps.sort_by(f64::total_cmp);
        let usual_step = steps.get(steps.len() / 2).copied().unwrap_or(1.0).max(1e-9);
        let order = Order::new(experiment);
        let stations = order.stations();
        let (mut pass, mut visit, mut station) = (vec![0; points], vec![0; points], vec![0; points]);
        let poses = experiment.poses();
        let mut seen = HashSet::new();
        for (k, &i) in sequence.iter().enumerate() {
            let key = poses[i];
            if k > 0 {
                let last = sequence[k - 1];
                let new_clock = clock_and_time[last].0 != clock_and_time[i].0;
                let setup = |i: usize| experiment.points[i].state.setup;
                let new_visit = new_clock || setup(last) != setup(i);
                let paused = clock_and_time[i].1 - clock_and_time[last].1 > PAUSE * usual_step;
                let new_pass = new_visit || paused || seen.contains(&key);
                visit[i] = visit[last] + usize::from(new_visit);
                pass[i] = pass[last] + usize::from(new_pass);
                station[i] = station[last] + usize::from(new_pass || stations[i] != stations[last]);
                if new_pass {
                    seen.clear();
                }
            }
            seen.insert(key);
        }
        let pose = experiment.stands(&experiment.machine().rotary_joints());
        let mut ends: HashMap<usize, (f64, f64)> = HashMap::new();
        for (run, time) in &clock_and_time {
            let end = ends.entry(*run).or_insert((*time, *time));
            *end = (end.0.min(*time), end.1.max(*time));
        }
        let longest_run = ends.values().fold(0.0, |most, (from, to)| f64::max(most, to - from));
        let heading = passes(experiment).pass;
        let (slow, fast) = (order.slow, order.fast);
        Self { pass, heading, visit, station, pose, slow, fast, clock_and_time, usual_step, longest_run }
    }

    /// Times at these shares of the way from `shortest` usual steps to the longest run, in logarithms.
    pub fn times<const N: usize>(&self, shares: [f64; N], shortest: f64) -> Vec<f64> {
        let (from, to) = (shortest * self.usual_step, self.longest_run);
        if to < 2.0 * from {
            return Vec::new();
        }
        shares.iter().map(|share| from * (to / from).powf(*share)).collect()
    }

    /// exp(−Δt/τ) within a run, 0 between runs.
    pub fn drift(&self, tau: f64) -> DMatrix<Real> {
        self.within_runs(|from, to| (-(from - to).abs() / tau).exp()).cast()
    }

    /// exp(−½ (Δt/τ)²) within a run, from the mean of the run: its offset is the mounting. Mean variance 1.
    pub fn smooth_drift(&self, tau: f64) -> DMatrix<Real> {
        self.off_mean_of_run(self.within_runs(|from, to| (-0.5 * ((from - to) / tau).powi(2)).exp()))
    }

    /// What drift that takes far longer than a run looks like: in proportion to time, from the mean of the run. Mean variance 1.
    pub fn trend(&self) -> DMatrix<Real> {
        let begin = self.clock_and_time.iter().map(|(_, time)| *time).fold(f64::INFINITY, f64::min);
        self.off_mean_of_run(self.within_runs(|from, to| (from - begin) * (to - begin)))
    }

    fn within_runs(&self, of_one_run: impl Fn(f64, f64) -> f64) -> DMatrix<f64> {
        let points = self.clock_and_time.len();
        symmetric(points, |i, j| {
            let ((run, from), (other, to)) = (self.clock_and_time[i], self.clock_and_time[j]);
            if run == other { of_one_run(from, to) } else { 0.0 }
        })
    }

    /// H K Hᵀ, H what takes the mean of its run from a point, brought to mean variance 1.
    fn off_mean_of_run(&self, mut pairs: DMatrix<f64>) -> DMatrix<Real> {
        let points = self.clock_and_time.len();
        for _ in 0..2 {
            for mut column in pairs.column_iter_mut() {
                let mut means: HashMap<usize, (f64, f64)> = HashMap::new();
                for (value, (run, _)) in column.iter().zip(&self.clock_and_time) {
                    let mean = means.entry(*run).or_default();
                    *mean = (mean.0 + value, mean.1 + 1.0);
                }
                for (value, (run, _)) in column.iter_mut().zip(&self.clock_and_time) {
                    *value -= means[run].0 / means[run].1;
                }
            }
            pairs.transpose_mut();
        }
        let mean_variance = pairs.trace() / points.max(1) as f64;
        if mean_variance > 0.0 { (pairs / mean_variance).cast() } else { DMatrix::zeros(points, points) }
    }
}
