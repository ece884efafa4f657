//! Numbers that are sums of readings, and how far the noise that the readings themselves show moves them.
//!
//! x = x₀ + Σ_i h_i r_i,   u² = hᵀΣh      Σ: what a fit of all location errors and settings learns of the readings [docs/design/statistics.md §1]
//!
//! Σ holds what the scatter within a pass cannot show: offsets from pass to pass and from setup to setup, and drift; where no reading shows
//! them, of the size that is usual for machines. Whether a pattern over the poses that comes back is noise or a part of what is given, the
//! recipe says ([`trunnion_engine::Patterns`]).
//! Limits: those of the noise; h where the recipe is linear only near the readings, as where a setting is taken off beyond first order.

use crate::recipes::MethodError;
use nalgebra::DMatrix;
use trunnion_engine::solve::linear::LinearFit;
use trunnion_engine::{BeyondModel, Problem};

/// h: number of a point in the experiment, component of its reading, share.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shares(Vec<(usize, usize, f64)>);

impl Shares {
    /// One component of one reading.
    pub fn of(point: usize, component: usize, share: f64) -> Self {
        Self(vec![(point, component, share)])
    }

    /// One component of one reading more.
    pub fn add(&mut self, point: usize, component: usize, share: f64) {
        self.0.push((point, component, share));
    }

    /// Σ factor × number.
    pub fn sum<'a>(parts: impl IntoIterator<Item = (f64, &'a Self)>) -> Self {
        let times = |(factor, part): (f64, &'a Self)| {
            part.0.iter().map(move |(point, component, share)| (*point, *component, factor * share))
        };
        Self(parts.into_iter().flat_map(times).collect())
    }

    /// Of every coefficient of a fit, from those of its right-hand sides.
    pub fn of_fit(design: &DMatrix<f64>, fit: &LinearFit, read: &[Self]) -> Vec<Self> {
        let from_read = &fit.cofactor * design.transpose();
        from_read.row_iter().map(|row| Self::sum(row.iter().copied().zip(read))).collect()
    }
}

/// Standard uncertainties of numbers; the problem is of every good reading, as the numbers count them (`Experiment::of_points`). `None` where the readings are too few, or of several ways of measuring, to say what is noise.
///
/// # Errors
/// Columns of the model that the machine cannot have.
pub(crate) fn u_under_noise(
    problem: &Problem<'_>,
    numbers: &[&Shares],
    beyond: BeyondModel,
) -> Result<Option<Vec<f64>>, MethodError> {
    let Some(noise) = problem.reading_noise()? else { return Ok(None) };
    let experiment = problem.experiment();
    let mut shares = DMatrix::zeros(experiment.rows(), numbers.len());
    for (mut column, Shares(of_readings)) in shares.column_iter_mut().zip(numbers) {
        for &(point, component, share) in of_readings {
            column[experiment.rows_of(point).start + component] += share;
        }
    }
    Ok(Some(noise.u(&shares, beyond).iter().copied().collect()))
}
