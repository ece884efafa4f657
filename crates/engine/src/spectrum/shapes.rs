//! Shape numbers of effects that wave: what the residual shows, next to what the catalogue knows.

use super::band::Band;
use super::wave::Waves;
use nalgebra::DMatrix;
use trunnion_effects::WaveNumber;

/// Peaks that are tried.
const MOST_PEAKS: usize = 4;
/// Slowest wave of a rotary axis that is one of its drive, cycles a turn: one and two a turn are those of its axis and encoder.
const SLOWEST_CYCLES: f64 = 2.5;

/// What a residual shows for one effect.
pub(crate) struct Found {
    /// Shapes to try next to those of the catalogue, the highest peak first.
    pub shapes: Vec<Vec<f64>>,
    /// Independent values that they were chosen from.
    pub tries: f64,
}

/// Peaks of the spectrum of one effect; `None` where positions show no wave, or nothing moves.
pub(crate) fn found(repeats: WaveNumber, waves: &Waves) -> Option<Found> {
    let band = Band::of(waves.position.iter().copied())?;
    if waves.carriers.ncols() == 0 {
        return None;
    }
    let usual = |omega: &f64| matches!(repeats, WaveNumber::Period(_)) || *omega >= SLOWEST_CYCLES;
    let peaks = waves.peaks(&band, MOST_PEAKS).into_iter().filter(usual);
    Some(Found {
        shapes: peaks.map(|omega| vec![repeats.number(omega)]).collect(),
        tries: band.independent(),
    })
}

/// The motions that wave, from the columns of an effect with a wave of no frequency: cosines are one, sines nothing.
pub(crate) fn carriers(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let moving: Vec<usize> = (0..columns.ncols()).filter(|&j| columns.column(j).norm() > 0.0).collect();
    columns.select_columns(&moving)
}

/// The shape number of a wave of no frequency.
pub(crate) fn at_rest(wave: WaveNumber) -> Vec<f64> {
    vec![wave.number(0.0)]
}
