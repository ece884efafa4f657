//! Positions that leave the path of the ball while the readings do not show it.
//!
//! With nominal kinematics a ball stays in its nest. Where recorded positions leave that path, the ball leaves its nest as far, and the
//! readings hold it: of the part n of the nominal readings that no location error and no setting takes up, they hold the share
//! s = n·y/n·n = 1. Where s is 0, the axes were never at these positions.

use super::claim::off_mm;
use super::digits::Digits;
use super::fitted::rms;
use super::found::Implausible;
use super::looked::Looked;
use crate::noise::learned::display::nominal_readings_mm;
use nalgebra::{DVector, Vector3};
use trunnion_core::convert::um_from_mm;
use trunnion_core::{Joint, Point, statistics};
use trunnion_cycles::{Run, RunKind};

/// Positions with three decimals of a millimetre, as controls show them, hide 1 µm/√12 = 0.3 µm; with two they hide 2.9 µm. Between them, µm.
pub(super) const HIDDEN_UM: f64 = 1.0;
/// Shares nearer to 0 than to 1 by so many standard deviations are none.
const SURE: f64 = 3.0;
/// A point is off the path where it is off by this share of the farthest.
const OFF: f64 = 0.5;
/// The finest step of rounded positions, mm; finer ones hide less than [`HIDDEN_UM`].
const FINEST_STEP_MM: f64 = 0.01;

/// Positions of a run at rest that its readings do not show.
pub(super) fn left(looked: &Looked) -> Option<Implausible> {
    let Looked { run, experiment, model, .. } = looked;
    let of_probes = run
        .setups
        .iter()
        .all(|setup| setup.instrument.deflects_probes() && setup.instrument.components().len() == 3);
    if run.kind != RunKind::Static || !of_probes {
        return None;
    }
    let off = model.left_mm(&nominal_readings_mm(experiment));
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
        ..rounded(run, &off).unwrap_or_else(|| elsewhere(looked, [now_um, left_um]))
    })
}

/// Every position of the linear axes is a multiple of one step, and none of a finer one is needed to write them.
fn rounded(run: &Run, off: &DVector<f64>) -> Option<Implausible> {
    let linear: Vec<Joint> = run.machine.linear_joints();
    let positions =
        run.points.iter().flat_map(|point| linear.iter().map(|&joint| point.state.position[joint]));
    let step_mm = Digits::of(positions).step().filter(|step_mm| *step_mm >= FINEST_STEP_MM)?;
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

fn elsewhere(looked: &Looked, [now_um, left_um]: [f64; 2]) -> Implausible {
    let run = looked.whole;
    let mut apart_mm = apart_mm(run);
    let mut off = off_rows(&apart_mm);
    if off.rows.len() == apart_mm.len() {
        // All of them: what they have in common is a setting.
        less_the_usual(&mut apart_mm, run.setups.len());
        off = off_rows(&apart_mm);
    }
    let [first, last] = [off.rows.first(), off.rows.last()].map(|row| row.copied().unwrap_or_default());
    Implausible {
        finding: format!(
            "{}: by their positions, ball and nest move up to {:.0} µm apart (most in rows {first} to {last}), and the readings do not show it.",
            run.name,
            um_from_mm(off.farthest_mm)
        ),
        hypothesis: format!(
            "With the axes on the path of the ball {left_um:.1} µm rms are left, not {now_um:.1}. Another zero or work offset, or positions of other \
             poses: check the positions of these rows."
        ),
        rms_um_with_it: None,
    }
}

/// From ball to nest by the position of a good point.
struct Apart {
    /// Counted from 1.
    row: usize,
    setup: usize,
    mm: Vector3<f64>,
}

fn apart_mm(run: &Run) -> Vec<Apart> {
    let good = (1..).zip(&run.points).filter(|(_, point)| point.is_good());
    let apart = |(row, Point { state, .. }): (usize, &Point)| Apart {
        row,
        setup: state.setup,
        mm: off_mm(&run.machine, &run.setups[state.setup], &state.position),
    };
    good.map(apart).collect()
}

/// Takes off the median of each setup.
fn less_the_usual(apart: &mut [Apart], setups: usize) {
    for setup in 0..setups {
        let own: Vec<Vector3<f64>> = apart.iter().filter(|of| of.setup == setup).map(|of| of.mm).collect();
        let usual = |k: usize| statistics::median(&own.iter().map(|mm| mm[k]).collect::<Vec<_>>());
        let usual_mm = Vector3::from([0, 1, 2].map(|k| usual(k).unwrap_or(0.0)));
        apart.iter_mut().filter(|of| of.setup == setup).for_each(|of| of.mm -= usual_mm);
    }
}

/// Rows that are far off, and how far the farthest is.
struct Off {
    farthest_mm: f64,
    rows: Vec<usize>,
}

fn off_rows(apart: &[Apart]) -> Off {
    let farthest_mm = apart.iter().map(|of| of.mm.norm()).fold(0.0, f64::max);
    let rows = apart.iter().filter(|of| of.mm.norm() > OFF * farthest_mm).map(|of| of.row).collect();
    Off { farthest_mm, rows }
}
