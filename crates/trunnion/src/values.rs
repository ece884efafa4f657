//! Values of a fit as a model file keeps them: with covariance, and with what differs between runs.

use crate::{Fit, Model};
use nalgebra::DMatrix;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{Point, Quality};
use trunnion_cycles::Run;
use trunnion_effects::{self as effects, FittedRun, FittedValue, FittedValues, Unit};
use trunnion_engine::fit::Options;
use trunnion_engine::{BetweenRuns, HeldOut, Identification, LeftOut, Status, between_runs, identify};
use trunnion_results::sentences::is_setting;

/// Digits of a number in a file: a thousandth of any u that matters.
const DIGITS: usize = 9;

impl Fit {
    /// The values of the machine's parameters with their covariance, for a model file; `date` goes with them.
    pub fn values(&self, date: &str) -> FittedValues {
        let fitted = self.identification();
        let mut correlated: Vec<(usize, f64)> = Vec::new();
        let mut parameters = Vec::new();
        for (k, parameter) in fitted.parameters.iter().enumerate() {
            if is_setting(&parameter.effect) || parameter.status == Status::Held {
                continue;
            }
            let per_inside = parameter.unit.per_inside;
            let between = self.between_runs()[k];
            let correlation = parameter.u.map_or_else(Vec::new, |u| {
                correlated.push((k, u));
                correlation(&fitted.covariance, &correlated)
            });
            parameters.push(FittedValue {
                effect: parameter.effect.clone(),
                name: parameter.name.clone(),
                unit: parameter.unit.symbol.into(),
                value: short(fitted.solution[k] * per_inside),
                u: parameter.u.map(|u| short(between.map_or(u, |between| between.u_of_mean(u)) * per_inside)),
                between_runs: between.map(|between| short(between.sd * per_inside)),
                correlation,
            });
        }
        for effect in fitted.effects.iter().filter(|effect| !is_setting(&effect.id)) {
            let numbers = effect.shape_names.iter().zip(&effect.shape).zip(&effect.shape_in_covariance);
            for (((name, value), row), u) in numbers.zip(fitted.shape_u(effect)) {
                let Some((row, u)) = row.zip(u) else { continue };
                correlated.push((row, u));
                parameters.push(FittedValue {
                    effect: effect.id.clone(),
                    name: name.clone(),
                    unit: Unit::in_name(name).symbol.into(),
                    value: *value,
                    u: Some(short(u)),
                    between_runs: None,
                    correlation: correlation(&fitted.covariance, &correlated),
                });
            }
        }
        FittedValues {
            date: date.into(),
            runs: self.experiment().runs().iter().map(fitted_run).collect(),
            effects: fitted.effects.iter().map(|effect| effect.id.clone()).collect(),
            shapes: fitted
                .effects
                .iter()
                .filter(|effect| !effect.shape.is_empty())
                .map(|effect| (effect.id.clone(), effect.shape.clone()))
                .collect(),
            reading_um: short(um_from_mm(reading_mm(fitted))),
            parameters,
        }
    }

    /// The model with these values, as its file is to keep them; `date` goes with them.
    ///
    /// # Errors
    /// A model of another machine than that of the runs: its file would hold values of two.
    pub fn keeping(&self, date: &str) -> Result<Model, crate::Error> {
        self.model().is_of(self.experiment().runs())?;
        self.model().with_values(&self.values(date))
    }

    /// What differs between runs of one kind, parameter by parameter; `None` where no two runs alone determine one. Runs of different
    /// instruments or setups are parts of one measurement: each sees what the others do not, and none says how the next differs.
    pub fn between_runs(&self) -> &[Option<BetweenRuns>] {
        self.between.get_or_init(|| {
            let runs = self.experiment().runs();
            if runs.len() < 2 || !runs.windows(2).all(|pair| repeats(&pair[0], &pair[1])) {
                return vec![None; self.identification().parameters.len()];
            }
            let model = with_shapes_held(self.model().entries(), self.identification());
            let options = Options { holdout: HeldOut::Skipped, ..Options::default() };
            // A run that cannot be fitted alone, one pose for instance, says nothing of what differs.
            let alone = |run: &Run| {
                let points = trunnion_engine::Experiment::new(std::slice::from_ref(run)).ok()?;
                identify(&points, &model, &options).ok()
            };
            between_runs(self.identification(), &runs.iter().filter_map(alone).collect::<Vec<_>>())
        })
    }
}

impl Model {
    /// With the values of a fit in its last entry, so that it predicts other runs.
    ///
    /// # Errors
    /// None that a model written by this program can have.
    pub fn with_values(&self, values: &FittedValues) -> Result<Self, crate::Error> {
        self.with_same_entries(effects::Model::with_values(self.text(), values)?)
    }
}

/// ρ of the last of `known` (row of the covariance, u) with each of them.
fn correlation(covariance: &DMatrix<f64>, known: &[(usize, f64)]) -> Vec<f64> {
    let Some(&(last, u)) = known.last() else { return Vec::new() };
    known
        .iter()
        .map(|&(row, other)| short((covariance[(row, last)] / (other * u)).clamp(-1.0, 1.0)))
        .collect()
}

/// True where a run measures what another did: at rest or on the fly alike, with the same setups.
fn repeats(run: &Run, other: &Run) -> bool {
    let setups = |run: &Run| -> Vec<_> {
        run.setups.iter().map(|setup| (setup.name.clone(), setup.instrument, setup.nest)).collect()
    };
    run.kind == other.kind && setups(run) == setups(other)
}

/// The model with the shape numbers of a fit.
fn with_shapes_held(model: &effects::Model, fit: &Identification) -> effects::Model {
    let mut model = model.clone();
    for (entry, effect) in model.effects.iter_mut().zip(&fit.effects) {
        entry.shape.clone_from(&effect.shape);
    }
    model
}

/// Scatter of a reading about the model: all parts of the noise, drift and offsets included, of which a fit leaves less in its
/// own residual; at least that residual. Where whole runs were left out in turn, their error shows all of it and that of the values
/// in addition: no more than that.
pub(crate) fn reading_mm(fit: &Identification) -> f64 {
    let parts = fit.noise_parts.iter().map(|part| part.sigma_mm.powi(2)).sum::<f64>().sqrt();
    let of_runs =
        fit.holdout.filter(|holdout| holdout.left_out == LeftOut::Runs).map(|holdout| holdout.rms_mm);
    parts.min(of_runs.unwrap_or(f64::INFINITY)).max(fit.rms_mm)
}

/// Name and digest of a run: of all that was measured or stated. What is computed from that (`since_reversal`, `deflection_mm`) has no
/// part in it.
pub(crate) fn fitted_run(run: &Run) -> FittedRun {
    let mut digest = crc32fast::Hasher::new();
    run.channels.iter().for_each(|channel| digest.update(channel.as_bytes()));
    let mut put = |numbers: &[f64]| numbers.iter().for_each(|number| digest.update(&number.to_le_bytes()));
    for setup in &run.setups {
        put(setup.ball_in_table_mm.coords.as_slice());
        put(setup.ball_in_tool_mm.coords.as_slice());
        put(setup.direction.map_or([0.0; 3], |direction| direction.into_inner().into()).as_slice());
        put(&[setup.bar_length_mm.unwrap_or_default(), f64::from(setup.calibrated)]);
        put(&setup.arms_mm.unwrap_or_default());
    }
    for Point { state, reading_mm, spread_mm, samples, quality } in &run.points {
        put(&state.position.0);
        put(&state.direction.0);
        put(&state.velocity.0);
        put(&state.acceleration.0);
        put(&state.temperature_degc);
        put(reading_mm);
        put(spread_mm);
        put(&[state.time_s.unwrap_or_default(), state.setup as f64, state.target as f64]);
        put(&[f64::from(*samples), f64::from(u8::from(*quality == Quality::Good))]);
    }
    FittedRun { name: run.name.clone(), digest: format!("crc32:{:08x}", digest.finalize()) }
}

/// Rounded to `DIGITS` digits.
fn short(number: f64) -> f64 {
    format!("{number:.*e}", DIGITS - 1).parse().unwrap_or(number)
}
