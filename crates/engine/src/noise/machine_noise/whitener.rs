//! Whitening in one pass over time: a Kalman filter whose gains do not depend on the data.

use super::order::{Noise, Order};
use nalgebra::{DMatrix, Matrix3, Matrix3x4, Matrix4, Matrix4x3};
use std::ops::Range;

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
    /// 0 when the slow axis was positioned again, else 1.
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
    use crate::Experiment;
    use trunnion_core::{AxisValues, InstrumentKind, Joint, NestSide, Point, Quality, Setup, State};
    use trunnion_cycles::{Run, RunKind};
    use trunnion_machine::shipped;

    fn small_run() -> Experiment {
        let machine = shipped::machine("table-bc").unwrap();
        let setup = Setup::new(
            "low",
            InstrumentKind::RTest,
            NestSide::Table,
            nalgebra::Point3::new(150.0, 0.0, 60.0),
        );
        let mut points = Vec::new();
        for (i, (b, c)) in
            [(0.0, 0.1), (0.0, 0.9), (0.7, 0.9), (0.7, 2.0), (0.7, 3.0), (-0.4, 1.0)].into_iter().enumerate()
        {
            let mut position = AxisValues::default();
            position[Joint::B] = b;
            position[Joint::C] = c;
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
    }
}
