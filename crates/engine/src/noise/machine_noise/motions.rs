//! Unit motions at a site, multiplied by factors of the state.

use crate::Experiment;
use nalgebra::{DVector, Vector3};
use trunnion_core::Twist;
use trunnion_instruments::Projector;
use trunnion_machine::Site;

/// Reading for a unit of one component (dx dy dz ea eb ec) at a site.
pub fn unit_columns(experiment: &Experiment, site: Site, component: usize) -> DVector<f64> {
    let unit = Vector3::ith(component % 3, 1.0);
    let twist = if component < 3 { Twist::translation(unit) } else { Twist::rotation(unit) };
    let mut column = DVector::zeros(experiment.rows());
    for (i, point) in experiment.points.iter().enumerate() {
        let setup = &experiment.setups[point.state.setup];
        let seen = Projector::new(experiment.machine(), setup, &point.state).column(site, &twist);
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
