//! Setting and centre of one height by least squares over u and v together [S0 §4.3].

use crate::common::shares::Shares;
use crate::common::turning::Turned;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use trunnion_engine::solve::linear::least_squares;

/// `c + R(θ) s`, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Circle {
    pub centre_mm: Vector2<f64>,
    pub setting_mm: Vector2<f64>,
}

/// A circle through readings.
pub(super) struct Through {
    pub circle: Circle,
    /// Standard uncertainties by the residual.
    pub u: Circle,
    /// What each reading counts in the centre.
    pub shares_of_centre: [Shares; 2],
}

impl Circle {
    /// Least squares over u and v together; `None` for too few readings.
    pub fn through(readings: &[Turned]) -> Option<Through> {
        if readings.len() < 4 {
            return None;
        }
        let (mut a, mut b) = (DMatrix::zeros(2 * readings.len(), 4), DVector::zeros(2 * readings.len()));
        for (i, reading) in readings.iter().enumerate() {
            let (sin, cos) = reading.turned_rad.sin_cos();
            for (k, row) in [[1.0, 0.0, cos, -sin], [0.0, 1.0, sin, cos]].into_iter().enumerate() {
                a.row_mut(2 * i + k).copy_from_slice(&row);
                b[2 * i + k] = reading.moved_mm[k];
            }
        }
        let fit = least_squares(&a, &b, 1e-9);
        let circle = |x: &DVector<f64>| Self {
            centre_mm: Vector2::new(x[0], x[1]),
            setting_mm: Vector2::new(x[2], x[3]),
        };
        let of_row = |row: usize| {
            let reading = &readings[row / 2];
            let share = |k: usize| Shares::of(reading.number, k, reading.moved_per_reading[(row % 2, k)]);
            Shares::sum([0, 1, 2].map(share).iter().map(|share| (1.0, share)))
        };
        let shares_of_centre = || {
            let read: Vec<Shares> = (0..b.len()).map(of_row).collect();
            let mut of_all = Shares::of_fit(&a, &fit, &read).into_iter();
            [(); 2].map(|()| of_all.next().unwrap_or_default())
        };
        (fit.rank == 4).then(|| Through {
            circle: circle(&fit.x),
            u: circle(&fit.u),
            shares_of_centre: shares_of_centre(),
        })
    }

    /// `c + R(θ) s`.
    pub fn at(&self, turned_rad: f64) -> Vector2<f64> {
        let (sin, cos) = turned_rad.sin_cos();
        self.centre_mm + Matrix2::new(cos, -sin, sin, cos) * self.setting_mm
    }

    /// Standard uncertainty of the mean of several, by their scatter.
    pub fn scatter_of_mean(passes: &[(f64, Self)]) -> Self {
        let scatter = |of: fn(&Self) -> Vector2<f64>| {
            let count = passes.len() as f64;
            let mean = passes.iter().map(|(_, circle)| of(circle)).sum::<Vector2<f64>>() / count;
            let squares = passes.iter().map(|(_, c)| (of(c) - mean).map(|d| d * d)).sum::<Vector2<f64>>();
            squares.map(|square| (square / (count - 1.0) / count).sqrt())
        };
        Self { centre_mm: scatter(|c| c.centre_mm), setting_mm: scatter(|c| c.setting_mm) }
    }
}
