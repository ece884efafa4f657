//! Shape numbers moved from the grid to where the fit is best.

use crate::golden_section;
use nalgebra::DMatrix;

/// Divisions of the stretch of one number in one sweep.
const GOLDEN_STEPS: usize = 7;
/// Sweeps over the numbers; each looks at a narrower stretch.
const SWEEPS: usize = 2;
/// Share of its stretch that a number keeps for the next sweep.
const NARROWER: f64 = 0.4;

/// A shape with its columns (column × row) and how well they fit, ln.
#[derive(Clone, Debug)]
pub struct Shaped {
    pub shape: Vec<f64>,
    pub columns: DMatrix<f64>,
    pub gain_ln: f64,
}

/// A shape with as many digits as a person wants to read, six.
pub fn readable(shape: &[f64]) -> Vec<f64> {
    let rounded = |x: &f64| format!("{x:.5e}").parse().unwrap_or(*x);
    shape.iter().map(rounded).collect()
}

/// The stretch in which each number is looked for: to its neighbours on the grid, or over `limits` where the grid has one value.
pub fn stretches(grid: &[Vec<f64>], shape: &[f64], limits: Option<&[(f64, f64)]>) -> Vec<(f64, f64)> {
    let stretch = |k: usize| {
        let (low, high) = neighbours(grid.iter().map(|s| s[k]), shape[k]);
        match limits {
            Some(limits) if high <= low => limits[k],
            // The outermost grid point is not the end of what is possible.
            Some(limits) => (
                if low == shape[k] { limits[k].0 } else { low },
                if high == shape[k] { limits[k].1 } else { high },
            ),
            None => (low, high),
        }
    };
    (0..shape.len()).map(stretch).collect()
}

/// Golden section for one number after the other. `gain_ln` of columns; `columns` of a shape, `None` where it makes none.
pub fn refined(
    start: Shaped,
    stretches: &[(f64, f64)],
    columns: impl Fn(&[f64]) -> Option<DMatrix<f64>>,
    gain_ln: impl Fn(&DMatrix<f64>) -> f64,
) -> Shaped {
    let mut best = start;
    let mut stretches = stretches.to_vec();
    for _ in 0..SWEEPS {
        for (k, stretch) in stretches.iter_mut().enumerate() {
            let (low, high) = *stretch;
            if high <= low {
                continue;
            }
            let mut at = |value: f64| {
                let mut shape = best.shape.clone();
                shape[k] = value;
                let Some(columns) = columns(&shape) else { return f64::NEG_INFINITY };
                let gain_ln = gain_ln(&columns);
                if gain_ln > best.gain_ln {
                    best = Shaped { shape, columns, gain_ln };
                }
                gain_ln
            };
            golden_section(low, high, GOLDEN_STEPS, &mut at);
            let half = 0.5 * NARROWER * (high - low);
            *stretch = ((best.shape[k] - half).max(low), (best.shape[k] + half).min(high));
        }
    }
    best
}

/// Grid values on both sides of `value`; itself at an end.
fn neighbours(grid: impl Iterator<Item = f64> + Clone, value: f64) -> (f64, f64) {
    let below = grid.clone().filter(|g| *g < value).fold(f64::NEG_INFINITY, f64::max);
    let above = grid.filter(|g| *g > value).fold(f64::INFINITY, f64::min);
    (if below.is_finite() { below } else { value }, if above.is_finite() { above } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_digits_are_kept() {
        assert_eq!(readable(&[0.557_800_717_8, -1_234_567.8, 0.0]), [0.557_801, -1_234_570.0, 0.0]);
    }

    #[test]
    fn numbers_between_the_grid_points_are_found() {
        let truth = [0.37, 5.2];
        let columns = |shape: &[f64]| Some(DMatrix::from_row_slice(1, 2, shape));
        let gain = |c: &DMatrix<f64>| -(c[0] - truth[0]).powi(2) - 0.1 * (c[1] - truth[1]).powi(2);
        let grid = vec![vec![0.0, 4.0], vec![0.5, 4.0], vec![1.0, 4.0]];
        let shape = grid[1].clone();
        let first = columns(&shape).unwrap();
        let start = Shaped { gain_ln: gain(&first), columns: first, shape };
        let stretches = stretches(&grid, &start.shape, Some(&[(0.0, 1.0), (1.0, 9.0)]));
        assert_eq!(stretches, [(0.0, 1.0), (1.0, 9.0)]);
        let found = refined(start, &stretches, columns, gain);
        assert!(
            (found.shape[0] - 0.37).abs() < 0.01 && (found.shape[1] - 5.2).abs() < 0.1,
            "{:?}",
            found.shape
        );
    }
}
