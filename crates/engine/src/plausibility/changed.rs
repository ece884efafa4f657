//! Runs given together between which the machine changed, whatever their poses are: each by itself fits location errors, both together fit none.
//!
//! r: what the base model leaves of both runs, mm rms, with location errors in common and settings of each run (Experiment keeps setups of
//! different runs apart); r₁: what it leaves with location errors of each run. √(r² − r₁²) is what no common location errors make. It needs no
//! location error that both runs determine by itself, as a comparison of values does: runs of other poses determine other sums of them.
//! Limits: what a day changes, and errors of angles that move the ball less than that. Poses that share no location error show nothing; fitted together
//! they invent nothing either.

use super::exchanged::{AS_GOOD, BELIEVED};
use super::fitted::{Fitted, columns};
use super::looked::Looked;
use super::readings::FEWEST_POINTS;
use crate::Experiment;
use trunnion_core::convert::um_from_mm;
use trunnion_core::statistics::mean;
use trunnion_cycles::Run;

/// Smaller differences of location errors are those of days: so many K move the end of half a metre of steel by 12 µm.
pub(super) const BEYOND_DAYS_UM: f64 = 12.0;
const DAYS_K: f64 = 2.0;
/// What a line of an axis that lies elsewhere makes of readings, root mean square over their three components: as far as it lies, shared between
/// two of them by the turning table. 1/√3; the setting takes up what does not turn.
const OF_READINGS: f64 = 0.577;

/// What the base model leaves of two runs, µm rms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remainders {
    /// With location errors in common.
    pub together_um: f64,
    /// With those of each run.
    pub apart_um: f64,
}

/// Two runs that have no location errors in common; `None` where they have, or where one error of an axis explains as much.
pub(super) fn changed(runs: [&Run; 2]) -> Option<Remainders> {
    let looked = runs.map(Looked::at);
    let [Some(first), Some(second)] = &looked else { return None };
    if [first, second].iter().any(|looked| looked.run.points.len() < FEWEST_POINTS) {
        return None;
    }
    let experiment = Experiment::of_points(&[&first.run, &second.run]).ok()?;
    let (model, readings_mm) = (Fitted::new(&experiment)?, experiment.readings_mm());
    let mut of_second = columns(&experiment)?;
    for (at, run) in experiment.run_of_point.iter().enumerate() {
        let share = *run as f64;
        experiment.rows_of(at).for_each(|row| of_second.row_mut(row).scale_mut(share));
    }
    let together_mm = model.rms_mm(&readings_mm);
    let apart_mm = model.rms_with_mm(&of_second, &readings_mm);
    let made_um = um_from_mm((together_mm.powi(2) - apart_mm.powi(2)).max(0.0).sqrt());
    let days = (warmer_k(runs) / DAYS_K).max(1.0);
    let is_changed = made_um > OF_READINGS * BEYOND_DAYS_UM * days
        && together_mm > BELIEVED * apart_mm
        && model.rms_with_an_axis_mm(&experiment, |_| true) > AS_GOOD * apart_mm;
    is_changed.then(|| Remainders { together_um: um_from_mm(together_mm), apart_um: um_from_mm(apart_mm) })
}

/// By how much a temperature that both runs know differs between them, the most of them, K.
fn warmer_k([first, second]: [&Run; 2]) -> f64 {
    let of = |run: &Run, channel: &str| {
        let at = run.channels.iter().position(|own| own == channel)?;
        let read = run.good_points().filter_map(|point| point.state.temperature_degc.get(at).copied());
        mean(read.filter(|degc| degc.is_finite()))
    };
    let differs = |channel: &String| Some((of(second, channel)? - of(first, channel)?).abs());
    first.channels.iter().filter_map(differs).fold(0.0, f64::max)
}
