//! Positions that leave the path of the ball while the readings do not show it.
//!
//! With nominal kinematics a ball stays in its nest. Where recorded positions leave that path, the ball leaves its nest as far, and the
//! readings hold it: of the part n of the nominal readings that no location error and no setting takes up, they hold the share
//! s = n·y/n·n = 1. Where s is 0, the axes were never at these positions.

use super::claim::off_mm;
use super::fitted::{Fitted, rms};
use super::found::Implausible;
use crate::Experiment;
use crate::noise::learned::display::nominal_readings_mm;
use nalgebra::DVector;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{Joint, Point};
use trunnion_cycles::{Run, RunKind};

/// Positions with three decimals of a millimetre, as controls show them, hide 1 µm/√12 = 0.3 µm; with two they hide 2.9 µm. Between them, µm.
const HIDDEN_UM: f64 = 1.0;
/// Shares nearer to 0 than to 1 by so many standard deviations are none.
const SURE: f64 = 3.0;
/// A point is off the path where it is off by this share of the farthest.
const OFF: f64 = 0.5;
/// Steps of rounded positions, mm; finer ones hide less than [`HIDDEN_UM`].
const STEPS_MM: [f64; 3] = [1.0, 0.1, 0.01];

/// Positions of a run at rest that its readings do not show.
pub(super) fn left(run: &Run) -> Option<Implausible> {
    let of_probes = run
        .setups
        .iter()
        .all(|setup| setup.instrument.deflects_probes() && setup.instrument.components().len() == 3);
    if run.kind != RunKind::Static || !of_probes {
        return None;
    }
    let experiment = Experiment::of_points(&[run]).ok()?;
    let model = Fitted::new(&experiment)?;
    let off = model.left_mm(&nominal_readings_mm(&experiment));
    if um_from_mm(rms(&off)) < HIDDEN_UM {
        return None;
    }
    let without = model.left_mm(&experiment.readings_mm());
    let share = off.dot(&without) / off.norm_squared();
    let u = rms(&(&without - &off * share)) / off.norm();
    if share.abs() + SURE * u > 0.5 {
        return None;
    }
    let [now_um, left_um] = [&without - &off, without].map(|left| um_from_mm(rms(&left)));
    Some(Implausible {
        rms_um_with_it: Some(left_um),
        ..rounded(run, &off).unwrap_or_else(|| elsewhere(run, [now_um, left_um]))
    })
}

/// Every position of the linear axes is a multiple of one step, and none of a finer one is needed to write them.
fn rounded(run: &Run, off: &DVector<f64>) -> Option<Implausible> {
    let linear: Vec<Joint> = run.machine.linear_joints();
    let is_multiple = |step_mm: f64| {
        let whole = |mm: f64| (mm / step_mm - (mm / step_mm).round()).abs() < 1e-6;
        run.points.iter().all(|point| linear.iter().all(|&joint| whole(point.state.position[joint])))
    };
    let step_mm = STEPS_MM.into_iter().find(|step_mm| is_multiple(*step_mm))?;
    // No farther than rounding takes three axes.
    let farthest_mm = off.amax();
    (farthest_mm < step_mm * 3f64.sqrt()).then(|| Implausible {
        finding: format!(
            "{}: the positions of the linear axes are given in steps of {step_mm} mm, which takes ball and nest up to {:.0} µm apart; the readings do \
             not show it.",
            run.name,
            um_from_mm(farthest_mm)
        ),
        hypothesis: "The positions were rounded when they were written, and hide what is to be found. Give them with four decimals.".into(),
        rms_um_with_it: None,
    })
}

fn elsewhere(run: &Run, [now_um, left_um]: [f64; 2]) -> Implausible {
    let apart =
        |point: &Point| off_mm(&run.machine, &run.setups[point.state.setup], &point.state.position).norm();
    let far_mm: Vec<f64> = run.points.iter().map(apart).collect();
    let farthest_mm = far_mm.iter().copied().fold(0.0, f64::max);
    let off: Vec<usize> = (0..far_mm.len()).filter(|&at| far_mm[at] > OFF * farthest_mm).collect();
    let [first, last] = [off.first(), off.last()].map(|at| at.map_or(0, |at| at + 1));
    Implausible {
        finding: format!(
            "{}: by their positions, ball and nest are up to {:.0} µm apart (most in points {first} to {last}), and the readings do not show it.",
            run.name,
            um_from_mm(farthest_mm)
        ),
        hypothesis: format!(
            "With the axes on the path of the ball {left_um:.1} µm rms are left, not {now_um:.1}. Another zero or work offset, or positions of other \
             poses: check the positions of these points."
        ),
        rms_um_with_it: None,
    }
}
