//! A fit: parameters with uncertainties, what is not observable, and how far to trust the numbers.

use crate::complete::Complete;
use crate::doubt::Doubt;
use crate::location::LocationErrors;
use crate::plausibility::Plausibility;
use crate::time_quality::TimeQuality;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_effects::Unit;
use trunnion_engine as engine;

pub use trunnion_engine::Approach;

/// `trunnion-identification/1`: the answer of a fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Identification {
    /// Format and version.
    pub format: IdentificationFormat,
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs that were fitted together.
    pub runs: Vec<String>,
    /// Ids of the effects of the model, in the order they were added.
    pub effects: Vec<String>,
    /// Shape numbers of the effects that have any.
    pub shapes: Vec<Shape>,
    /// Points given to the fit, outliers included.
    pub points: usize,
    /// Points that the robust loss excluded.
    pub outliers: usize,
    /// Which points these are.
    pub outlier_points: Vec<Outlier>,
    /// Root mean square of the scalar residuals, outliers left out, µm.
    pub rms_um: f64,
    /// Repeatability of one scalar reading, µm; null where no pose was measured twice.
    pub noise_um: Option<f64>,
    /// Where `noise_um` comes from.
    pub noise_origin: Option<NoiseOrigin>,
    /// From which sides axes came to the poses behind `noise_um`; null where it is.
    #[serde(default)]
    pub noise_approach: Option<Approach>,
    /// Readings averaged in one of which `noise_um` is the scatter, the mean: 1 for single readings; null where it is.
    #[serde(default)]
    pub noise_readings: Option<f64>,
    /// How many times a pose was measured again.
    pub repeats: Option<usize>,
    /// Degrees of freedom behind `noise_um`.
    pub noise_degrees_of_freedom: Option<usize>,
    /// Where the standard uncertainties come from.
    pub u_origin: UncertaintyOrigin,
    /// Parts of the noise behind the standard uncertainties.
    pub noise_parts: Vec<NoisePart>,
    /// Noise of each run and instrument, as the readings were weighted.
    pub noise_by_run: Vec<NoiseOfRun>,
    /// Whether the model explains the readings. False: repeats show that it leaves more than they allow, or a diagnosis found something
    /// missing; then no number of this fit is better than the model. True: a diagnosis made with this fit found nothing missing. Null: not known.
    #[serde(default)]
    pub model_adequate: Option<bool>,
    /// Held-out error, µm rms; null when nothing could be left out.
    pub holdout_rms_um: Option<f64>,
    /// The unit that was left out in turn for the held-out error.
    pub holdout_unit: Option<LeftOut>,
    /// How many of them were left out in turn.
    pub holdout_parts: Option<usize>,
    /// Rank of the scaled design.
    pub rank: usize,
    /// Condition number of the scaled design within its rank.
    pub condition: Option<f64>,
    /// Scalar readings used minus parameters determined.
    pub degrees_of_freedom: usize,
    /// Every parameter of the model, effect after effect.
    pub parameters: Vec<Parameter>,
    /// Directions in parameter space that these runs do not observe.
    pub unobservable: Vec<Unobservable>,
    /// Combinations that are observed although none of their parameters is.
    pub seen_together: Vec<Combination>,
    /// Location errors in a notation, when one was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub location_errors: Option<LocationErrors>,
    /// Numbers of this fit to doubt.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<Doubt>,
    /// What is planned, read, missing and excluded.
    #[serde(default)]
    pub complete: Complete,
    /// Why the runs cannot be judged; empty for good runs.
    #[serde(default)]
    pub plausibility: Vec<Plausibility>,
    /// How well each run with time stamps is known in time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub time_quality: Vec<TimeQuality>,
}

/// Format and version of an identification.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum IdentificationFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-identification/1")]
    V1,
}

/// Shape numbers of one effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Shape {
    /// Effect id.
    pub effect: String,
    /// Their names, with unit.
    pub names: Vec<String>,
    /// Their values.
    pub values: Vec<f64>,
    /// Their standard uncertainties; null for one that the model gives, that counts, or that is the moment of a sudden change.
    #[serde(default)]
    pub u: Vec<Option<f64>>,
}

impl Shape {
    fn listed(&self) -> impl Iterator<Item = Parameter> {
        self.names.iter().zip(&self.values).enumerate().map(|(k, (name, value))| {
            let u = self.u.get(k).copied().flatten();
            Parameter {
                name: name.clone(),
                effect: self.effect.clone(),
                value: Some(*value),
                u,
                unit: Unit::in_name(name).symbol.into(),
                observable: true,
                note: if u.is_some() { "of its shape" } else { "of its shape: no uncertainty is stated" }
                    .into(),
                ..Parameter::default()
            }
        })
    }
}

/// An excluded point.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Outlier {
    /// Index among the points of the fit.
    pub point: usize,
    /// Name of the run.
    pub run: String,
    /// Name of the setup.
    pub setup: String,
    /// Positions of the rotary axes, e.g. `B -30.000° C 120.000°`.
    pub pose: String,
    /// Length of the residual, µm.
    pub residual_um: f64,
}

/// Where the noise of a reading comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseOrigin {
    /// Scatter of poses that were measured more than once.
    Repeats,
}

/// Where the standard uncertainties come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UncertaintyOrigin {
    /// From clusters of the residual: pass × position of the slow axis.
    #[default]
    Clusters,
    /// From the parts of a machine's noise.
    NoiseParts,
}

/// A part of a machine's noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoisePart {
    /// What it is.
    pub part: String,
    /// Standard deviation, µm.
    pub um: f64,
}

/// Noise of one instrument in one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseOfRun {
    /// Name of the run.
    pub run: String,
    /// The instrument.
    pub instrument: String,
    /// Scalar readings used.
    pub readings: usize,
    /// Root mean square of their residuals, µm.
    pub rms_um: f64,
    /// What does not average down, µm.
    pub floor_um: f64,
    /// Standard error of the readings by their samples, µm; 0 when not known.
    pub samples_um: f64,
}

/// The unit that is left out of a fit in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LeftOut {
    /// Whole runs: each was measured in one pass.
    Run,
    /// Whole setups: each was measured in one pass.
    Setup,
    /// Whole passes: one setup in one combination of directions and feed.
    Pass,
    /// Blocks of equal position of the slowest axis.
    Block,
}

/// One parameter of a model or a candidate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Parameter {
    /// Name, e.g. `EX0C`.
    pub name: String,
    /// Id of its effect.
    pub effect: String,
    /// Value in `unit`; null when it is not observable.
    pub value: Option<f64>,
    /// Unit, e.g. `um`, `urad`.
    pub unit: String,
    /// Standard uncertainty in `unit`, of the mean where several runs were fitted; null when it is not observable or was held.
    pub u: Option<f64>,
    /// The same for what one more run will show: what differs between the runs is in it. Left out where no two of the runs show it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_another_run: Option<f64>,
    /// True when it has a number.
    pub observable: bool,
    /// A remark; may be empty.
    #[serde(default)]
    pub note: String,
    /// Errors of axes that were at rest which the value contains, as those axes stood, e.g. `EX0B`; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at_rest: Vec<String>,
}

/// A direction in parameter space that moves no reading.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Unobservable {
    /// Parameter names with coefficients, e.g. `EX0A - EX0C`.
    pub direction: String,
    /// Why, and what the numbers given mean.
    pub why: String,
    /// The same by name.
    pub terms: Vec<Term>,
}

/// One parameter of a direction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Term {
    /// Name of the parameter.
    pub name: String,
    /// Coefficient in its unit.
    pub coefficient: f64,
}

/// A combination that is observed although none of its parameters is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Combination {
    /// E.g. `linear-scale:X.scale + linear-scale:Y.scale`.
    pub combination: String,
    /// Value in `unit`.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard uncertainty in `unit`.
    pub u: f64,
}

impl Identification {
    /// The same with what a diagnosis made with it says of its model.
    #[must_use]
    pub fn judged(self, model_adequate: Option<bool>) -> Self {
        Self { model_adequate: model_adequate.or(self.model_adequate), ..self }
    }

    /// Parameters as tables list them: those of each effect, then its shape numbers.
    pub fn listed(&self) -> Vec<Parameter> {
        let of_effect = |effect: &String| {
            let own = self.parameters.iter().filter(move |p| p.effect == *effect).cloned();
            let shapes = self.shapes.iter().filter(move |shape| shape.effect == *effect);
            own.chain(shapes.flat_map(Shape::listed)).collect::<Vec<_>>()
        };
        self.effects.iter().flat_map(of_effect).collect()
    }

    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }
}

impl LeftOut {
    /// The unit of this name, as a ladder row keeps it.
    pub fn named(name: &str) -> Option<Self> {
        [engine::LeftOut::Runs, engine::LeftOut::Setups, engine::LeftOut::Passes, engine::LeftOut::Blocks]
            .into_iter()
            .find(|unit| unit.name() == name)
            .map(Self::from)
    }

    /// Several of them, in a word.
    pub fn plural(self) -> &'static str {
        match self {
            Self::Run => "runs",
            Self::Setup => "setups",
            Self::Pass => "passes",
            Self::Block => "blocks",
        }
    }
}

impl From<engine::LeftOut> for LeftOut {
    fn from(unit: engine::LeftOut) -> Self {
        match unit {
            engine::LeftOut::Runs => Self::Run,
            engine::LeftOut::Setups => Self::Setup,
            engine::LeftOut::Passes => Self::Pass,
            engine::LeftOut::Blocks => Self::Block,
        }
    }
}
