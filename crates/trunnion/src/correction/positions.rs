//! Whether recorded positions hold a correction: positions of the drives do, commanded ones do not.
//!
//! p = p₀ − s Δ at positions of the drives, p₀ where the nominal machine brings ball and nest together, Δ the errors in the file [docs/use/correct.md].
//! Readings about p₀ then show 1 − k of the correction, about p they show 1 − k + s: s is the share that stands in the positions.
//! Limits: R-tests alone; a bar does not say where across it the tool was commanded.

use super::nest_cycle::cycle;
use crate::Experiment;
use trunnion_core::{AxisValues, InstrumentKind, Joint};
use trunnion_results::PositionShare;

/// Farther from where ball and nest come together it was not commanded to be there: a ball is set by hand to 1 mm.
const FOLLOWS_MM: f64 = trunnion_core::setup::SET_BY_HAND_MM;
/// Less of the correction in the positions changes no verdict, which allow a quarter.
const LEAST_SHARE: f64 = 0.1;
/// Standard uncertainties of a share that is not zero: 3 of them are exceeded by chance once in 370.
const SURE: f64 = 3.0;

/// The points with the linear axes where the nominal machine brings ball and nest together; `None` where that is not known.
pub(super) fn commanded(runs: &Experiment) -> Option<trunnion_engine::Experiment> {
    let mut points = runs.points().clone();
    let machine = points.machine().clone();
    for setup in 0..points.setups.len() {
        if points.setups[setup].instrument != InstrumentKind::RTest {
            return None;
        }
        let follows = cycle(runs, &points.setups[setup], Vec::new());
        for point in points.points.iter_mut().filter(|point| point.state.setup == setup) {
            let recorded = point.state.position;
            let mut rotary = recorded;
            Joint::LINEAR.into_iter().for_each(|letter| rotary[letter] = 0.0);
            let commanded: AxisValues<f64> = follows.position(&machine, 0, &rotary)?;
            let off = |letter: Joint| commanded[letter] - recorded[letter];
            if Joint::LINEAR.into_iter().map(off).fold(0.0, f64::hypot) > FOLLOWS_MM {
                return None;
            }
            point.state.position = commanded;
        }
    }
    Some(points)
}

/// The share s and its standard uncertainty; counted where it is sure and not small.
pub(super) fn position_share(share: f64, u: f64) -> PositionShare {
    PositionShare { share, u, counted: share.abs() > LEAST_SHARE.max(SURE * u) }
}
