//! Frozen values of a fit against other runs.
//!
//! r = P (y − f(x̂))    P = I − Q Qᵀ, Q an orthonormal basis of the columns of the new settings
//! Σ(r) = P (J Σ(x̂) Jᵀ + s² I) P
//! y readings, f exact prediction, x̂ the values of the fit (frozen), J their columns in the new run, Σ(x̂) their covariance,
//! s rms of the fit: the scatter of a reading about the model, what the model lacks included. The band is ± 1.96 √Σ(r)ᵢᵢ.
//! Limits: readings count alike; s is that of one point or block of the fitted runs.

use crate::{Error, Experiment, Fit};
use nalgebra::{DMatrix, DVector};
use trunnion_core::convert::um_from_mm;
use trunnion_effects::catalogue::effect;
use trunnion_effects::{Instance, Model, ModelEffect, Role};
use trunnion_engine::fit::Options;
use trunnion_engine::{FittedParameter, Identification, IdentifyError};
use trunnion_results as results;

/// Two-sided 95 % of a normal distribution, in standard uncertainties [GUM, table G.1].
const COVERAGE_95: f64 = 1.96;
/// Columns of the settings below this share of the largest are no direction of their own.
const INDEPENDENT: f64 = 1e-9;

impl Fit {
    /// Predicts other runs with the values of this fit: everything of the machine frozen, only how the ball was set in the new
    /// runs is fitted.
    ///
    /// # Errors
    /// Runs of another machine, or runs that an effect of the model is out of reach of.
    pub fn predict(&self, other: &Experiment) -> Result<results::Prediction, Error> {
        predict(self, other)
    }
}

/// Predicts each run of `other` alone.
fn predict(fit: &Fit, other: &Experiment) -> Result<results::Prediction, Error> {
    let fitted = fit.identification();
    let mut runs = Vec::new();
    for run in other.runs() {
        if run.machine != *fit.experiment().machine() {
            return Err(Error::OtherMachine {
                fitted: fitted.machine.clone(),
                run: run.name.clone(),
                found: run.machine.name.clone(),
            });
        }
        let experiment = trunnion_engine::Experiment::new(std::slice::from_ref(run))?;
        runs.push(predict_run(fit, &experiment, &run.name)?);
    }
    let not_determined =
        |parameter: &&FittedParameter| !parameter.observable() && !is_setting(&parameter.effect);
    Ok(results::Prediction {
        format: results::PredictionFormat::V1,
        machine: fitted.machine.clone(),
        fitted_runs: fitted.runs.clone(),
        effects: fitted.effects.iter().map(|effect| effect.id.clone()).collect(),
        fit_rms_um: um_from_mm(fitted.rms_mm),
        runs,
        not_determined: fitted.parameters.iter().filter(not_determined).map(|p| p.name.clone()).collect(),
    })
}

fn predict_run(
    fit: &Fit,
    experiment: &trunnion_engine::Experiment,
    name: &str,
) -> Result<results::RunPrediction, Error> {
    let fitted = fit.identification();
    let frozen = Frozen::new(fit, experiment)?;
    let options = Options { holdout: trunnion_engine::HeldOut::Skipped, ..Options::quick() };
    let settled = trunnion_engine::identify(experiment, &frozen.model, &options)?;
    let band = frozen.band_mm(&fitted.covariance, fitted.rms_mm);
    let residual = &settled.residual_mm;
    let readings = residual.len();
    let rms = |values: &DVector<f64>| um_from_mm((values.norm_squared() / readings.max(1) as f64).sqrt());
    let inside = residual.iter().zip(band.iter()).filter(|(r, band)| r.abs() <= **band).count();
    let free = |parameter: &&FittedParameter| parameter.u.is_some();
    Ok(results::RunPrediction {
        run: name.into(),
        points: experiment.points.len(),
        readings,
        rms_um: rms(residual),
        largest_um: um_from_mm(residual.amax()),
        inside_95_fraction: inside as f64 / readings.max(1) as f64,
        band_95_um: rms(&band),
        fitted_settings: settled.parameters.iter().filter(free).map(|p| p.name.clone()).collect(),
    })
}

/// The model of a fit with its values held, in another run.
struct Frozen {
    model: Model,
    /// Columns of the held parameters that the fit determined, and their index in the fit.
    held: (DMatrix<f64>, Vec<usize>),
    /// Columns of the settings of the new run.
    settings: DMatrix<f64>,
}

impl Frozen {
    fn new(fit: &Fit, experiment: &trunnion_engine::Experiment) -> Result<Self, Error> {
        let fitted = fit.identification();
        let mut model = Model { machine: fitted.machine.clone(), effects: Vec::new() };
        let (mut held, mut indices, mut settings) = (Vec::new(), Vec::new(), Vec::new());
        for (entry, effect) in fit.model().entries().effects.iter().zip(&fitted.effects) {
            let instance =
                Instance::from_model_effect(entry, experiment.machine()).map_err(IdentifyError::from)?;
            let columns = experiment.columns(&instance, &effect.shape);
            let mut frozen =
                ModelEffect { shape: effect.shape.clone(), fixed: vec![], prior: vec![], ..entry.clone() };
            for (j, parameter) in instance.parameters(&experiment.scene).iter().enumerate() {
                let known = index(fitted, &entry.id, &parameter.name).filter(|_| !is_setting(&entry.id));
                let column = columns.column(j).into_owned();
                match known {
                    Some(k) => {
                        frozen
                            .fixed
                            .push((parameter.name.clone(), fitted.solution[k] * parameter.unit.per_inside));
                        held.push(column);
                        indices.push(k);
                    }
                    None => settings.push(column),
                }
            }
            model.effects.push(frozen);
        }
        let matrix = |columns: &[DVector<f64>]| match columns {
            [] => DMatrix::zeros(experiment.rows(), 0),
            columns => DMatrix::from_columns(columns),
        };
        Ok(Self { model, held: (matrix(&held), indices), settings: matrix(&settings) })
    }

    /// Half width of the 95 % band of every reading, mm.
    fn band_mm(&self, covariance: &DMatrix<f64>, scatter_mm: f64) -> DVector<f64> {
        let basis = orthonormal(&self.settings);
        let (columns, indices) = &self.held;
        let projected = columns - &basis * (basis.transpose() * columns);
        let covariance = covariance.select_rows(indices).select_columns(indices);
        let spread = &projected * covariance;
        DVector::from_fn(projected.nrows(), |i, _| {
            let of_values = spread.row(i).dot(&projected.row(i)).max(0.0);
            let free = (1.0 - basis.row(i).norm_squared()).max(0.0);
            COVERAGE_95 * (of_values + scatter_mm * scatter_mm * free).sqrt()
        })
    }
}

/// True for what mounting and artefact leave unknown: it belongs to a run, not to the machine.
fn is_setting(id: &str) -> bool {
    effect(id).is_some_and(|effect| effect.role == Role::Setting)
}

/// Index of a parameter of the fit.
fn index(fitted: &Identification, effect: &str, name: &str) -> Option<usize> {
    fitted.parameters.iter().position(|p| p.effect == effect && p.name == name)
}

/// An orthonormal basis of the space that columns span.
fn orthonormal(columns: &DMatrix<f64>) -> DMatrix<f64> {
    if columns.ncols() == 0 {
        return columns.clone();
    }
    let svd = columns.clone().svd(true, false);
    let kept: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > INDEPENDENT * svd.singular_values[0])
        .collect();
    svd.u.map_or_else(|| DMatrix::zeros(columns.nrows(), 0), |u| u.select_columns(&kept))
}
