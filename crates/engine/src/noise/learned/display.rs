//! The step of a display that is coarser than the noise.
//!
//! Such a display errs alike at like readings, so its error is a pattern, not noise: cos and sin of 2π reading/step in two harmonics
//! for every component are columns that are projected out. With a step of 0.87 µm over 0.05 µm of noise they remove four fifths of it.

use crate::Experiment;
use nalgebra::{DMatrix, DVector, Vector3};
use std::f64::consts::TAU;
use trunnion_instruments::predict;
use trunnion_machine::Errors;

/// Harmonics of the saw.
const HARMONICS: usize = 2;
/// Readings are compared to this, mm: a hundredth of a micrometre is no step that matters.
const FINEST_MM: f64 = 1e-8;
/// Share of differences that must be whole multiples, and how whole.
const ALL: f64 = 0.95;
const WHOLE: f64 = 0.05;

/// A display whose steps these readings show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Display {
    pub step_mm: f64,
    /// True where it shows deviations from the nominal reading, as controls and laser software do.
    of_deviations: bool,
}

impl Display {
    /// `None` where neither the readings nor their deviations from nominal are multiples of one step.
    pub fn of(experiment: &Experiment) -> Option<Self> {
        let readings_mm = experiment.readings_mm();
        let deviations_mm = &readings_mm - nominal_readings_mm(experiment);
        let shown = [(&readings_mm, false), (&deviations_mm, true)];
        let by = |rule: fn(&[f64]) -> Option<f64>| {
            shown.into_iter().find_map(|(values, of_deviations)| {
                let step_mm = rule(&gaps_mm(values)?)?;
                Some(Self { step_mm, of_deviations })
            })
        };
        by(smallest_mm).or_else(|| by(common_mm))
    }

    /// Standard deviation of what rounding to a step hides, mm: all values within a step are equally likely [GUM F.2.2.1].
    pub fn hidden_mm(&self) -> f64 {
        self.step_mm / 12f64.sqrt()
    }

    /// Harmonic of a column of the saw.
    pub fn harmonic(column: usize) -> f64 {
        (column / 2 % HARMONICS + 1) as f64
    }

    /// Columns of the saw at the fitted readings, rows × columns.
    pub fn saw(&self, experiment: &Experiment, fitted_mm: &DVector<f64>) -> DMatrix<f64> {
        let shown_mm =
            if self.of_deviations { fitted_mm - nominal_readings_mm(experiment) } else { fitted_mm.clone() };
        let most = (0..experiment.points.len()).map(|i| experiment.rows_of(i).len()).max().unwrap_or(0);
        let mut columns = DMatrix::zeros(experiment.rows(), most * HARMONICS * 2);
        for i in 0..experiment.points.len() {
            for (k, row) in experiment.rows_of(i).enumerate() {
                for harmonic in 0..HARMONICS {
                    let (sin, cos) = (TAU * (harmonic + 1) as f64 * shown_mm[row] / self.step_mm).sin_cos();
                    columns[(row, (k * HARMONICS + harmonic) * 2)] = cos;
                    columns[(row, (k * HARMONICS + harmonic) * 2 + 1)] = sin;
                }
            }
        }
        columns
    }
}

/// What a machine without errors would read at a point, mm.
pub(crate) fn nominal_mm(experiment: &Experiment, i: usize) -> Vector3<f64> {
    let state = &experiment.points[i].state;
    predict(experiment.machine(), &experiment.setups[state.setup], state, &Errors::default())
}

/// The same of every reading.
pub(crate) fn nominal_readings_mm(experiment: &Experiment) -> DVector<f64> {
    let mut nominal = DVector::zeros(experiment.rows());
    for i in 0..experiment.points.len() {
        let of_point_mm = nominal_mm(experiment, i);
        for (k, row) in experiment.rows_of(i).enumerate() {
            nominal[row] = of_point_mm[k];
        }
    }
    nominal
}

/// Differences between the values, mm; none where there are as many values as readings, which show no step.
fn gaps_mm(values_mm: &DVector<f64>) -> Option<Vec<f64>> {
    let mut values: Vec<f64> = values_mm.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    let gaps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|d| *d > FINEST_MM).collect();
    (gaps.len() + 1 < values.len()).then_some(gaps)
}

/// The smallest where nearly all are its multiples.
fn smallest_mm(gaps_mm: &[f64]) -> Option<f64> {
    let step = gaps_mm.iter().copied().fold(f64::INFINITY, f64::min);
    let whole = gaps_mm.iter().filter(|gap| ((*gap / step) - (*gap / step).round()).abs() < WHOLE).count();
    (step.is_finite() && whole as f64 > ALL * gaps_mm.len() as f64).then_some(step)
}

/// The largest step of which all are multiples, by Euclid's algorithm; none where they have none but the finest. It is found where few values
/// are shown, none of them next to each other.
fn common_mm(gaps_mm: &[f64]) -> Option<f64> {
    let divisor = |mut a: i64, mut b: i64| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let units = gaps_mm.iter().map(|gap| (gap / FINEST_MM).round() as i64);
    units.reduce(divisor).filter(|step| *step > 1).map(|step| step as f64 * FINEST_MM)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_display_is_noticed_and_a_fine_one_is_not() {
        let shown = DVector::from_fn(200, |i, _| ((i as f64 * 1.37).sin() * 7.0 / 0.87).round() * 0.87e-3);
        let gaps = gaps_mm(&shown).unwrap();
        assert!((smallest_mm(&gaps).unwrap() - 0.87e-3).abs() < 1e-9);
        let few = DVector::from_fn(96, |i, _| [-30.0, -26.0, -15.0, 0.0, 2.0, 15.0][i % 6] * 1e-3);
        let gaps = gaps_mm(&few).unwrap();
        assert_eq!(smallest_mm(&gaps), None);
        assert!((common_mm(&gaps).unwrap() - 1e-3).abs() < 1e-9);
        let fine = DVector::from_fn(200, |i, _| (i as f64 * 1.37).sin() * 7e-3);
        assert_eq!(gaps_mm(&fine), None);
    }
}
