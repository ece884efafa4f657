//! Readings at rest that are some poses late or early, seen by poses that come back: no model is asked.
//!
//! Where a pose is visited on the way there and on the way back, readings that are late belong to the pose before it once and to the one behind
//! it once. They repeat badly, and shifted back as well as the machine does, whatever it does: an effect is at its pose in every visit, or
//! differs with the direction by as much at the next one, which repeatability leaves out. Shifted back they also fit the model better: of 372 good
//! runs of the second simulator two, lines on displays of 0.6 and 1 µm, repeated better with poses two and three rows away. One of them fitted
//! better by 10⁻⁷, the other worse.
//! Where one effect of an axis leaves as little (a backlash of many micrometres), it is believed, not the mistake.
//! Limits: where every pass goes the same way, all visits of a pose hold the same other pose, and repeat.

use super::{BELIEVED, CHANGE, GROSS_UM, MOST_ROWS_LATE, Trial};
use crate::noise::repeatability::repeatability;
use crate::plausibility::found::Implausible;
use crate::plausibility::looked::Looked;
use crate::problem::passes::passes;
use nalgebra::DVector;
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::RunKind;

/// Fewer differences between visits are few enough to agree by chance: with so many a variance is known to a third, √(2/20) [normal distribution].
const FEWEST_DEGREES_OF_FREEDOM: usize = 20;

/// Shifted back readings fit better where the model leaves so many times less: a judgement. A late run of docs/measured/mistakes.md, on a machine that lacks
/// two effects, does not fit better by a quarter.
const BETTER: f64 = 1.01;

pub(in crate::plausibility) fn late(looked: &Looked) -> Option<Implausible> {
    let Looked { run, experiment, model, .. } = looked;
    if run.kind != RunKind::Static {
        return None;
    }
    let passes = passes(experiment);
    let as_given = looked.repeated()?;
    let trial = Trial::of(looked);
    let shifted = |by: usize| trial.late_rows(None, &[0, 1, 2], by);
    let repeats = |(words, rows): (String, DVector<f64>)| {
        let mut moved = experiment.clone();
        for (at, point) in moved.points.iter_mut().enumerate() {
            let own = experiment.rows_of(at).zip(&mut point.reading_mm);
            own.for_each(|(row, reading)| *reading = rows[row]);
        }
        let fits_better = BETTER * model.rms_mm(&rows) < looked.left_mm;
        fits_better.then_some((words, repeatability(&moved, &passes)?))
    };
    let tried = (1..=MOST_ROWS_LATE).flat_map(shifted).filter_map(repeats);
    let (words, best) = tried.min_by(|a, b| a.1.sigma_mm.total_cmp(&b.1.sigma_mm))?;
    let is_late = as_given.degrees_of_freedom.min(best.degrees_of_freedom) >= FEWEST_DEGREES_OF_FREEDOM
        && as_given.sigma_mm > BELIEVED * best.sigma_mm
        && um_from_mm(best.sigma_mm) < GROSS_UM
        && trial.of_an_effect_mm() > BELIEVED * best.sigma_mm;
    is_late.then(|| Implausible {
        finding: format!(
            "{}: readings of one pose repeat within {:.2} µm, worse than with other poses.",
            run.name,
            um_from_mm(as_given.sigma_mm)
        ),
        hypothesis: format!(
            "With the readings {words}, they repeat within {:.2} µm. {CHANGE}",
            um_from_mm(best.sigma_mm)
        ),
        rms_um_with_it: Some(um_from_mm(best.sigma_mm)),
    })
}
