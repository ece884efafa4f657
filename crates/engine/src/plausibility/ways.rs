//! One stated direction of an axis that went both ways: do the readings differ by the way it went?
//!
//! Every pose may have been approached from one side, as stated. Then the readings do not ask which way the axis went from pose to pose,
//! and the fit doubts the column (`fit::doubts`). Where they do, the directions were never filled in, and play of the axis would be taken
//! for something else.

use super::fitted::{Fitted, columns};
use super::found::{Implausible, plain};
use super::looked::{thinned, with_points};
use crate::Experiment;
use crate::evidence::joined;
use crate::problem::steps::one_direction;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::signed;
use trunnion_core::{Joint, Point};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{Instance, ModelEffect};

/// Share of the mean square left by the base model that play by the way of the axis takes away: noise leaves its few columns a hundredth.
/// A judgement, tuned on no data.
const TAKEN_SHARE: f64 = 0.25;

/// Axes of which the readings know the way, and the column does not.
pub(super) fn not_filled_in(run: &Run) -> Vec<Implausible> {
    if run.kind != RunKind::Static {
        return Vec::new();
    }
    run.machine.joints().into_iter().filter_map(|joint| of_joint(run, joint)).collect()
}

fn of_joint(run: &Run, joint: Joint) -> Option<Implausible> {
    let doubted = one_direction(&run.points, joint)?;
    let [without_mm, with_mm] = left_mm(run, joint)?;
    (with_mm.powi(2) < (1.0 - TAKEN_SHARE) * without_mm.powi(2)).then(|| {
        let column = format!("direction_{}", joint.lower());
        let [contrary, count] = doubted.contrary;
        plain(
            format!(
                "{}: {column} is always {}, but {joint} moves the opposite way in {contrary} of {count} steps, and the readings know the way: \
                 play of {joint} by it leaves {:.1} µm instead of {:.1}.",
                run.name,
                signed(doubted.stated, 0),
                um_from_mm(with_mm),
                um_from_mm(without_mm),
            ),
            &format!("The directions were never filled in. Give {column} as the axis moved, or 0 where it is not known."),
        )
    })
}

/// What the base model leaves without and with play of an axis whose directions are its ways, rms.
fn left_mm(run: &Run, joint: Joint) -> Option<[f64; 2]> {
    let mut points: Vec<Point> = thinned(run).into_iter().cloned().collect();
    let position = |point: &Point| point.state.position[joint];
    for at in 1..points.len() {
        let moved = position(&points[at]) - position(&points[at - 1]);
        // An axis that stays keeps the side from which it came.
        points[at].state.direction[joint] =
            if moved == 0.0 { points[at - 1].state.direction[joint] } else { moved.signum() };
    }
    let experiment = Experiment::of_points(&[with_points(run, points.iter().collect())]).ok()?;
    let entry = ModelEffect { id: format!("backlash:{joint}"), ..ModelEffect::default() };
    let play = Instance::from_model_effect(&entry, experiment.machine()).ok()?;
    let base = columns(&experiment)?;
    let both = joined(&base, &experiment.columns(&play, &[]));
    let readings_mm = experiment.readings_mm();
    Some([base, both].map(|columns| Fitted::on(&columns, |_| true).rms_mm(&readings_mm)))
}
