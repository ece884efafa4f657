//! Frozen values of a model against other runs.
//!
//! r = P (y − f(x̂))    P = I − Q Qᵀ, Q an orthonormal basis of the columns of the new settings
//! Σ(r) = P (J Σ(x̂) Jᵀ + s² I) P
//! y readings, f exact prediction, x̂ the values (frozen), shape numbers that were fitted among them, J their columns in the new run,
//! Σ(x̂) their covariance in one more run (`FittedValues`: what differs between runs is in it where several were fitted), s the scatter
//! of a reading about the model, what the model lacks included. The band is ± 1.96 √Σ(r)ᵢᵢ.
//! A value that the fitted runs do not determine alone is held as they left it, and has no part in Σ(x̂).
//! Limits: readings count alike; s is that of one point or block of the fitted runs. Values of one run know nothing of what differs
//! between runs.

use crate::values::fitted_run;
use crate::{Error, Experiment, Fit, Model};
use nalgebra::{DMatrix, DVector};
use trunnion_core::Twist;
use trunnion_core::convert::{mm_from_um, um_from_mm};
use trunnion_core::number::plain;
use trunnion_core::statistics::COVERAGE_95;
use trunnion_cycles::Run;
use trunnion_effects::{self as effects, FittedValue, FittedValues, Instance, ModelEffect, Need, Parameter};
use trunnion_engine::fit::Options;
use trunnion_engine::{HeldOut, Identification, IdentifyError, Status};
use trunnion_results as results;
use trunnion_results::number::with_unit;
use trunnion_results::sentences::is_setting;

/// Columns of the settings below this share of the largest are no direction of their own.
pub(crate) const INDEPENDENT: f64 = 1e-9;

impl Fit {
    /// Predicts other runs with the values of this fit: everything of the machine frozen, only how the ball was set in the new
    /// runs is fitted.
    ///
    /// # Errors
    /// A model file or runs of another machine, runs that an effect of the model is out of reach of, or that lack what a value acts on.
    pub fn predict(&self, other: &Experiment) -> Result<results::Prediction, Error> {
        self.model().is_of(self.experiment().runs())?;
        let machine = self.experiment().machine();
        if let Some(run) = other.runs().iter().find(|run| run.machine != *machine) {
            return Err(Error::OtherMachine {
                fitted: machine.name.clone(),
                run: run.name.clone(),
                found: run.machine.name.clone(),
            });
        }
        predict(self.model().entries(), &self.values(""), other)
    }
}

impl Model {
    /// Predicts runs with the values that the model file keeps, as [`Fit::predict`] does with those of a fit.
    ///
    /// # Errors
    /// A file of another machine, or without values of its effects; as [`Fit::predict`].
    pub fn predict(&self, runs: &Experiment) -> Result<results::Prediction, Error> {
        self.is_of(runs.runs())?;
        predict(self.entries(), self.kept()?, runs)
    }

    /// Where runs differ from what the values of the model file predict: as [`Fit::compare`], with the machine frozen. What is
    /// missing from the model is not asked: the values are not those of these runs.
    ///
    /// # Errors
    /// As [`Model::predict`].
    pub fn compare_frozen(&self, runs: &Experiment) -> Result<results::Comparison, Error> {
        let prediction = self.predict(runs)?;
        let frozen = Frozen::new(self.entries(), self.kept()?, runs.points())?;
        let settled = frozen.settled(runs.points())?;
        let mut compared = results::Comparison {
            frozen: Some(prediction),
            losses: runs.losses(),
            ladder: self.ladder(),
            time_quality: runs.time_quality(),
            ..results::Comparison::new(runs.points(), &settled, None)
        };
        compared.identification.complete = runs.complete().with_outliers(settled.outliers.len());
        Ok(compared)
    }

    fn kept(&self) -> Result<&FittedValues, Error> {
        self.entries().values().ok_or_else(|| Error::NoValues {
            why: match self.entries().effects.iter().any(|entry| entry.values.is_some()) {
                true => "its effects changed since they were fitted".into(),
                false => "it was not fitted, or by an earlier version".into(),
            },
        })
    }
}

/// Whether an effect has a share in these runs that can be predicted: not one of speed in runs at rest.
///
/// # Errors
/// An effect that acts in these runs and has no parameter there. One of an axis that rests has a value that they do not ask for: which part of it
/// a setting takes up, nobody can say.
fn has_a_share(
    instance: &Instance,
    shape: &[f64],
    experiment: &trunnion_engine::Experiment,
) -> Result<bool, Error> {
    let scene = &experiment.scene;
    if !instance.parameters(scene).is_empty() {
        return Ok(true);
    }
    let mut moved = false;
    for point in &experiment.points {
        instance.motions(scene, shape, &point.state, &mut |_, _, twist| moved |= twist != Twist::default());
    }
    let is_of_speed = |need: &Need| matches!(need, Need::OnTheFly | Need::ChangingSpeed);
    if !moved && instance.missing(scene).iter().any(is_of_speed) {
        return Ok(false);
    }
    Err(Error::NoShare {
        run: experiment.runs.join(", "),
        effect: instance.id(),
        why: instance.out_of_reach(scene).unwrap_or_else(|| "has no parameter here".into()),
    })
}

/// A value that acts in these runs on what they do not hold, the temperature of a sensor for example: without it the prediction is that of another
/// model.
fn has_what_is_kept(
    entry: &ModelEffect,
    values: &FittedValues,
    instance: &Instance,
    experiment: &trunnion_engine::Experiment,
) -> Result<(), Error> {
    if is_setting(&entry.id) {
        return Ok(());
    }
    let of_entry = values.parameters.iter().filter(|value| value.effect == entry.id);
    let fitted = of_entry.filter(|value| value.u.is_some() || value.value != 0.0);
    let fitted = fitted.map(|value| (&value.name, with_unit(value.value, &value.unit)));
    let by_hand = entry.fixed.iter().filter(|(_, value)| *value != 0.0);
    let all: Vec<_> = fitted.chain(by_hand.map(|(name, value)| (name, plain(*value)))).collect();
    let mut lacks: Vec<(String, Vec<String>)> = Vec::new();
    for (name, value) in all {
        let Some(why) = instance.lacks(&experiment.scene, name) else { continue };
        let value = format!("{name} = {value}");
        match lacks.iter_mut().find(|(known, _)| *known == why) {
            Some((_, values)) => values.push(value),
            None => lacks.push((why, vec![value])),
        }
    }
    if lacks.is_empty() {
        return Ok(());
    }
    let sentence = |(why, values): &(String, Vec<String>)| {
        format!("{} {why}. The model keeps {} of it.", entry.id, values.join(", "))
    };
    let lacks: Vec<String> = lacks.iter().map(sentence).collect();
    Err(Error::Lacks { run: experiment.runs.join(", "), lacks: lacks.join(" ") })
}

/// Predicts each run of `other` alone.
fn predict(
    model: &effects::Model,
    values: &FittedValues,
    other: &Experiment,
) -> Result<results::Prediction, Error> {
    let mut runs = Vec::new();
    for run in other.runs() {
        let experiment = trunnion_engine::Experiment::new(std::slice::from_ref(run))?;
        runs.push(predict_run(model, values, &experiment, run)?);
    }
    let taken: Vec<results::Taken> = values.parameters.iter().filter(|p| p.u.is_none()).map(taken).collect();
    Ok(results::Prediction {
        format: results::PredictionFormat::V1,
        machine: other.machine().name.clone(),
        fitted_runs: values.runs.iter().map(|run| run.name.clone()).collect(),
        fitted_on: values.date.clone(),
        effects: values.effects.clone(),
        reading_um: values.reading_um,
        differences_known: values.parameters.iter().any(|parameter| parameter.between_runs.is_some()),
        runs,
        not_determined: taken.iter().map(|one| one.name.clone()).collect(),
        taken,
    })
}

/// What the fitted runs do not determine alone keeps its share of what they determine together: with 0 in its place the model would
/// no longer predict its own runs.
fn taken(value: &FittedValue) -> results::Taken {
    results::Taken {
        effect: value.effect.clone(),
        name: value.name.clone(),
        unit: value.unit.clone(),
        value: value.value,
    }
}

fn predict_run(
    model: &effects::Model,
    values: &FittedValues,
    experiment: &trunnion_engine::Experiment,
    run: &Run,
) -> Result<results::RunPrediction, Error> {
    let frozen = Frozen::new(model, values, experiment)?;
    let settled = frozen.settled(experiment)?;
    let band = frozen.band_mm(mm_from_um(values.reading_um));
    let residual = &settled.residual_mm;
    let readings = residual.len();
    let rms = |values: &DVector<f64>| um_from_mm((values.norm_squared() / readings.max(1) as f64).sqrt());
    let inside = residual.iter().zip(band.iter()).filter(|(r, band)| r.abs() <= **band).count();
    Ok(results::RunPrediction {
        run: run.name.clone(),
        was_fitted: values.runs.contains(&fitted_run(run)),
        points: experiment.points.len(),
        readings,
        rms_um: rms(residual),
        without_model_rms_um: rms(&without_model(model, experiment)?),
        largest_um: um_from_mm(residual.amax()),
        mean_distance_um: mean_distance_mm(experiment, residual).map(um_from_mm),
        inside_95_fraction: inside as f64 / readings.max(1) as f64,
        band_95_um: rms(&band),
        fitted_settings: settled
            .parameters
            .iter()
            .filter(|p| is_setting(&p.effect) && p.u.is_some())
            .map(|p| p.name.clone())
            .collect(),
    })
}

/// Mean length of the residual of a point, mm; `None` unless every point reads three components.
fn mean_distance_mm(experiment: &trunnion_engine::Experiment, residual_mm: &DVector<f64>) -> Option<f64> {
    let lengths: Option<Vec<f64>> = (0..experiment.points.len())
        .map(|point| {
            let rows = experiment.rows_of(point);
            (rows.len() == 3).then(|| residual_mm.rows(rows.start, rows.len()).norm())
        })
        .collect();
    lengths
        .filter(|lengths| !lengths.is_empty())
        .map(|lengths| lengths.iter().sum::<f64>() / lengths.len() as f64)
}

/// What remains of the readings when the machine is taken to be nominal.
pub(crate) fn without_model(
    model: &effects::Model,
    experiment: &trunnion_engine::Experiment,
) -> Result<DVector<f64>, Error> {
    let settings: Vec<_> = model.effects.iter().filter(|entry| is_setting(&entry.id)).cloned().collect();
    let nominal = effects::Model::of(&model.machine, settings);
    Ok(trunnion_engine::identify(experiment, &nominal, &quick())?.residual_mm)
}

fn quick() -> Options {
    Options { holdout: HeldOut::Skipped, ..Options::quick() }
}

/// A model with its values held, in another run.
struct Frozen<'v> {
    model: effects::Model,
    /// What the held parameters are known by.
    values: &'v FittedValues,
    /// Columns of the held parameters that have a standard uncertainty, with their values.
    held: (DMatrix<f64>, Vec<Known<'v>>),
    /// Columns of the settings of the new run.
    settings: DMatrix<f64>,
}

/// A held parameter.
struct Known<'v> {
    value: &'v FittedValue,
    per_inside: f64,
    /// Its number in `correlation`.
    number: usize,
}

impl<'v> Frozen<'v> {
    fn new(
        model: &effects::Model,
        values: &'v FittedValues,
        experiment: &trunnion_engine::Experiment,
    ) -> Result<Self, Error> {
        let mut frozen = effects::Model::of(&model.machine, Vec::new());
        let (mut held, mut known, mut settings) = (Vec::new(), Vec::new(), Vec::new());
        for entry in &model.effects {
            let instance =
                Instance::from_model_effect(entry, experiment.machine()).map_err(IdentifyError::from)?;
            has_what_is_kept(entry, values, &instance, experiment)?;
            let fitted_shape = values.shapes.iter().find(|(id, _)| *id == entry.id).map(|(_, shape)| shape);
            let shape = fitted_shape.unwrap_or(&entry.shape).clone();
            if !has_a_share(&instance, &shape, experiment)? {
                continue;
            }
            let columns = experiment.columns(&instance, &shape);
            let mut frozen_entry = ModelEffect { shape, fixed: vec![], prior: vec![], ..entry.clone() };
            for (j, parameter) in instance.parameters(&experiment.scene).into_iter().enumerate() {
                let column = columns.column(j).into_owned();
                if is_setting(&entry.id) {
                    settings.push(column);
                    continue;
                }
                let by_hand = entry.fixed.iter().find(|(name, _)| *name == parameter.name);
                let value = by_hand.map(|(_, value)| *value);
                let fitted = find(values, &entry.id, &parameter.name);
                let value = value.or(fitted.map(|(_, fitted)| fitted.value)).unwrap_or_default();
                frozen_entry.fixed.push((parameter.name, value));
                if let Some((number, fitted)) = fitted.filter(|(_, fitted)| fitted.u.is_some()) {
                    held.push(column);
                    known.push(Known { value: fitted, per_inside: parameter.unit.per_inside, number });
                }
            }
            for (at, name) in instance.shapes(&experiment.scene).names.iter().enumerate() {
                if let Some((number, fitted)) =
                    find(values, &entry.id, name).filter(|(_, fitted)| fitted.u.is_some_and(|u| u > 0.0))
                {
                    held.push(change_mm(experiment, &instance, &frozen_entry, at, fitted));
                    known.push(Known { value: fitted, per_inside: 1.0, number });
                }
            }
            frozen.effects.push(frozen_entry);
        }
        let matrix = |columns: &[DVector<f64>]| match columns {
            [] => DMatrix::zeros(experiment.rows(), 0),
            columns => DMatrix::from_columns(columns),
        };
        Ok(Self { model: frozen, values, held: (matrix(&held), known), settings: matrix(&settings) })
    }

    /// The fit of the settings, the held parameters with what the fitted runs know of them.
    fn settled(&self, experiment: &trunnion_engine::Experiment) -> Result<Identification, Error> {
        let mut fit = trunnion_engine::identify(experiment, &self.model, &quick())?;
        for parameter in fit.parameters.iter_mut().filter(|parameter| parameter.status == Status::Held) {
            let Some((_, kept)) = find(self.values, &parameter.effect, &parameter.name) else { continue };
            parameter.u = kept.u.map(|u| u / parameter.unit.per_inside);
            if parameter.u.is_none() {
                (parameter.value, parameter.status) = (None, Status::Unobservable);
                let value = with_unit(kept.value, &kept.unit);
                parameter.note = format!("not determined alone by the fitted runs, taken as {value}");
            }
        }
        Ok(fit)
    }

    /// Half width of the 95 % band of every reading, mm.
    fn band_mm(&self, scatter_mm: f64) -> DVector<f64> {
        let basis = orthonormal(&self.settings);
        let (columns, known) = &self.held;
        let projected = columns - &basis * (basis.transpose() * columns);
        let covariance = DMatrix::from_fn(known.len(), known.len(), |i, j| covariance(&known[i], &known[j]));
        let spread = &projected * covariance;
        DVector::from_fn(projected.nrows(), |i, _| {
            let of_values = spread.row(i).dot(&projected.row(i)).max(0.0);
            let free = (1.0 - basis.row(i).norm_squared()).max(0.0);
            COVERAGE_95 * (of_values + scatter_mm * scatter_mm * free).sqrt()
        })
    }
}

/// What a shape number changes in the readings of its effect over ± u, mm per unit of it: as the covariance of the values takes it.
fn change_mm(
    experiment: &trunnion_engine::Experiment,
    instance: &Instance,
    entry: &ModelEffect,
    at: usize,
    fitted: &FittedValue,
) -> DVector<f64> {
    let parameters = instance.parameters(&experiment.scene);
    let value = |parameter: &Parameter| {
        let held = entry.fixed.iter().find(|(name, _)| *name == parameter.name);
        held.map_or(0.0, |(_, value)| value / parameter.unit.per_inside)
    };
    let values = DVector::from_iterator(parameters.len(), parameters.iter().map(value));
    experiment.change_with_shape(instance, &entry.shape, at, fitted.u.unwrap_or_default(), &values)
}

/// A value, and its number among those with a standard uncertainty.
fn find<'v>(values: &'v FittedValues, effect: &str, name: &str) -> Option<(usize, &'v FittedValue)> {
    let at = values.parameters.iter().position(|value| value.effect == effect && value.name == name)?;
    let number = values.parameters[..at].iter().filter(|value| value.u.is_some()).count();
    Some((number, &values.parameters[at]))
}

/// Covariance of two values in one more run, inside units.
fn covariance(a: &Known<'_>, b: &Known<'_>) -> f64 {
    let (early, late) = if a.number <= b.number { (a, b) } else { (b, a) };
    let rho = late.value.correlation.get(early.number).copied().unwrap_or_default();
    let size = |of: fn(&FittedValue) -> Option<f64>| {
        [a, b].map(|known| of(known.value).unwrap_or_default() / known.per_inside).iter().product::<f64>()
    };
    rho * (size(|value| value.u) + size(|value| value.between_runs))
}

/// An orthonormal basis of the space that columns span.
pub(crate) fn orthonormal(columns: &DMatrix<f64>) -> DMatrix<f64> {
    if columns.ncols() == 0 {
        return columns.clone();
    }
    let svd = columns.clone().svd(true, false);
    let kept: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > INDEPENDENT * svd.singular_values[0])
        .collect();
    svd.u.map_or_else(|| DMatrix::zeros(columns.nrows(), 0), |u| u.select_columns(&kept))
}
