//! The answer of a fit from what the engine fitted.

use crate::complete::Complete;
use crate::identification::{
    Combination, Identification, IdentificationFormat, NoiseOfRun, NoiseOrigin, NoisePart, Outlier,
    Parameter, Shape, Term, UncertaintyOrigin, Unobservable,
};
use crate::number::finite;
use trunnion_core::convert::um_from_mm;
use trunnion_engine as engine;

impl From<&engine::Identification> for Identification {
    fn from(fit: &engine::Identification) -> Self {
        Self {
            format: IdentificationFormat::V1,
            machine: fit.machine.clone(),
            runs: fit.runs.clone(),
            effects: fit.effects.iter().map(|effect| effect.id.clone()).collect(),
            shapes: fit
                .effects
                .iter()
                .filter(|effect| !effect.shape.is_empty())
                .map(|effect| shape(fit, effect))
                .collect(),
            points: fit.points,
            outliers: fit.outliers.len(),
            outlier_points: fit.outliers.iter().map(outlier).collect(),
            rms_um: um_from_mm(fit.rms_mm),
            noise_um: fit.repeatability.map(|noise| um_from_mm(noise.sigma_mm)),
            noise_origin: fit.repeatability.map(|_| NoiseOrigin::Repeats),
            noise_approach: fit.repeatability.map(|noise| noise.approach),
            noise_readings: fit.repeatability.map(|noise| noise.readings),
            repeats: fit.repeatability.map(|noise| noise.repeats),
            noise_degrees_of_freedom: fit.repeatability.map(|noise| noise.degrees_of_freedom),
            u_origin: match fit.noise_parts.is_empty() {
                true => UncertaintyOrigin::Clusters,
                false => UncertaintyOrigin::NoiseParts,
            },
            noise_parts: fit.noise_parts.iter().map(noise_part).collect(),
            noise_by_run: fit.noise_by_run.iter().map(noise_of_run).collect(),
            model_adequate: fit.exceeds_repeats().then_some(false),
            holdout_rms_um: fit.holdout_rms_mm().map(um_from_mm).and_then(finite),
            holdout_unit: fit.holdout.map(|holdout| holdout.left_out.into()),
            holdout_parts: fit.holdout.map(|holdout| holdout.parts),
            rank: fit.rank,
            condition: finite(fit.condition),
            degrees_of_freedom: fit.degrees_of_freedom,
            parameters: fit.parameters.iter().map(Parameter::from).collect(),
            unobservable: fit.unobservable.iter().map(unobservable).collect(),
            seen_together: fit.seen_together.iter().map(combination).collect(),
            location_errors: None,
            complete: Complete { read: fit.points, ..Complete::default() }.with_outliers(fit.outliers.len()),
            doubts: Vec::new(),
            plausibility: Vec::new(),
            time_quality: Vec::new(),
        }
    }
}

impl From<&engine::FittedParameter> for Parameter {
    fn from(parameter: &engine::FittedParameter) -> Self {
        Self {
            name: parameter.name.clone(),
            effect: parameter.effect.clone(),
            value: parameter.screen_value().and_then(finite),
            unit: parameter.unit.symbol.into(),
            u: parameter.screen_u().and_then(finite),
            u_another_run: None,
            observable: parameter.observable(),
            note: parameter.note.clone(),
            at_rest: parameter.at_rest.clone(),
        }
    }
}

fn shape(fit: &engine::Identification, effect: &engine::FittedEffect) -> Shape {
    let (names, values) = (effect.shape_names.clone(), effect.shape.clone());
    Shape { effect: effect.id.clone(), names, values, u: fit.shape_u(effect) }
}

fn outlier(outlier: &engine::Outlier) -> Outlier {
    Outlier {
        point: outlier.point,
        run: outlier.run.clone(),
        setup: outlier.setup.clone(),
        pose: outlier.pose.clone(),
        residual_um: um_from_mm(outlier.residual_mm),
    }
}

fn noise_part(part: &engine::NoisePart) -> NoisePart {
    NoisePart { part: part.name.into(), um: um_from_mm(part.sigma_mm) }
}

fn noise_of_run(group: &engine::GroupNoise) -> NoiseOfRun {
    NoiseOfRun {
        run: group.run.clone(),
        instrument: group.instrument.name().into(),
        readings: group.readings,
        rms_um: um_from_mm(group.rms_mm),
        floor_um: um_from_mm(group.floor_mm),
        samples_um: um_from_mm(group.samples_mm),
    }
}

fn unobservable(direction: &engine::Unobservable) -> Unobservable {
    let term = |(name, coefficient): &(String, f64)| Term { name: name.clone(), coefficient: *coefficient };
    Unobservable {
        direction: direction.direction.clone(),
        why: direction.why.clone(),
        terms: direction.terms.iter().map(term).collect(),
    }
}

fn combination(combination: &engine::Combination) -> Combination {
    Combination {
        combination: combination.text.clone(),
        value: combination.value,
        unit: combination.unit.into(),
        u: combination.u,
    }
}
