//! Noise as real machines make it, and how to whiten it in one pass over time.
//!
//! Σ = σ² (I + a·K_pass + c·K_axis + w·K_drift)                                    [DIAGNOSIS §1]
//! - K_pass: the slow rotary axis is positioned anew with an angle of its own, constant until it moves again;
//! - K_axis: the fast rotary axis scatters at every point;
//! - K_drift: tool against table drifts in machine axes, Ornstein–Uhlenbeck with correlation time τ.
//!
//! Each kernel has mean variance 1 per reading, so a, c, w are variances in units of the white noise. A Kalman filter with
//! the state (drift x y z, angle of the slow axis) turns readings into independent innovations; its gains do not depend on the
//! data, so whitening is a linear operator W with W Σ Wᵀ = σ² I, applied to any number of columns in O(rows).

use crate::Experiment;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x4, Matrix4, Matrix4x3, Vector3};
use std::ops::Range;
use trunnion_instruments::Projector;
use trunnion_machine::{Machine, Side, Site};
use trunnion_units::{AxisLetter, Twist};

/// Travel below which an axis has not been positioned anew, rad.
const SAME_STATION_RAD: f64 = 1e-7;
/// Highest harmonic of the repeatable error motions that count as noise.
const MOTION_HARMONICS: usize = 4;

/// How much larger the correlated parts may be, beside the white noise, for blocks on the fly.
const BLOCK_TIMES: f64 = 8.0;

/// One member of the bank: variances relative to the white noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// a: re-positioning of the slow rotary axis.
    pub pass: f64,
    /// c: angular scatter of the fast rotary axis.
    pub axis: f64,
    /// w: drift.
    pub drift: f64,
    /// τ: correlation time of the drift, in units of time of the order of the points.
    pub tau: f64,
}

/// Points in the order they were taken, with what the noise needs to know of each.
#[derive(Clone, Debug)]
pub struct Order {
    pub(crate) visits: Vec<Visit>,
    /// Correlation time of drift that the bank assumes.
    pub tau: f64,
    /// The axis that moves least often, if the machine has rotary axes that move.
    pub slow: Option<AxisLetter>,
    /// The rotary axis that moves most often.
    pub fast: Option<AxisLetter>,
    /// True when points were read on the fly.
    pub on_the_fly: bool,
}

/// One point, as the noise sees it.
#[derive(Clone, Debug)]
pub(crate) struct Visit {
    pub point: usize,
    pub rows: Range<usize>,
    /// Since the point before of the same run, in units of time of the order; 0 at the start of a run.
    pub since_last: f64,
    pub new_run: bool,
    new_station: bool,
    /// Reading for a unit of drift along X, Y, Z.
    pub drift: Matrix3<f64>,
    pub slow_lever: Vector3<f64>,
    pub fast_lever: Vector3<f64>,
}

impl Order {
    /// Orders the points of an experiment by run and time; without time the order of the points is the time.
    pub fn new(experiment: &Experiment) -> Self {
        let time = |i: usize| experiment.points[i].state.time_s.unwrap_or(i as f64);
        let timed = experiment.scene.time_range_s.is_some();
        let key = |i: usize| (experiment.run_of_point[i], if timed { time(i) } else { i as f64 });
        let mut order: Vec<usize> = (0..experiment.points.len()).collect();
        order.sort_by(|&i, &j| {
            let ((run_i, time_i), (run_j, time_j)) = (key(i), key(j));
            run_i.cmp(&run_j).then(time_i.total_cmp(&time_j))
        });
        let (slow, fast) = slow_and_fast(experiment, &order);
        let mut visits = Vec::with_capacity(order.len());
        for (k, &i) in order.iter().enumerate() {
            let previous = (k > 0).then(|| order[k - 1]);
            visits.push(visit(experiment, i, previous, slow, fast, key));
        }
        normalise(&mut visits, |visit| &mut visit.slow_lever);
        normalise(&mut visits, |visit| &mut visit.fast_lever);
        let on_the_fly = experiment.scene.on_the_fly;
        let duration: f64 = visits.iter().filter(|v| !v.new_run).map(|v| v.since_last).sum();
        let runs = visits.iter().filter(|v| v.new_run).count().max(1);
        Self { visits, tau: (duration / runs as f64 / 4.0).max(1e-9), slow, fast, on_the_fly }
    }

    /// The same for rows multiplied by `root`, the roots of their weights: the white part stays 1, the others follow the rows.
    #[must_use]
    pub fn weighted(mut self, root: &DVector<f64>) -> Self {
        for visit in &mut self.visits {
            for (k, row) in visit.rows.clone().enumerate() {
                visit.drift.row_mut(k).scale_mut(root[row]);
                visit.slow_lever[k] *= root[row];
                visit.fast_lever[k] *= root[row];
            }
        }
        self
    }

    /// Points in the order they were taken.
    pub fn points(&self) -> impl Iterator<Item = usize> + '_ {
        self.visits.iter().map(|visit| visit.point)
    }

    /// Sequence number of the positioning of the slow axis at each point (indexed by point).
    pub fn stations(&self) -> Vec<usize> {
        let mut station_of_point = vec![0; self.visits.len()];
        let mut station = 0;
        for (k, visit) in self.visits.iter().enumerate() {
            station += usize::from(k > 0 && visit.new_station);
            station_of_point[visit.point] = station;
        }
        station_of_point
    }

    /// The bank over which evidence is averaged.
    pub fn bank(&self) -> Vec<Noise> {
        let seen = |lever: fn(&Visit) -> &Vector3<f64>| self.visits.iter().any(|v| lever(v).norm() > 0.0);
        // A block of many samples has hardly any white noise: what correlates is larger beside it.
        let times = if self.on_the_fly { BLOCK_TIMES } else { 1.0 };
        let passes: &[f64] = if seen(|v| &v.slow_lever) { &[0.0, 0.1, 0.4, 1.6] } else { &[0.0] };
        let axes: &[f64] = if seen(|v| &v.fast_lever) { &[0.0, 0.08] } else { &[0.0] };
        let mut bank = Vec::new();
        for &pass in passes {
            for &axis in axes {
                for drift in [0.0, 0.15, 0.5, 2.0] {
                    bank.push(Noise { pass: pass * times, axis, drift: drift * times, tau: self.tau });
                }
            }
        }
        bank
    }
}

/// The rotary axis that moves least often and the one that moves most often.
fn slow_and_fast(experiment: &Experiment, order: &[usize]) -> (Option<AxisLetter>, Option<AxisLetter>) {
    let moves = |letter: AxisLetter| {
        let at = |k: usize| experiment.points[order[k]].state.position[letter];
        (1..order.len()).filter(|&k| (at(k) - at(k - 1)).abs() > SAME_STATION_RAD).count()
    };
    let mut moving: Vec<(usize, AxisLetter)> =
        experiment.machine().rotary().iter().map(|axis| (moves(axis.letter), axis.letter)).collect();
    moving.retain(|(count, _)| *count > 0);
    moving.sort();
    let fast = moving.last().map(|(_, letter)| *letter);
    let slow = (moving.len() > 1).then(|| moving[0].1);
    (slow, fast)
}

fn visit(
    experiment: &Experiment,
    point: usize,
    previous: Option<usize>,
    slow: Option<AxisLetter>,
    fast: Option<AxisLetter>,
    key: impl Fn(usize) -> (usize, f64),
) -> Visit {
    let machine = experiment.machine();
    let state = &experiment.points[point].state;
    let projector = Projector::new(machine, &experiment.setups[state.setup], &state.position);
    let new_run = previous.is_none_or(|p| key(p).0 != key(point).0);
    let station_changed = |p: usize| {
        let before = &experiment.points[p].state;
        let turned = |letter: AxisLetter| {
            (before.position[letter] - state.position[letter]).abs() > SAME_STATION_RAD
                || before.direction[letter] * state.direction[letter] < 0.0
        };
        before.setup != state.setup || slow.is_some_and(turned)
    };
    let lever = |letter: Option<AxisLetter>| -> Vector3<f64> {
        let axis = letter.and_then(|l| machine.axis(l));
        axis.map_or_else(Vector3::zeros, |a| projector.column(Site::Joint(a.letter), &a.positioning_twist()))
    };
    let ground = ground_joint(machine);
    let drift = |k: usize| projector.column(ground, &Twist::translation(Vector3::ith(k, 1.0)));
    Visit {
        point,
        rows: experiment.rows_of(point),
        since_last: if new_run { 0.0 } else { previous.map_or(0.0, |p| key(point).1 - key(p).1) },
        new_run,
        new_station: new_run || previous.is_none_or(station_changed),
        drift: Matrix3::from_columns(&[drift(0), drift(1), drift(2)]),
        slow_lever: lever(slow),
        fast_lever: lever(fast),
    }
}

/// A joint whose carrier is the bed: a translation there is one in machine axes.
pub fn ground_joint(machine: &Machine) -> Site {
    let first = |side| machine.from_bed(side).first().map(|axis| Site::Joint(axis.letter));
    first(Side::Tool).or(first(Side::Table)).unwrap_or(Site::SpindleBall)
}

/// Scales levers to a mean square of 1 per reading.
fn normalise(visits: &mut [Visit], lever: impl Fn(&mut Visit) -> &mut Vector3<f64>) {
    let (mut sum, mut count) = (0.0, 0);
    for visit in visits.iter_mut() {
        count += visit.rows.len();
        sum += lever(visit).norm_squared();
    }
    let mean_square: f64 = sum / count.max(1) as f64;
    let scale = if mean_square > 1e-12 { 1.0 / mean_square.sqrt() } else { 0.0 };
    for visit in visits.iter_mut() {
        *lever(visit) *= scale;
    }
}

/// Random columns of the small repeatable error motions that every rotary axis has: its first harmonics in its six components,
/// rows as the readings, together of variance 1 per reading; column × row.
pub fn repeatable_motions(experiment: &Experiment) -> DMatrix<f64> {
    let mut columns = Vec::new();
    for axis in experiment.machine().rotary() {
        let (low, high) = experiment.scene.position_range[axis.letter];
        if high - low < 1e-6 {
            continue;
        }
        for k in 0..6 {
            let carrier = unit_columns(experiment, Site::Joint(axis.letter), k);
            for harmonic in 1..=MOTION_HARMONICS {
                for phase in [0.0, std::f64::consts::FRAC_PI_2] {
                    let factor = |letter: AxisLetter, i: usize| {
                        (harmonic as f64 * experiment.points[i].state.position[letter] - phase).cos()
                    };
                    columns.push(modulated(experiment, &carrier, |i| factor(axis.letter, i)));
                }
            }
        }
    }
    let mut all = DMatrix::zeros(columns.len(), experiment.rows());
    let size = (experiment.rows() as f64 / columns.len().max(1) as f64).sqrt();
    for (j, column) in columns.iter().enumerate() {
        let norm = column.norm();
        if norm > 1e-12 {
            all.row_mut(j).tr_copy_from(&(column * (size / norm)));
        }
    }
    all
}

/// Harmonic of row `j` of [`repeatable_motions`].
pub(crate) fn motion_harmonic(j: usize) -> usize {
    j / 2 % MOTION_HARMONICS + 1
}

/// Reading for a unit of one component (dx dy dz ea eb ec) at a site.
pub fn unit_columns(experiment: &Experiment, site: Site, component: usize) -> DVector<f64> {
    let unit = Vector3::ith(component % 3, 1.0);
    let twist = if component < 3 { Twist::translation(unit) } else { Twist::rotation(unit) };
    let mut column = DVector::zeros(experiment.rows());
    for (i, point) in experiment.points.iter().enumerate() {
        let setup = &experiment.setups[point.state.setup];
        let seen = Projector::new(experiment.machine(), setup, &point.state.position).column(site, &twist);
        for (k, row) in experiment.rows_of(i).enumerate() {
            column[row] = seen[k];
        }
    }
    column
}

/// A column multiplied by a factor of the point.
pub fn modulated(
    experiment: &Experiment,
    carrier: &DVector<f64>,
    factor: impl Fn(usize) -> f64,
) -> DVector<f64> {
    let mut column = carrier.clone();
    for i in 0..experiment.points.len() {
        let value = factor(i);
        for row in experiment.rows_of(i) {
            column[row] *= value;
        }
    }
    column
}

/// The operator W of one noise model.
#[derive(Clone, Debug)]
pub struct Whitener {
    steps: Vec<Step>,
    /// ln det Σ/σ².
    pub log_det: f64,
}

#[derive(Clone, Debug)]
struct Step {
    rows: Range<usize>,
    /// Factor on the drift state from the last visit to this one.
    keep_drift: f64,
    /// 0 when the slow axis was positioned anew, else 1.
    keep_slow: f64,
    observe: Matrix3x4<f64>,
    gain: Matrix4x3<f64>,
    inverse_cholesky: Matrix3<f64>,
}

impl Whitener {
    /// Runs the covariance recursion once; the gains hold for all data.
    pub fn new(order: &Order, noise: &Noise) -> Self {
        let mut covariance = Matrix4::zeros();
        let (mut steps, mut log_det) = (Vec::with_capacity(order.visits.len()), 0.0);
        for visit in &order.visits {
            let keep_drift = if visit.new_run { 0.0 } else { (-visit.since_last / noise.tau).exp() };
            let keep_slow = if visit.new_station { 0.0 } else { 1.0 };
            let keep = Matrix4::from_diagonal(&[keep_drift, keep_drift, keep_drift, keep_slow].into());
            covariance = keep * covariance * keep;
            for k in 0..3 {
                covariance[(k, k)] += noise.drift * (1.0 - keep_drift * keep_drift);
            }
            covariance[(3, 3)] += noise.pass * (1.0 - keep_slow);
            let mut observe = Matrix3x4::zeros();
            observe.fixed_columns_mut::<3>(0).copy_from(&visit.drift);
            observe.set_column(3, &visit.slow_lever);
            let scatter = visit.fast_lever * visit.fast_lever.transpose() * noise.axis;
            let innovation: Matrix3<f64> =
                observe * covariance * observe.transpose() + Matrix3::identity() + scatter;
            let cholesky = innovation.cholesky().expect("identity plus covariances is positive definite");
            let inverse_cholesky =
                cholesky.l().try_inverse().expect("a Cholesky factor has a positive diagonal");
            let gain = covariance * observe.transpose() * cholesky.inverse();
            covariance -= gain * observe * covariance;
            covariance = (covariance + covariance.transpose()) * 0.5;
            // A ball bar's two unused components see nothing and have variance 1: they add ln 1.
            log_det += 2.0 * (0..3).map(|k| cholesky.l_dirty()[(k, k)].ln()).sum::<f64>();
            let rows = visit.rows.clone();
            steps.push(Step { rows, keep_drift, keep_slow, observe, gain, inverse_cholesky });
        }
        Self { steps, log_det }
    }

    /// Whitens, in place, the columns of a design held transposed (column × row).
    pub fn whiten(&self, transposed: &mut DMatrix<f64>) {
        let width = transposed.nrows();
        let mut state = vec![0.0; 4 * width];
        for step in &self.steps {
            let data = &mut transposed.as_mut_slice()[step.rows.start * width..step.rows.end * width];
            match step.rows.len() {
                3 => step.filter3(data, &mut state, width),
                _ => step.filter1(data, &mut state, width),
            }
        }
    }

    /// Wᵀ applied to whitened vectors held transposed (vector × row), in place.
    pub fn adjoint(&self, transposed: &mut DMatrix<f64>) {
        for j in 0..transposed.nrows() {
            let mut state = nalgebra::Vector4::zeros();
            for step in self.steps.iter().rev() {
                let mut whitened = Vector3::zeros();
                for (k, row) in step.rows.clone().enumerate() {
                    whitened[k] = transposed[(j, row)];
                }
                let reading = step.inverse_cholesky.transpose() * whitened + step.gain.transpose() * state;
                for (k, row) in step.rows.clone().enumerate() {
                    transposed[(j, row)] = reading[k];
                }
                state -= step.observe.transpose() * reading;
                for k in 0..3 {
                    state[k] *= step.keep_drift;
                }
                state[3] *= step.keep_slow;
            }
        }
    }
}

impl Step {
    fn filter3(&self, data: &mut [f64], state: &mut [f64], width: usize) {
        let (g, k, l) = (&self.observe, &self.gain, &self.inverse_cholesky);
        let (r0, rest) = data.split_at_mut(width);
        let (r1, r2) = rest.split_at_mut(width);
        let (z0, rest) = state.split_at_mut(width);
        let (z1, rest) = rest.split_at_mut(width);
        let (z2, z3) = rest.split_at_mut(width);
        let r2 = &mut r2[..width];
        let z3 = &mut z3[..width];
        for j in 0..width {
            let x0 = z0[j] * self.keep_drift;
            let x1 = z1[j] * self.keep_drift;
            let x2 = z2[j] * self.keep_drift;
            let x3 = z3[j] * self.keep_slow;
            let v0 = r0[j] - (g[(0, 0)] * x0 + g[(0, 1)] * x1 + g[(0, 2)] * x2 + g[(0, 3)] * x3);
            let v1 = r1[j] - (g[(1, 0)] * x0 + g[(1, 1)] * x1 + g[(1, 2)] * x2 + g[(1, 3)] * x3);
            let v2 = r2[j] - (g[(2, 0)] * x0 + g[(2, 1)] * x1 + g[(2, 2)] * x2 + g[(2, 3)] * x3);
            z0[j] = x0 + k[(0, 0)] * v0 + k[(0, 1)] * v1 + k[(0, 2)] * v2;
            z1[j] = x1 + k[(1, 0)] * v0 + k[(1, 1)] * v1 + k[(1, 2)] * v2;
            z2[j] = x2 + k[(2, 0)] * v0 + k[(2, 1)] * v1 + k[(2, 2)] * v2;
            z3[j] = x3 + k[(3, 0)] * v0 + k[(3, 1)] * v1 + k[(3, 2)] * v2;
            r0[j] = l[(0, 0)] * v0;
            r1[j] = l[(1, 0)] * v0 + l[(1, 1)] * v1;
            r2[j] = l[(2, 0)] * v0 + l[(2, 1)] * v1 + l[(2, 2)] * v2;
        }
    }

    fn filter1(&self, data: &mut [f64], state: &mut [f64], width: usize) {
        let keep = [self.keep_drift, self.keep_drift, self.keep_drift, self.keep_slow];
        for j in 0..width {
            let mut innovation = data[j];
            for s in 0..4 {
                state[s * width + j] *= keep[s];
                innovation -= self.observe[(0, s)] * state[s * width + j];
            }
            for s in 0..4 {
                state[s * width + j] += self.gain[(s, 0)] * innovation;
            }
            data[j] = self.inverse_cholesky[(0, 0)] * innovation;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_machine::{State, shipped};
    use trunnion_measurement::{InstrumentKind, NestSide, Point, Quality, Run, RunKind, Setup};
    use trunnion_units::AxisValues;

    fn small_run() -> Experiment {
        let machine = shipped::machine("table-bc").unwrap();
        let setup = Setup {
            name: "low".into(),
            instrument: InstrumentKind::RTest,
            nest: NestSide::Table,
            ball_in_table_mm: nalgebra::Point3::new(150.0, 0.0, 60.0),
            bar_length_mm: None,
        };
        let mut points = Vec::new();
        for (i, (b, c)) in
            [(0.0, 0.1), (0.0, 0.9), (0.7, 0.9), (0.7, 2.0), (0.7, 3.0), (-0.4, 1.0)].into_iter().enumerate()
        {
            let mut position = AxisValues::default();
            position[AxisLetter::B] = b;
            position[AxisLetter::C] = c;
            let time_s = Some(4.0 * i as f64 + if i > 3 { 30.0 } else { 0.0 });
            points.push(Point {
                state: State { position, time_s, ..State::default() },
                reading_mm: [0.0; 3],
                spread_mm: [0.0; 3],
                samples: 0,
                quality: Quality::Good,
            });
        }
        let run = Run {
            name: "small".into(),
            machine,
            kind: RunKind::Static,
            setups: vec![setup],
            channels: vec![],
            points,
        };
        Experiment::new(&[run]).unwrap()
    }

    /// Σ written out element by element from its definition.
    fn dense(order: &Order, noise: &Noise) -> DMatrix<f64> {
        let rows = order.visits.iter().map(|v| v.rows.len()).sum();
        let mut sigma = DMatrix::identity(rows, rows);
        let (mut times, mut stations, mut time, mut station) = (vec![], vec![], 0.0, 0);
        for (k, visit) in order.visits.iter().enumerate() {
            time += visit.since_last;
            station += usize::from(k > 0 && visit.new_station);
            times.push(time);
            stations.push(station);
        }
        for (i, a) in order.visits.iter().enumerate() {
            for (j, b) in order.visits.iter().enumerate() {
                let correlation = (-(times[i] - times[j]).abs() / noise.tau).exp();
                let mut block = a.drift * b.drift.transpose() * noise.drift * correlation;
                if stations[i] == stations[j] {
                    block += a.slow_lever * b.slow_lever.transpose() * noise.pass;
                }
                if i == j {
                    block += a.fast_lever * a.fast_lever.transpose() * noise.axis;
                }
                let mut target = sigma.view_mut((a.rows.start, b.rows.start), (3, 3));
                target += block;
            }
        }
        sigma
    }

    #[test]
    fn whitened_covariance_is_the_identity_and_the_determinant_is_that_of_the_dense_matrix() {
        let experiment = small_run();
        let order = Order::new(&experiment);
        let noise = Noise { pass: 0.7, axis: 0.3, drift: 1.5, tau: 20.0 };
        let sigma = dense(&order, &noise);
        let whitener = Whitener::new(&order, &noise);
        let rows = sigma.nrows();
        let mut operator = DMatrix::identity(rows, rows);
        whitener.whiten(&mut operator);
        let w = operator.transpose();
        let difference = &w * &sigma * w.transpose() - DMatrix::identity(rows, rows);
        assert!(difference.amax() < 1e-10, "{}", difference.amax());
        let log_det = 2.0 * sigma.cholesky().unwrap().l().diagonal().map(f64::ln).sum();
        assert!((log_det - whitener.log_det).abs() < 1e-9);
        let mut adjoint = DMatrix::identity(rows, rows);
        whitener.adjoint(&mut adjoint);
        assert!((adjoint - w).amax() < 1e-12);
    }
}
