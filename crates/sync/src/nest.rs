//! The nest of the R-test: from three probe readings to the displacement of the ball.
//! p_k = g_k·(d_k · s) + c_k                                                             [S1 §3.2]
//! p_k reading of probe k, mm; s displacement of the ball in nest axes, mm; d_k unit direction, g_k gain, c_k reading
//! at s = 0. Known steps of the linear axes give g_k·d_k by least squares, for each probe alone. Valid while the
//! positioning error of the linear axes over the steps is small against what shall be measured.
//! Ball off the spindle line: s(θ) = s₀ + R_z(θ)·e, a circle over spindle angles θ       [S1 §3.2]

use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};
use trunnion_core::input::Table;

/// Largest norm of the inverse of the probe directions: beyond it a nest magnifies noise too much.
const FLATTEST_NEST: f64 = 50.0;

/// Turns probe readings into nest coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NestCalibration {
    /// Displacement of the ball in nest axes from probe readings.
    pub nest_from_probes: Matrix3<f64>,
    /// Displacement at the zero of the cycle, nest axes, mm; taken off every reading.
    pub zero_mm: Vector3<f64>,
}

impl NestCalibration {
    /// Three probes along the nest axes; also the ball bar, whose one channel comes first.
    pub fn orthogonal() -> Self {
        Self { nest_from_probes: Matrix3::identity(), zero_mm: Vector3::zeros() }
    }

    /// Directions in which the probes read positive, nest axes; the table `[nest]` of a configuration (S1 §3.2).
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let directions = ["probe_1", "probe_2", "probe_3"].map(|key| table.vector3(key));
        table.no_other_keys();
        let [Some(first), Some(second), Some(third)] = directions else { return None };
        let probes_from_nest =
            Matrix3::from_rows(&[first.transpose(), second.transpose(), third.transpose()]);
        let nest_from_probes =
            probes_from_nest.try_inverse().filter(|inverse| inverse.norm() < FLATTEST_NEST);
        if nest_from_probes.is_none() {
            let found = "and the others lie nearly in one plane";
            table.problem("probe_1", found, "three directions that span space", "Calibrate the nest again.");
        }
        Some(Self { nest_from_probes: nest_from_probes?, zero_mm: Vector3::zeros() })
    }

    /// The reading of these probes in nest axes, mm, minus its value at zero. NaN in, NaN out.
    pub fn reading_mm(&self, probes_mm: [f64; 3]) -> Vector3<f64> {
        self.nest_from_probes * Vector3::from(probes_mm) - self.zero_mm
    }

    /// The same calibration with zero where the probes read `probes_mm`.
    pub fn zeroed_at(self, probes_mm: [f64; 3]) -> Self {
        Self { zero_mm: self.nest_from_probes * Vector3::from(probes_mm), ..self }
    }
}

/// A known step and what the probes read there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NestStep {
    /// Displacement of the ball in nest axes, mm.
    pub ball_in_nest_mm: Vector3<f64>,
    /// Readings of the probes, mm.
    pub probes_mm: [f64; 3],
}

/// Result of [`calibrate`].
#[derive(Clone, Debug, PartialEq)]
pub struct NestFit {
    /// To be used for measuring; zero where all steps are zero.
    pub calibration: NestCalibration,
    /// Unit directions of the probes in nest axes.
    pub directions: [Vector3<f64>; 3],
    /// Gains of the probes.
    pub gains: [f64; 3],
    /// Root mean square of the residual of each probe, mm.
    pub residual_rms_mm: [f64; 3],
    /// How much an error of the probes grows in nest axes: the condition of the three directions.
    pub condition: f64,
}

/// Why steps give no calibration.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NestError {
    /// Not enough steps.
    #[error(
        "{0} steps with finite readings; at least 4 are needed, better 12 and both ways along X, Y and Z"
    )]
    TooFew(usize),
    /// Steps do not span space.
    #[error("the steps do not span all three directions; step X, Y and Z each by 0.1 mm or more")]
    Flat,
    /// Probes do not span space.
    #[error(
        "the probes look along nearly one plane (condition {0:.0}, allowed up to 50); check their mounting"
    )]
    Degenerate(f64),
}

/// Largest condition of a usable nest.
const MAX_CONDITION: f64 = 50.0;

/// Directions and gains of the probes from known steps. Steps with a NaN reading are left out.
///
/// # Errors
/// Too few steps, steps in a plane, probes in a plane.
pub fn calibrate(steps: &[NestStep]) -> Result<NestFit, NestError> {
    let steps: Vec<_> = steps.iter().filter(|step| step.probes_mm.iter().all(|p| p.is_finite())).collect();
    if steps.len() < 4 {
        return Err(NestError::TooFew(steps.len()));
    }
    let n = steps.len();
    let mean_step = steps.iter().map(|step| step.ball_in_nest_mm).sum::<Vector3<f64>>() / n as f64;
    let design = DMatrix::from_fn(n, 3, |row, column| (steps[row].ball_in_nest_mm - mean_step)[column]);
    let svd = design.clone().svd(true, true);
    if svd.singular_values[2] < 1e-3 * svd.singular_values[0].max(1e-9) {
        return Err(NestError::Flat);
    }
    let mut probes_from_nest = Matrix3::zeros();
    let (mut offsets, mut residual_rms_mm) = (Vector3::zeros(), [0.0; 3]);
    for k in 0..3 {
        let mean_reading = steps.iter().map(|step| step.probes_mm[k]).sum::<f64>() / n as f64;
        let readings = DVector::from_fn(n, |row, _| steps[row].probes_mm[k] - mean_reading);
        let gain_direction = svd.solve(&readings, 0.0).expect("both factors of the SVD were asked for");
        let residual = &readings - &design * &gain_direction;
        residual_rms_mm[k] = residual.norm() / (n as f64).sqrt();
        probes_from_nest.set_row(k, &gain_direction.transpose());
        offsets[k] = mean_reading - (gain_direction.transpose() * mean_step)[0];
    }
    let singular = probes_from_nest.singular_values();
    let condition = singular[0] / singular[2];
    let inverse = probes_from_nest.try_inverse().filter(|_| condition <= MAX_CONDITION);
    let nest_from_probes = inverse.ok_or(NestError::Degenerate(condition))?;
    let row = |k: usize| probes_from_nest.row(k).transpose();
    Ok(NestFit {
        calibration: NestCalibration { nest_from_probes, zero_mm: nest_from_probes * offsets },
        directions: [0, 1, 2].map(|k| row(k).normalize()),
        gains: [0, 1, 2].map(|k| row(k).norm()),
        residual_rms_mm,
        condition,
    })
}

/// Result of [`ball_offset`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallOffset {
    /// Ball centre off the spindle line at spindle angle 0, along nest x and y, mm.
    pub offset_mm: Vector2<f64>,
    /// Reading of the spindle line itself, mm: what the offset must be taken off from.
    pub centre_mm: Vector2<f64>,
    /// Root mean square of the residual, mm: roundness of spindle and ball.
    pub residual_rms_mm: f64,
}

/// Centre shift of the ball from readings at indexed spindle angles (rad, reading in nest axes, mm); the spindle is
/// parallel to nest z and turns right-handed about it. `None` when the angles do not separate offset from centre.
pub fn ball_offset(readings: &[(f64, Vector3<f64>)]) -> Option<BallOffset> {
    let readings: Vec<_> = readings.iter().filter(|(_, s)| s.x.is_finite() && s.y.is_finite()).collect();
    let n = readings.len();
    // x = cx + ex·cosθ − ey·sinθ ; y = cy + ex·sinθ + ey·cosθ
    let design = DMatrix::from_fn(2 * n, 4, |row, column| {
        let (sin, cos) = readings[row / 2].0.sin_cos();
        [[1.0, 0.0, cos, -sin], [0.0, 1.0, sin, cos]][row % 2][column]
    });
    let observed = DVector::from_fn(2 * n, |row, _| readings[row / 2].1[row % 2]);
    if n < 2 {
        return None;
    }
    let svd = design.clone().svd(true, true);
    if svd.singular_values[3] < 0.05 * svd.singular_values[0] {
        return None;
    }
    let found = svd.solve(&observed, 0.0).ok()?;
    let residual = observed - design * &found;
    Some(BallOffset {
        offset_mm: Vector2::new(found[2], found[3]),
        centre_mm: Vector2::new(found[0], found[1]),
        residual_rms_mm: residual.norm() / ((2 * n) as f64).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Probes at 120° around z, inclined to the cube's diagonal, with gains off by up to 2 %.
    fn nest() -> ([Vector3<f64>; 3], [f64; 3], [f64; 3]) {
        let inclination = (1.0f64 / 3.0).sqrt().asin();
        let direction = |k: usize| {
            let azimuth = k as f64 * std::f64::consts::TAU / 3.0 + 0.1;
            let (sin, cos) = azimuth.sin_cos();
            Vector3::new(cos * inclination.cos(), sin * inclination.cos(), -inclination.sin())
        };
        ([0, 1, 2].map(direction), [1.02, 0.98, 1.005], [5.0, 4.7, 5.2])
    }

    fn probes(ball: Vector3<f64>) -> [f64; 3] {
        let (directions, gains, offsets) = nest();
        [0, 1, 2].map(|k| gains[k] * directions[k].dot(&ball) + offsets[k])
    }

    fn steps(noise_mm: f64) -> Vec<NestStep> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut steps = Vec::new();
        for axis in 0..3 {
            for step in [-0.2, -0.1, 0.1, 0.2] {
                let mut ball = Vector3::zeros();
                ball[axis] = step;
                let probes_mm = probes(ball).map(|p| p + noise_mm * (2.0 * rng.random::<f64>() - 1.0));
                steps.push(NestStep { ball_in_nest_mm: ball, probes_mm });
            }
        }
        steps
    }

    #[test]
    fn directions_gains_and_zero_come_back_from_known_steps() {
        let fit = calibrate(&steps(0.0)).unwrap();
        let (directions, gains, _) = nest();
        for k in 0..3 {
            assert!((fit.directions[k] - directions[k]).norm() < 1e-12);
            assert!((fit.gains[k] - gains[k]).abs() < 1e-12);
        }
        let ball = Vector3::new(0.031, -0.017, 0.008);
        assert!((fit.calibration.reading_mm(probes(ball)) - ball).norm() < 1e-12);
        let there = fit.calibration.zeroed_at(probes(ball));
        assert!((there.reading_mm(probes(2.0 * ball)) - ball).norm() < 1e-12);
    }

    #[test]
    fn noise_of_the_steps_shows_in_the_residual_and_stays_small_in_the_reading() {
        let fit = calibrate(&steps(0.5e-3)).unwrap();
        for rms in fit.residual_rms_mm {
            assert!((0.05e-3..0.5e-3).contains(&rms), "{rms}");
        }
        let ball = Vector3::new(0.05, 0.05, -0.05);
        assert!((fit.calibration.reading_mm(probes(ball)) - ball).norm() < 1.0e-3);
    }

    #[test]
    fn steps_or_probes_in_a_plane_are_refused() {
        let mut flat = steps(0.0);
        flat.truncate(8);
        assert_eq!(calibrate(&flat), Err(NestError::Flat));
        assert_eq!(calibrate(&flat[..3]), Err(NestError::TooFew(3)));
        let copied: Vec<_> = steps(0.0)
            .into_iter()
            .map(|step| NestStep {
                probes_mm: [step.probes_mm[0], step.probes_mm[1], step.probes_mm[1]],
                ..step
            })
            .collect();
        assert!(matches!(calibrate(&copied), Err(NestError::Degenerate(_))));
    }

    #[test]
    fn indexing_the_spindle_finds_the_ball_off_its_line() {
        let (offset, centre) = (Vector2::new(0.012, -0.007), Vector2::new(0.1, 0.2));
        let at = |deg: f64| {
            let (sin, cos) = deg.to_radians().sin_cos();
            let turned = Vector2::new(cos * offset.x - sin * offset.y, sin * offset.x + cos * offset.y);
            (deg.to_radians(), Vector3::new(centre.x + turned.x, centre.y + turned.y, 0.3))
        };
        let found = ball_offset(&[0.0, 90.0, 180.0, 270.0].map(at)).unwrap();
        assert!((found.offset_mm - offset).norm() < 1e-12 && (found.centre_mm - centre).norm() < 1e-12);
        assert!(found.residual_rms_mm < 1e-12);
        assert_eq!(ball_offset(&[0.0, 0.5, 1.0].map(at)), None);
    }
}
