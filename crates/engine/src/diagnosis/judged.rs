//! The answer of a diagnosis in one word, and what it stands on: as computed here, so shown and written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The answer of a diagnosis in one word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// An effect of the catalogue explains the residual: the first candidate.
    MissingEffect,
    /// The residual has structure that no effect of the catalogue explains as well as an expression does.
    UnnamedStructure,
    /// Nothing above the noise: repeats show the repeatability, the residual is no larger than they allow, and no pattern larger than the
    /// repeatability comes back.
    NoiseFloor,
    /// These data cannot say; `why` says what is missing.
    Undecided,
    /// The run is not whole or not plausible, or the diagnosis failed.
    #[default]
    NotJudged,
}

/// An effect that these data neither show nor exclude.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OpenEffect {
    /// Effect id.
    pub effect: String,
    /// log₁₀ of the Bayes factor against noise only, before any prior.
    pub evidence: f64,
}

/// What the noise learned from the readings of a run consists of, µm rms per component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LearnedNoise {
    /// What differs from reading to reading.
    pub white_um: f64,
    /// Offsets from pass to pass, and of mountings.
    pub passes_um: f64,
    /// Scatter when an axis is positioned again.
    pub stations_um: f64,
    /// Slow wandering.
    pub drift_um: f64,
    /// A pattern over the poses that comes back.
    pub pattern_um: f64,
}

impl Verdict {
    /// The word in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::MissingEffect => "missing-effect",
            Self::UnnamedStructure => "unnamed-structure",
            Self::NoiseFloor => "noise-floor",
            Self::Undecided => "undecided",
            Self::NotJudged => "not-judged",
        }
    }

    /// True where nothing but noise remains, or nothing was judged.
    pub fn blames_no_place(self) -> bool {
        matches!(self, Self::NoiseFloor | Self::NotJudged)
    }
}
