//! What waves along the axes: periods, and the spectrum of what a model leaves.

use crate::number::finite;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_engine as engine;

/// Points of a curve that are kept; of several frequencies the highest.
const MOST_POINTS: usize = 400;

/// How an effect repeats along an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Period {
    /// Period, or cycles a turn.
    pub value: f64,
    /// `mm` or `per turn`.
    pub unit: String,
    /// Standard uncertainty.
    pub u: f64,
    /// The known part of the machine that repeats so, e.g. `lead/4`; null when none does.
    pub is: Option<String>,
    /// Amplitude, µm of a shift or µrad of a turn, where one motion waves.
    pub amplitude: Option<f64>,
    /// The first of what gives the same readings on this even grid of positions; null where positions are uneven.
    pub alias: Option<f64>,
}

/// The spectrum of what the model leaves along one axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisSpectrum {
    /// The axis.
    pub axis: String,
    /// Unit of `curve` and `limit`: `mm` (a period) or `per turn`.
    pub unit: String,
    /// Residual of the readings used, µm rms.
    pub rms_um: f64,
    /// Shortest period, or most cycles a turn, of the curve: what positions as far apart as these show as it is, or the finest of `waves`.
    pub limit: f64,
    /// Period or cycles a turn, and the wave there, µm rms; of long spectra the highest of neighbours.
    pub curve: Vec<[f64; 2]>,
    /// Waves that stand out, largest first.
    pub waves: Vec<SpectrumWave>,
    /// Whether the positions suffice to say that nothing else stands out.
    #[serde(default = "judged")]
    pub judged: bool,
}

/// As an answer of before had it, which did not say.
fn judged() -> bool {
    true
}

impl AxisSpectrum {
    /// The highest of the curve: period or cycles a turn, and µm rms; `None` of an empty one.
    pub fn highest(&self) -> Option<[f64; 2]> {
        self.curve.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1]))
    }
}

/// A wave that stands out of a spectrum.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpectrumWave {
    /// How it repeats.
    pub period: Period,
    /// Its size in the readings, µm rms.
    pub rms_um: f64,
    /// What remains with it and those before it in the model, µm rms.
    pub rms_um_after: f64,
    /// The same in words.
    pub words: String,
}

impl From<&engine::spectrum::Wave> for Period {
    fn from(wave: &engine::spectrum::Wave) -> Self {
        Self {
            value: wave.value,
            unit: wave.unit.into(),
            u: wave.u,
            is: wave.is.clone(),
            amplitude: wave.amplitude.and_then(finite),
            alias: wave.alias.and_then(finite),
        }
    }
}

impl From<&engine::spectrum::AxisSpectrum> for AxisSpectrum {
    fn from(spectrum: &engine::spectrum::AxisSpectrum) -> Self {
        let together = spectrum.curve.len().div_ceil(MOST_POINTS).max(1);
        let highest = |part: &[(f64, f64)]| {
            let (value, rms_um) = part.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
            [value, rms_um]
        };
        Self {
            axis: spectrum.joint.as_str().into(),
            unit: if spectrum.joint.is_rotary() { "per turn" } else { "mm" }.into(),
            rms_um: spectrum.rms_um,
            limit: spectrum.limit,
            curve: spectrum.curve.chunks(together).map(highest).collect(),
            waves: spectrum.waves.iter().map(SpectrumWave::from).collect(),
            judged: spectrum.judged,
        }
    }
}

impl From<&engine::spectrum::Wave> for SpectrumWave {
    fn from(wave: &engine::spectrum::Wave) -> Self {
        Self {
            period: wave.into(),
            rms_um: wave.rms_um,
            rms_um_after: wave.rms_um_after,
            words: wave.words(),
        }
    }
}
