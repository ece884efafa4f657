//! The spectrum of a residual along each axis: waves of any period, whole or broken, with the uncertainty of the period.
//!
//! At every frequency the waves cos ωq, sin ωq of the motions of an axis are fitted next to the model to the positions as they were
//! measured: no grid is assumed [Lomb 1976, Scargle 1982]. The largest is refined,
//! taken into the model, and the next one looked for (docs/design/statistics.md §8).
//!
//! A wave counts when it exceeds what the neighbouring frequencies hold: a residual that wanders is large at all low frequencies alike
//! [Vaughan 2005].

mod band;
pub(crate) mod left;
mod moments;
pub(crate) mod shapes;
mod sources;
mod transform;
pub(crate) mod wave;
mod words;

use crate::Experiment;
use crate::IdentifyError;
use crate::noise::machine_noise::unit_columns;
use crate::problem::Problem;
use band::{Band, OVERSAMPLING};
use left::Left;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use trunnion_core::Joint;
use trunnion_core::convert::{um_from_mm, urad_from_rad};
use trunnion_effects::{FixedText, Instance, fixed_text};
use trunnion_machine::{Axis, Site};
use wave::{Explained, Waves};

/// Waves of one axis that are listed, at most.
const MOST_WAVES: usize = 4;
/// A wave is listed when chance shows one as high less often than once in e³ = 20 spectra, as every other price of this program.
const PRICE_LN: f64 = 3.0;
/// Frequencies on either side that show the background of one.
const NEIGHBOURS: usize = 24;
/// Harmonics of a wave that are looked for by name.
const HARMONICS: u32 = 4;

/// The spectrum of what a model leaves along one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSpectrum {
    /// The axis.
    pub joint: Joint,
    /// Root mean square of all readings used, µm.
    pub rms_um: f64,
    /// Period (mm) or cycles a turn, and root mean square over the readings of the wave there, µm; in the order of frequency.
    pub curve: Vec<(f64, f64)>,
    /// Waves that stand out, largest first.
    pub waves: Vec<Wave>,
    /// Whether there are frequencies enough to say that none stands out: few positions have few, and no background shows among them.
    pub judged: bool,
    /// Shortest period (mm) or most cycles a turn of `curve`: what positions as far apart as these show as it is, or the finest of `waves`,
    /// where uneven positions show a finer one.
    pub limit: f64,
}

/// A wave found along an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wave {
    /// Period, mm, or cycles a turn.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// `mm` or `per turn`.
    #[serde(deserialize_with = "fixed_text")]
    pub unit: FixedText,
    /// Amplitude where one motion waves: µm of a shift, µrad of a turn.
    pub amplitude: Option<f64>,
    /// Root mean square over all readings, µm.
    pub rms_um: f64,
    /// Root mean square of the residual with this wave and those before it in the model, µm.
    pub rms_um_after: f64,
    /// −ln of the probability that chance shows a wave as high anywhere in the spectrum.
    pub evidence_ln: f64,
    /// The known part that has this period, e.g. `lead/4`.
    pub is: Option<String>,
    /// The first period (mm) or cycles a turn of those that give the same readings on this grid.
    pub alias: Option<f64>,
}

/// The spectra of what the model of a problem leaves, of every axis that stood at enough positions.
///
/// # Errors
/// A model whose columns cannot be formed.
pub fn spectra(problem: &Problem<'_>) -> Result<Vec<AxisSpectrum>, IdentifyError> {
    let left = Left::of(problem)?;
    let own = moved_by_themselves(&left).filter_map(|axis| AxisSpectrum::of(&left, axis));
    Ok(own.collect())
}

/// Rotary axes, and linear axes that do not only follow a rotary one.
fn moved_by_themselves(left: &Left) -> impl Iterator<Item = &Axis> {
    let machine = left.experiment.machine();
    let scene = &left.experiment.scene;
    let turning = machine.rotary_joints().into_iter().any(|joint| scene.moves(joint));
    machine
        .axes()
        .filter(move |axis| axis.letter.is_rotary() || !turning || scene.measures_volume(axis.letter))
}

/// Waves that stand out along axes which moved by themselves, or through enough positions: those that a term without a name may follow.
pub(crate) fn free_waves(left: &Left) -> Vec<(Joint, Wave)> {
    let fine = |axis: &&Axis| left.distinct_positions(axis.letter) >= FINE;
    let spectra = moved_by_themselves(left).filter(fine).filter_map(|axis| AxisSpectrum::of(left, axis));
    spectra.flat_map(|spectrum| spectrum.waves.into_iter().map(move |wave| (spectrum.joint, wave))).collect()
}

/// Positions below which the few whole waves that an axis can show are all in the catalogue.
const FINE: usize = 24;

impl AxisSpectrum {
    fn of(left: &Left, axis: &Axis) -> Option<Self> {
        let experiment = &left.experiment;
        let joint = axis.letter;
        let position = experiment.positions(joint);
        let band = Band::of(position.iter().copied())?;
        let rows = experiment.rows();
        let carriers = carriers(experiment, joint);
        if carriers.ncols() == 0 {
            return None;
        }
        let lobes = band.lobes(&position);
        let mut waves = Waves::new(position, carriers, left.basis.clone(), left.residual_mm.clone());
        let units = Units { axis, readings: rows.max(1) as f64 };
        let first = waves.scan(&band);
        let mut spectrum = Self {
            joint,
            rms_um: units.rms_um(waves.residual_mm.norm_squared()),
            curve: first
                .iter()
                .map(|(omega, explained)| (units.value(*omega), units.rms_um(explained.sum)))
                .collect(),
            waves: Vec::new(),
            judged: true,
            limit: 0.0,
        };
        let mut scanned = first;
        while spectrum.waves.len() < MOST_WAVES {
            // What is slower than the band, a drift, comes back at a lobe: no wave of its own.
            scanned.retain(|(omega, _)| lobes.iter().all(|lobe| (omega - lobe).abs() > band.low()));
            let Some((omega, next)) = next(&waves, &scanned, &band, &spectrum.waves, &units) else { break };
            let before = waves;
            waves = before.clone().without(omega);
            scanned = waves.scan(&band);
            let Some(background) =
                background(&scanned, omega, band.resolution(), next.explained.directions as f64)
            else {
                spectrum.judged = !spectrum.waves.is_empty();
                break;
            };
            let evidence_ln = evidence_ln(next.explained, background) - next.tries.ln();
            if evidence_ln < PRICE_LN {
                break;
            }
            spectrum.waves.push(units.wave(&before, &waves, omega, next.explained, evidence_ln, &band));
        }
        // Beyond half a lobe the waves before it come back.
        let nyquist = lobes.first().map_or(f64::INFINITY, |lobe| 0.5 * lobe).min(band.nyquist());
        spectrum.end(&units, nyquist);
        Some(spectrum)
    }

    /// Ends the curve at an angular frequency, or behind the last wave.
    fn end(&mut self, units: &Units<'_>, nyquist: f64) {
        let finest = self.waves.iter().map(Wave::omega).fold(nyquist, f64::max);
        self.limit = units.value(finest);
        self.curve.retain(|(value, _)| units.omega(*value) <= finest);
    }
}

impl Wave {
    /// That of an effect of the catalogue at the shape fitted; `None` where it does not wave.
    pub(crate) fn of_effect(left: &Left, instance: &Instance, shape: &[f64]) -> Option<Self> {
        let repeats = instance.shapes(&left.experiment.scene).wave?;
        let axis = left.experiment.machine().axis(repeats.joint())?;
        let waves = left.waves(instance, repeats);
        let band = Band::of(waves.position.iter().copied())?;
        let omega = repeats.number(*shape.first()?);
        let explained = waves.explained(omega);
        let after = waves.clone().without(omega);
        let units = Units { axis, readings: waves.position.len().max(1) as f64 };
        Some(units.wave(&waves, &after, omega, explained, f64::INFINITY, &band))
    }

    /// Angular frequency, rad per mm or per rad.
    pub(crate) fn omega(&self) -> f64 {
        if self.unit == "mm" { TAU / self.value } else { self.value }
    }
}

/// The next wave to look at.
struct Next {
    explained: Explained,
    /// How many independent frequencies were looked at.
    tries: f64,
}

/// The highest peak, or a harmonic of a wave that was found already: of these there are few, so that smaller ones count.
fn next(
    waves: &Waves,
    scanned: &[(f64, Explained)],
    band: &Band,
    found: &[Wave],
    units: &Units<'_>,
) -> Option<(f64, Next)> {
    let (highest, _) = scanned.iter().max_by(|a, b| a.1.sum.total_cmp(&b.1.sum))?;
    let omega = waves.refined(*highest, band);
    let any = Next { explained: waves.explained(omega), tries: band.independent() };
    let harmonics = found.iter().take(1).flat_map(|wave| {
        let fundamental = units.omega(wave.value);
        (2..=HARMONICS).map(move |k| f64::from(k) * fundamental).filter(|omega| *omega < band.high())
    });
    let near = |a: f64, b: f64| (a - b).abs() < band.resolution();
    for harmonic in harmonics {
        if near(harmonic, omega) {
            return Some((
                harmonic,
                Next { explained: waves.explained(harmonic), tries: f64::from(HARMONICS - 1) },
            ));
        }
    }
    Some((omega, any))
}

/// −ln of the probability of `explained` where one direction explains `background`, mm²: Chernoff's bound of χ² with d degrees of freedom,
/// ½ (x − d − d ln (x/d)).
fn evidence_ln(explained: Explained, background: f64) -> f64 {
    let d = explained.directions as f64;
    if explained.directions == 0 {
        return f64::NEG_INFINITY;
    }
    let x = explained.sum / background.max(f64::MIN_POSITIVE);
    if x > d { 0.5 * (x - d - d * (x / d).ln()) } else { 0.0 }
}

/// What one direction explains at a frequency where nothing waves, mm²: a power law through its neighbours, at the upper end of its
/// 95 % interval. `rest`: a spectrum without the wave. `None` where too few neighbours show it.
///
/// ln of χ²_d/d has mean −1/d − 1/(3d²) [ψ(d/2) − ln(d/2), Abramowitz 1964 §6.3.18].
fn background(rest: &[(f64, Explained)], omega: f64, resolution: f64, d: f64) -> Option<f64> {
    let at = rest.partition_point(|(other, _)| *other < omega);
    let around = &rest[at.saturating_sub(NEIGHBOURS)..(at + NEIGHBOURS).min(rest.len())];
    // Next to the wave itself nothing is left once it is in the model.
    let seen = around
        .iter()
        .filter(|(other, e)| (other - omega).abs() > resolution && e.directions > 0 && e.sum > 0.0);
    let logs: Vec<(f64, f64)> =
        seen.map(|(other, e)| ((other / omega).ln(), (e.sum / e.directions as f64).ln())).collect();
    let count = logs.len() as f64;
    if logs.len() < FEWEST_NEIGHBOURS {
        return None;
    }
    let (mean_x, mean_y) = logs.iter().fold((0.0, 0.0), |(x, y), log| (x + log.0 / count, y + log.1 / count));
    let (xx, xy) = logs.iter().fold((0.0, 0.0), |(xx, xy), log| {
        (xx + (log.0 - mean_x).powi(2), xy + (log.0 - mean_x) * (log.1 - mean_y))
    });
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    let scatter = logs.iter().map(|log| (log.1 - mean_y - slope * (log.0 - mean_x)).powi(2)).sum::<f64>()
        / (count - 2.0);
    // Only every OVERSAMPLING-th of the neighbours is independent.
    let leverage = OVERSAMPLING * (1.0 / count + if xx > 0.0 { mean_x * mean_x / xx } else { 0.0 });
    let upper = mean_y - slope * mean_x + UPPER * (scatter * leverage).sqrt();
    Some((upper + 1.0 / d + 1.0 / (3.0 * d * d)).exp())
}

/// One-sided 95 % of a normal law.
const UPPER: f64 = 1.645;
/// A line needs two points, and some to scatter about it.
const FEWEST_NEIGHBOURS: usize = 8;

/// Motions of an axis that may wave, as the instrument sees them: those that look different to it.
fn carriers(experiment: &Experiment, joint: Joint) -> DMatrix<f64> {
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for component in 0..6 {
        let column = unit_columns(experiment, Site::Joint(joint), component);
        // A linear axis of a rigid machine shifts alike everywhere: turns of its own come after shifts and may repeat them.
        let same =
            |other: &DVector<f64>| other.dot(&column).abs() >= SAME_MOTION * other.norm() * column.norm();
        if column.norm() > 1e-9 && !columns.iter().any(same) {
            columns.push(column);
        }
    }
    if columns.is_empty() { DMatrix::zeros(experiment.rows(), 0) } else { DMatrix::from_columns(&columns) }
}

/// Cosine above which two motions of an axis look the same to the instrument.
const SAME_MOTION: f64 = 0.999;

/// Frequencies of an axis in the units of people.
struct Units<'a> {
    axis: &'a Axis,
    readings: f64,
}

impl Units<'_> {
    fn is_rotary(&self) -> bool {
        self.axis.letter.is_rotary()
    }

    /// Period in mm, or cycles a turn; its own inverse.
    fn value(&self, omega: f64) -> f64 {
        if self.is_rotary() { omega } else { TAU / omega }
    }

    fn omega(&self, value: f64) -> f64 {
        self.value(value)
    }

    fn rms_um(&self, sum: f64) -> f64 {
        um_from_mm((sum / self.readings).sqrt())
    }

    fn wave(
        &self,
        before: &Waves,
        after: &Waves,
        omega: f64,
        explained: Explained,
        evidence_ln: f64,
        band: &Band,
    ) -> Wave {
        let left = after.residual_mm.norm_squared();
        let freedom = (self.readings - after.basis.ncols() as f64).max(1.0);
        let u_omega = before.u(omega, left / freedom * repeats(&after.residual_mm), band);
        let value = self.value(omega);
        let (u, unit) =
            if self.is_rotary() { (u_omega, "per turn") } else { (value * u_omega / omega, "mm") };
        let is = if self.is_rotary() {
            sources::of_cycles(self.axis, value, u)
        } else {
            sources::of_period_mm(self.axis, value, u)
        };
        let amplitude = (before.carriers.ncols() == 1).then(|| {
            let (cos, sin) = before.amplitudes(omega)[0];
            let size = f64::hypot(cos, sin);
            if self.is_rotary() { urad_from_rad(size) } else { um_from_mm(size) }
        });
        Wave {
            value,
            u,
            unit,
            amplitude,
            rms_um: self.rms_um(explained.sum),
            rms_um_after: self.rms_um(left),
            evidence_ln,
            is,
            alias: band.alias(omega).map(|omega| self.value(omega)),
        }
    }
}

/// How many neighbours err alike: (1 + ρ)/(1 − ρ), ρ the correlation of neighbouring residuals [Bartlett 1946].
fn repeats(residual: &DVector<f64>) -> f64 {
    let squares = residual.norm_squared();
    let products: f64 = residual.as_slice().windows(2).map(|pair| pair[0] * pair[1]).sum();
    let rho = if squares > 0.0 { (products / squares).clamp(0.0, MOST_CORRELATED) } else { 0.0 };
    (1.0 + rho) / (1.0 - rho)
}

/// Neighbours that are more alike than this are one.
const MOST_CORRELATED: f64 = 0.98;
