//! Lengths that were rounded.
//!
//! Those that scatter by half a step or more are rounded up and down by chance, as by noise. Steadier ones err by the same at every visit of
//! a place, which looks like a wave of the axis.

use super::{FINEST_UM, PART_OF_NOISE, Rounded, What};
use crate::noise::learned::display::nominal_readings_mm;
use crate::plausibility::digits::{Digits, significant, significant_step};
use crate::plausibility::looked::Looked;
use crate::plausibility::readings::FEWEST_POINTS;
use trunnion_core::convert::um_from_mm;
use trunnion_core::statistics::rms;
use trunnion_core::{Point, ReadingColumn};
use trunnion_cycles::Run;

/// Digits of a number that nobody rounded are more.
const MOST_DIGITS: i32 = 5;

/// Lengths that were rounded to so much that it is no noise; `None` where they were not, or to too little.
pub(in crate::plausibility) fn rounded_lengths(run: &Run) -> Option<Rounded> {
    let reads_lengths = run.setups.iter().all(|setup| {
        setup.instrument.columns().iter().all(|column| matches!(column, ReadingColumn::Length(_)))
    });
    let is_read = run.points.iter().all(|point| point.samples <= 1);
    if !reads_lengths || !is_read || run.good_points().count() < FEWEST_POINTS {
        return None;
    }
    let read = |point: &Point| {
        let channels = run.setups[point.state.setup].instrument.components().len();
        point.reading_mm[..channels].to_vec()
    };
    let values_mm: Vec<f64> = run.good_points().flat_map(read).collect();
    let (steps_mm, given) = steps_mm(&values_mm)?;
    let step_mm = rms(steps_mm)?;
    let hidden_mm = step_mm / 12f64.sqrt();
    let hidden_um = um_from_mm(hidden_mm);
    if hidden_um < FINEST_UM {
        return None;
    }
    let looked = Looked::at(run)?;
    // A display of one value a target has the distance of the targets as its step: the model leaves less.
    let experiment = &looked.experiment;
    let left_mm = looked.model.rms_mm(&(experiment.readings_mm() - nominal_readings_mm(experiment)));
    let repeated = looked.repeated();
    let scatter_mm = repeated.map_or(left_mm, |repeated| repeated.sigma_mm.min(left_mm));
    let is_pattern = scatter_mm < 0.5 * step_mm && hidden_mm > PART_OF_NOISE * scatter_mm;
    let scatter_um = um_from_mm(scatter_mm);
    is_pattern.then(|| Rounded {
        run: run.name.clone(),
        given,
        hidden_um,
        what: What::Lengths { scatter_um },
    })
}

/// The steps of lengths, and how they are said.
fn steps_mm(values_mm: &[f64]) -> Option<(Vec<f64>, String)> {
    let one = Digits::of(values_mm.iter().copied()).step().filter(|step_mm| um_from_mm(*step_mm) > FINEST_UM);
    if let Some(step_mm) = one {
        return Some((vec![step_mm], format!("in steps of {step_mm} mm")));
    }
    let digits = significant(values_mm, MOST_DIGITS)?;
    let steps_mm: Vec<f64> =
        values_mm.iter().filter(|mm| **mm != 0.0).map(|mm| significant_step(*mm, digits)).collect();
    let coarsest_mm = steps_mm.iter().copied().fold(0.0, f64::max);
    let given =
        format!("with no more than {digits} significant digits, the largest in steps of {coarsest_mm} mm");
    Some((steps_mm, given))
}
