//! What the base model, with every location error and setting free, leaves of readings.

use crate::Experiment;
use crate::solve::linear::Reduced;
use nalgebra::{DMatrix, DVector};
use trunnion_effects::{Instance, Model};

/// Relative singular value of a direction that the columns do not see.
const UNSEEN: f64 = 1e-6;

/// A mistake, and what the model leaves with it undone, mm rms.
pub(super) type Tried = (String, f64);

/// Directions that the base model can explain.
pub(super) struct Fitted {
    basis: DMatrix<f64>,
}

impl Fitted {
    pub fn new(experiment: &Experiment) -> Option<Self> {
        let machine = experiment.machine();
        let model = Model::base(&machine.name);
        let mut columns = DMatrix::zeros(experiment.rows(), 0);
        for entry in &model.effects {
            let instance = Instance::from_model_effect(entry, machine).ok()?;
            let own = experiment.columns(&instance, &[]);
            let at = columns.ncols();
            columns = columns.insert_columns(at, own.ncols(), 0.0);
            columns.columns_mut(at, own.ncols()).copy_from(&own);
        }
        let seen = Reduced::from_design(&columns).orthonormal(UNSEEN);
        Some(Self { basis: columns * seen })
    }

    /// What it leaves of readings, mm.
    pub fn left_mm(&self, readings_mm: &DVector<f64>) -> DVector<f64> {
        readings_mm - &self.basis * self.basis.tr_mul(readings_mm)
    }

    /// The same, rms.
    pub fn rms_mm(&self, readings_mm: &DVector<f64>) -> f64 {
        rms(&self.left_mm(readings_mm))
    }
}

pub(super) fn rms(of: &DVector<f64>) -> f64 {
    (of.norm_squared() / of.len().max(1) as f64).sqrt()
}
