//! How to fit, and what can go wrong.

use trunnion_effects::{Instance, Scene, UnknownEffect};

/// Choices of a fit. The default is what `trunnion identify` does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What to do with outliers.
    pub outliers: Outliers,
    /// Whether to predict left-out parts (costs a fit for each).
    pub holdout: HeldOut,
    /// Where uncertainties come from.
    pub uncertainties: Uncertainties,
    /// Directions with a singular value below this share of the largest are not seen.
    pub null_tolerance: f64,
}

/// What to do with outliers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outliers {
    /// Exclude them and name them.
    Excluded,
    /// Keep every point.
    Keep,
}

/// Whether the held-out error is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeldOut {
    /// Leave out passes, or blocks, in turn.
    Computed,
    /// Save the time.
    Skipped,
}

/// Where the uncertainties of the parameters come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Uncertainties {
    /// From the noise that the run itself shows, the one of a diagnosis: white, offsets of passes, positioning, drift, a pattern over
    /// the poses. With few readings, from clusters.
    NoiseParts,
    /// From how alike the residuals of a cluster (pass × position of the slow axis) are: quick, and too narrow where
    /// errors last longer than a cluster.
    Clusters,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            outliers: Outliers::Excluded,
            holdout: HeldOut::Computed,
            uncertainties: Uncertainties::NoiseParts,
            null_tolerance: 1e-8,
        }
    }
}

impl Options {
    /// For a scan of many models: outliers kept, no hold-out, uncertainties from clusters.
    pub fn quick() -> Self {
        Self {
            outliers: Outliers::Keep,
            holdout: HeldOut::Skipped,
            uncertainties: Uncertainties::Clusters,
            ..Self::default()
        }
    }
}

/// Why a model could not be identified.
#[derive(Clone, Debug, thiserror::Error)]
pub enum IdentifyError {
    /// The model names an effect this machine cannot have.
    #[error(transparent)]
    UnknownEffect(#[from] UnknownEffect),
    /// The runs cannot show an effect of the model.
    #[error(
        "effect {effect} is out of reach of these runs: it {why}; \
         remove it from the model or add a run that shows it"
    )]
    OutOfReach {
        /// Effect id.
        effect: String,
        /// What the runs lack, e.g. `needs time stamps`.
        why: String,
    },
    /// An effect is listed twice.
    #[error("the model lists effect {effect} twice; keep one")]
    EffectTwice {
        /// Effect id.
        effect: String,
    },
    /// The model holds or expects a parameter that does not exist.
    #[error("effect {effect} has no parameter \"{name}\" to hold or expect; allowed: {allowed}")]
    UnknownParameter {
        /// Effect id.
        effect: String,
        /// What was asked for.
        name: String,
        /// Its parameters.
        allowed: String,
    },
    /// The model gives the wrong number of shape numbers.
    #[error("effect {effect} has {expected} shape number(s) ({names}), the model gives {found}")]
    WrongShape {
        /// Effect id.
        effect: String,
        /// How many it has.
        expected: usize,
        /// Their names.
        names: String,
        /// How many the model gives.
        found: usize,
    },
    /// A reading or column that is no number.
    #[error("point {point} of run {run} gives no finite {what}; mark it in the recording or remove it")]
    NotFinite {
        /// Index of the point.
        point: usize,
        /// Name of the run.
        run: String,
        /// `reading` or `prediction`.
        what: &'static str,
    },
    /// More unknowns than readings.
    #[error("{rows} readings are too few to determine {determined} parameters; measure more poses")]
    TooFewReadings {
        /// Scalar readings.
        rows: usize,
        /// Parameters the design could determine.
        determined: usize,
    },
    /// Gauss–Newton did not converge.
    #[error(
        "the fit did not converge in {steps} steps (last change {change_mm:e} mm); errors beyond a few degrees \
         are outside the model: check the setup's ball position, the machine file and the turning senses"
    )]
    NotConverged {
        /// Steps done.
        steps: usize,
        /// Last change of the prediction, mm.
        change_mm: f64,
    },
    /// The fit converged to a number that no machine has.
    #[error(
        "the fit gives {name} of {effect} = {value:.3e} {unit}, which no machine has. \
         Check the setup's ball position, the machine file and the turning senses, or remove {effect} from the model"
    )]
    Impossible {
        /// Effect id.
        effect: String,
        /// The parameter.
        name: String,
        /// Its value on screens.
        value: f64,
        /// Unit on screens.
        unit: &'static str,
    },
}

impl IdentifyError {
    /// Of an effect that has no parameter in this scene.
    pub fn out_of_reach(instance: &Instance, scene: &Scene) -> Self {
        let why = instance.out_of_reach(scene).unwrap_or_else(|| "has no parameter here".into());
        Self::OutOfReach { effect: instance.id(), why }
    }
}
