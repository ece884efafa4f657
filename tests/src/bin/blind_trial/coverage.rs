//! How often the 95 % intervals of an identification with the right model hold the truth.
//!
//! The truth of a location error is what the simulator drew; the truth of the effect's own parameters is what the right model
//! says of the same machine without any noise, if it then leaves nothing. Left out is what has no single truth: location errors that
//! the effect as drawn contains a part of (the noise-free fit disagrees with the draw), effects that the catalogue's form does not
//! reach exactly, and amplitudes beside a shape number that noise moved (a time constant, a number of lobes).

use crate::cases::Case;
use crate::noise::Kind as NoiseKind;
use crate::score::with_set;
use crate::stage::{SIGMA_MM, Stage, experiment};
use crate::trial::{catalogue_id, stage_case};
use trunnion_effects::ModelEffect;
use trunnion_engine::fit::Options;
use trunnion_engine::{HeldOut, Identification, identify};
use trunnion_hil_sim::truth::minimum_set;

/// Half-width of a 95 % interval in standard uncertainties.
const WIDE: f64 = 1.96;
/// A noise-free fit that leaves less than this has the right form, mm.
const LEAVES_NOTHING_MM: f64 = 0.02 * SIGMA_MM;
/// A location error that the effect shifts by more than this many standard uncertainties has no single truth.
const CONTAINED: f64 = 0.1;

/// What one identification said of its parameters.
#[derive(Clone, Debug)]
pub struct Covered {
    pub noise: NoiseKind,
    pub label: String,
    /// (name, pull) of location errors: (value − truth)/u.
    pub location: Vec<(String, f64)>,
    /// (name, pull) of the parameters of the effect.
    pub effect: Vec<(String, f64)>,
    /// Parameters without a single truth.
    pub left_out: usize,
}

impl Covered {
    /// True when the interval behind a pull holds the truth.
    pub fn holds(pull: f64) -> bool {
        pull.abs() <= WIDE
    }
}

/// Identifies a case with the right model.
pub fn cover(stage: &Stage, case: &Case) -> Covered {
    let staged = stage_case(stage, case);
    let entry = |id: &String| ModelEffect { id: catalogue_id(id), ..ModelEffect::default() };
    let set: Vec<ModelEffect> = case.hidden.iter().map(entry).collect();
    let model = with_set(&stage.machine, &set);
    let options = Options { holdout: HeldOut::Skipped, ..Options::default() };
    let exact = experiment(&stage.trial.run("noise-free", &stage.trial.ideal_mm(&staged.truth)));
    let mut covered = Covered {
        noise: case.noise,
        label: format!("{} #{}", case.label(), case.seed),
        location: Vec::new(),
        effect: Vec::new(),
        left_out: 0,
    };
    let (Ok(fit), Ok(exact)) =
        (identify(&staged.experiment, &model, &options), identify(&exact, &model, &Options::quick()))
    else {
        return covered;
    };
    for error in minimum_set(&stage.machine) {
        let name = error.name();
        let truth = error.of(&staged.truth.location);
        let noise_free = exact.parameter(&name).and_then(|parameter| parameter.value);
        match (measured(&fit, "location-errors", &name), noise_free) {
            (Some((value, u)), Some(noise_free)) if (noise_free - truth).abs() <= CONTAINED * u => {
                covered.location.push((name, (value - truth) / u));
            }
            _ => covered.left_out += 1,
        }
    }
    let form_is_right = exact.rms_mm < LEAVES_NOTHING_MM && same_shapes(&fit, &exact);
    for parameter in exact.parameters.iter().filter(|p| set.iter().any(|entry| entry.id == p.effect)) {
        let truth = parameter.value.filter(|_| form_is_right);
        match (measured(&fit, &parameter.effect, &parameter.name), truth) {
            (Some((value, u)), Some(truth)) => {
                covered.effect.push((parameter.name.clone(), (value - truth) / u));
            }
            _ => covered.left_out += 1,
        }
    }
    covered
}

/// Value and standard uncertainty of a parameter that has both.
fn measured(fit: &Identification, effect: &str, name: &str) -> Option<(f64, f64)> {
    let parameter = fit.parameters.iter().find(|p| p.effect == effect && p.name == name)?;
    parameter.value.zip(parameter.u).filter(|(_, u)| *u > 0.0)
}

fn same_shapes(one: &Identification, other: &Identification) -> bool {
    let shapes = |fit: &Identification| -> Vec<f64> {
        fit.effects.iter().flat_map(|effect| effect.shape.iter().copied()).collect()
    };
    let near = |(a, b): (f64, f64)| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    shapes(one).into_iter().zip(shapes(other)).all(near)
}
