//! The nest of the R-test: from three probe readings to the displacement of the ball.
//! p_k = g_k·(d_k · s) + c_k                                                             [S1 §3.2]
//! p_k reading of probe k, mm; s displacement of the ball in nest axes, mm; d_k unit direction, g_k gain, c_k reading
//! at s = 0. Known steps of the linear axes give g_k·d_k by least squares, for each probe alone. Valid while the
//! positioning error of the linear axes over the steps is small against what shall be measured.
//! u² of a direction: σ²·½·tr(P (XᵀX)⁻¹ P)/g² + a², P across the direction; of a gain σ²·dᵀ(XᵀX)⁻¹d; σ² = |r|²/(n − 4)  [GUM 5.1.2]
//! a: the steps show directions in the axes of the travel; what carries the nest is turned against these by the location errors of the
//! rotary axes between, which nobody has measured yet. A turn of all three probes together leaves no residual.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
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
        let nest = Self::along([first, second, third].map(Into::into));
        if nest.is_none() {
            let found = "and the others lie nearly in one plane";
            table.problem("probe_1", found, "three directions that span space", "Calibrate the nest again.");
        }
        nest
    }

    /// The same from the directions; `None` where they lie nearly in one plane.
    pub fn along(directions: [[f64; 3]; 3]) -> Option<Self> {
        let [first, second, third] = directions.map(Vector3::from);
        let probes_from_nest =
            Matrix3::from_rows(&[first.transpose(), second.transpose(), third.transpose()]);
        let nest_from_probes =
            probes_from_nest.try_inverse().filter(|inverse| inverse.norm() < FLATTEST_NEST)?;
        Some(Self { nest_from_probes, zero_mm: Vector3::zeros() })
    }

    /// The reading of these probes in nest axes, mm, minus its value at zero. NaN in, NaN out.
    pub fn reading_mm(&self, probes_mm: [f64; 3]) -> Vector3<f64> {
        self.nest_from_probes * Vector3::from(probes_mm) - self.zero_mm
    }
}

/// A ball commanded so far from the nest is a calibration step, mm; further out no probe reaches.
pub const STEP_MM: std::ops::RangeInclusive<f64> = 0.02..=5.0;

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
    /// Standard uncertainty of each direction, rad about an axis across it; NaN without a step more than is needed.
    pub u_direction_rad: [f64; 3],
    /// Standard uncertainty of each gain.
    pub u_gain: [f64; 3],
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
    /// The readings changed with time.
    #[error(
        "probe {probe} drifted by {drift_um:.1} µm over the steps (u of its direction {u_mrad:.1} mrad, allowed {:.0}); let machine \
         and probes warm up, then repeat the steps",
        1e3 * LARGEST_U_RAD
    )]
    Drift {
        /// Number of the probe, from 1.
        probe: usize,
        /// How far, µm.
        drift_um: f64,
        /// Uncertainty of its direction, mrad.
        u_mrad: f64,
    },
    /// The readings scatter too much for steps of this size.
    #[error(
        "u of the direction of probe {probe} is {u_mrad:.1} mrad (allowed {:.0}): its readings scatter by {rms_um:.1} µm about \
         steps of {step_mm:.3} mm; take larger or more steps, and check that ball and probes are clamped",
        1e3 * LARGEST_U_RAD
    )]
    Uncertain {
        /// Number of the probe, from 1.
        probe: usize,
        /// Uncertainty of its direction, mrad.
        u_mrad: f64,
        /// Residual of the probe, µm rms.
        rms_um: f64,
        /// Root mean square of the steps in the direction with the smallest, mm.
        step_mm: f64,
    },
}

/// a above, rad: the typical location error of an axis [docs/design/catalogue.md, location-errors: 50 µrad] of two rotary axes.
const AXES_RAD: f64 = std::f64::consts::SQRT_2 * 50e-6;
/// Direction and gain of a probe, and its reading at zero.
const UNKNOWNS: usize = 4;
/// A ball 0.1 mm off, as far as it is set by hand, is then read 0.5 µm wrong across: about the resolution of an R-test.
const LARGEST_U_RAD: f64 = 5e-3;
/// The steps drifted when a straight line over time takes so much of the mean square of the residual that this share is left: half of it.
const BY_DRIFT: f64 = 0.5;
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
    let (mut u_direction_rad, mut u_gain) = ([f64::NAN; 3], [f64::NAN; 3]);
    let cofactor = (design.transpose() * &design).try_inverse().ok_or(NestError::Flat)?;
    let cofactor = Matrix3::from_fn(|i, j| cofactor[(i, j)]);
    for k in 0..3 {
        let mean_reading = steps.iter().map(|step| step.probes_mm[k]).sum::<f64>() / n as f64;
        let readings = DVector::from_fn(n, |row, _| steps[row].probes_mm[k] - mean_reading);
        let gain_direction = svd.solve(&readings, 0.0).expect("both factors of the SVD were asked for");
        let residual = &readings - &design * &gain_direction;
        residual_rms_mm[k] = residual.norm() / (n as f64).sqrt();
        if n > UNKNOWNS {
            let sigma = residual.norm() / ((n - UNKNOWNS) as f64).sqrt();
            let g = gain_direction.norm();
            let d = Vector3::new(gain_direction[0], gain_direction[1], gain_direction[2]) / g;
            let across = Matrix3::identity() - d * d.transpose();
            let by_scatter = sigma * (0.5 * (across * cofactor * across).trace()).sqrt() / g;
            u_direction_rad[k] = by_scatter.hypot(AXES_RAD);
            u_gain[k] = sigma * (d.transpose() * cofactor * d)[0].sqrt();
        }
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
        u_direction_rad,
        u_gain,
        condition,
    })
}

/// The same from steps with their times, s, for measuring: refused with the reason where the directions are too uncertain.
///
/// # Errors
/// As [`calibrate`]; readings that drift or scatter.
pub fn calibrate_well(steps: &[NestStep], times_s: &[f64]) -> Result<NestFit, NestError> {
    let has_reading = |(step, _): &(&NestStep, &f64)| step.probes_mm.iter().all(|p| p.is_finite());
    let (steps, times_s): (Vec<NestStep>, Vec<f64>) = steps.iter().zip(times_s).filter(has_reading).unzip();
    if steps.len() <= UNKNOWNS {
        return Err(NestError::TooFew(steps.len()));
    }
    let fit = calibrate(&steps)?;
    let worst = |a: &usize, b: &usize| fit.u_direction_rad[*a].total_cmp(&fit.u_direction_rad[*b]);
    let k = (0..3).max_by(worst).expect("there are three probes");
    if fit.u_direction_rad[k] <= LARGEST_U_RAD {
        return Ok(fit);
    }
    let (probe, u_mrad) = (k + 1, 1e3 * fit.u_direction_rad[k]);
    let n = steps.len() as f64;
    let mean = steps.iter().map(|step| step.ball_in_nest_mm).sum::<Vector3<f64>>() / n;
    let mean_s = times_s.iter().sum::<f64>() / n;
    let span_s = times_s.iter().fold(0.0, |span: f64, time_s| span.max((time_s - mean_s).abs()));
    let design = DMatrix::from_fn(steps.len(), 5, |row, column| match column {
        0 => 1.0,
        4 => (times_s[row] - mean_s) / span_s.max(f64::MIN_POSITIVE),
        axis => (steps[row].ball_in_nest_mm - mean)[axis - 1],
    });
    let readings = DVector::from_fn(steps.len(), |row, _| steps[row].probes_mm[k]);
    let with_time = design.clone().svd(true, true).solve(&readings, 1e-12).ok();
    if let Some(with_time) = with_time {
        let left = (&readings - &design * &with_time).norm_squared() / n;
        if left < BY_DRIFT * fit.residual_rms_mm[k].powi(2) {
            return Err(NestError::Drift { probe, drift_um: 2e3 * with_time[4].abs(), u_mrad });
        }
    }
    let smallest = design.columns(1, 3).svd(false, false).singular_values[2] / n.sqrt();
    Err(NestError::Uncertain { probe, u_mrad, rms_um: 1e3 * fit.residual_rms_mm[k], step_mm: smallest })
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
    fn the_stated_u_is_the_scatter_of_many_calibrations() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let (directions, ..) = nest();
        let (mut squares, mut stated, trials) = (0.0, 0.0, 400);
        for _ in 0..trials {
            let mut noisy = steps(0.0);
            let mut noise = || 1e-3 * (0..12).map(|_| rng.random::<f64>() - 0.5).sum::<f64>();
            noisy.iter_mut().for_each(|step| step.probes_mm = step.probes_mm.map(|p| p + noise()));
            let fit = calibrate(&noisy).unwrap();
            // Both angles across the direction.
            squares += 0.5 * (fit.directions[0] - directions[0]).norm_squared();
            stated += fit.u_direction_rad[0].powi(2);
        }
        let ratio = (squares / stated).sqrt();
        // Three standard deviations of 800 squares.
        assert!((ratio - 1.0).abs() < 0.08, "{ratio}");
    }

    #[test]
    fn steps_that_drift_or_are_too_small_are_refused_with_the_reason() {
        let times_s: Vec<f64> = (0..12).map(f64::from).collect();
        assert!(calibrate_well(&steps(0.5e-3), &times_s).is_ok());
        let mut drifting = steps(0.1e-3);
        for (step, time_s) in drifting.iter_mut().zip(&times_s) {
            step.probes_mm[1] += 1e-3 * time_s;
        }
        let refused = calibrate_well(&drifting, &times_s).unwrap_err();
        let NestError::Drift { probe: 2, drift_um, .. } = refused else { panic!("{refused}") };
        assert!((drift_um - 11.0).abs() < 1.0, "{refused}");
        let small: Vec<NestStep> = steps(0.5e-3)
            .into_iter()
            .map(|step| {
                let ball_in_nest_mm = step.ball_in_nest_mm * 0.05;
                let scatter = Vector3::from(step.probes_mm) - Vector3::from(probes(step.ball_in_nest_mm));
                let probes_mm = (Vector3::from(probes(ball_in_nest_mm)) + scatter).into();
                NestStep { ball_in_nest_mm, probes_mm }
            })
            .collect();
        let refused = calibrate_well(&small, &times_s).unwrap_err();
        assert!(matches!(refused, NestError::Uncertain { .. }), "{refused}");
        assert!(refused.to_string().contains("take larger or more steps"), "{refused}");
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
}
