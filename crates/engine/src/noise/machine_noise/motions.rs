//! Unit motions at a site, multiplied by factors of the state: the small repeatable error motions that every rotary axis has.

use crate::Experiment;
use nalgebra::{DMatrix, DVector, Vector3};
use trunnion_core::{Joint, Twist};
use trunnion_instruments::Projector;
use trunnion_machine::Site;

/// Highest harmonic of the repeatable error motions that count as noise.
const MOTION_HARMONICS: usize = 4;

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
                    let factor = |letter: Joint, i: usize| {
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
