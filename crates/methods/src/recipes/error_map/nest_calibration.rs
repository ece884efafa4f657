//! Calibration of the nest by known linear steps, where the runs hold them [S1 §3.2].
//!
//! With both rotary axes at rest the linear axes move the ball by commanded steps t; component k of the reading shows
//! `m_k = a_k·t + m_0`: a_k is its direction vector times its gain. All three by least squares; the readings of the setup
//! become `A⁻¹ m`. The spindle's angle is on no recording, so the ball's offset from the spindle line is taken as removed before.
//! Limits: linear axes free of error over the steps; steps that span three directions.

use crate::findings::{Cell, Column, FoundTable};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use trunnion_core::{InstrumentKind, Point, Quality, Slot};
use trunnion_cycles::Run;
use trunnion_effects::Unit;
use trunnion_engine::solve::linear::least_squares;
use trunnion_instruments::predict;
use trunnion_machine::Errors;

/// A ball commanded so far from the nest is a calibration step, mm; further out no probe reaches.
const STEP_MM: std::ops::RangeInclusive<f64> = 0.02..=5.0;
/// Fewest readings of a calibration.
const LEAST_READINGS: usize = 4;

/// What calibrating found.
pub(super) struct Calibration {
    /// Gains and directions; `None` when the runs hold no steps.
    pub table: Option<FoundTable>,
    /// What a reader must know.
    pub note: String,
}

/// The runs with the readings of calibrated setups put right and the calibration steps taken out.
pub(super) fn apply(runs: &[Run]) -> (Calibration, Vec<Run>) {
    let (mut rows, mut unusable, mut calibrated) = (Vec::new(), Vec::new(), Vec::new());
    for run in runs {
        let mut put_right = run.clone();
        put_right.points.retain(|point| !is_step(run, point));
        for (s, setup) in run.setups.iter().enumerate() {
            let Some(steps) = steps(run, s) else { continue };
            let Some(reading_from_step) = reading_from_step(&steps) else {
                unusable.push(format!("{} of run {}", setup.name, run.name));
                continue;
            };
            rows.extend(rows_of(&format!("{} of {}", setup.name, run.name), &reading_from_step));
            let Some(step_from_reading) = reading_from_step.try_inverse() else { continue };
            for point in put_right.points.iter_mut().filter(|point| point.state.setup == s) {
                point.reading_mm = (step_from_reading * Vector3::from(point.reading_mm)).into();
            }
        }
        calibrated.push(put_right);
    }
    let mut note = match rows.is_empty() {
        true => "The runs hold no linear steps at rest, so directions and gains of the probes are taken as calibrated.".to_owned(),
        false => "Directions and gains of the probes were calibrated by the linear steps in the runs, and all readings put right."
            .to_owned(),
    };
    if !unusable.is_empty() {
        note += &format!(
            " The steps of {} do not span three directions and were set aside: move the ball in X, Y and Z.",
            unusable.join(", ")
        );
    }
    note += " No recording holds the angle of the spindle: the ball's offset from the spindle line must be removed before (S1 §3.2).";
    let mut columns = vec![Column::plain("setup"), Column::plain("component"), Column::plain("gain")];
    columns.extend(["x", "y", "z"].map(|axis| Column::plain(format!("direction {axis}"))));
    columns.push(Column::of("angle to its axis", Unit::DEG));
    let caption = "Probe directions and gains by linear steps".into();
    let table = (!rows.is_empty()).then_some(FoundTable { caption, columns, rows });
    (Calibration { table, note }, calibrated)
}

/// True when the ball was commanded off the nest.
fn is_step(run: &Run, point: &Point) -> bool {
    let setup = &run.setups[point.state.setup];
    setup.instrument == InstrumentKind::RTest && STEP_MM.contains(&commanded_mm(run, point).norm())
}

/// Commanded place of the ball relative to the nest, nest axes, mm.
pub(super) fn commanded_mm(run: &Run, point: &Point) -> Vector3<f64> {
    predict(&run.machine, &run.setups[point.state.setup], &point.state, &Errors::default())
}

/// Commanded and read places at the pose of the first step of a setup; `None` without steps.
fn steps(run: &Run, setup: usize) -> Option<Vec<(Vector3<f64>, Vector3<f64>)>> {
    let of_setup = |p: &&Point| p.state.setup == setup && p.quality == Quality::Good;
    let first = run.points.iter().filter(of_setup).find(|point| is_step(run, point))?;
    let same_pose = |p: &&Point| {
        let turned = |letter: Slot| (p.state.position[letter] - first.state.position[letter]).abs();
        Slot::ALL.into_iter().filter(|slot| slot.is_rotary()).all(|slot| turned(slot) < 1e-6)
    };
    let here = run.points.iter().filter(of_setup).filter(same_pose);
    Some(here.map(|p| (commanded_mm(run, p), Vector3::from(p.reading_mm))).collect())
}

/// A of `m = A t + m_0`; `None` when the steps do not span three directions.
fn reading_from_step(steps: &[(Vector3<f64>, Vector3<f64>)]) -> Option<Matrix3<f64>> {
    if steps.len() < LEAST_READINGS {
        return None;
    }
    let design = DMatrix::from_fn(steps.len(), 4, |i, k| if k < 3 { steps[i].0[k] } else { 1.0 });
    let mut matrix = Matrix3::zeros();
    for k in 0..3 {
        let read = DVector::from_fn(steps.len(), |i, _| steps[i].1[k]);
        let fit = least_squares(&design, &read, 1e-6);
        if fit.rank < 4 {
            return None;
        }
        matrix.set_row(k, &fit.x.fixed_rows::<3>(0).transpose());
    }
    Some(matrix)
}

fn rows_of(setup: &str, reading_from_step: &Matrix3<f64>) -> Vec<Vec<Cell>> {
    let row = |k: usize| {
        let vector = reading_from_step.row(k).transpose();
        let (gain, direction) = (vector.norm(), vector.normalize());
        let mut row =
            vec![Cell::Text(setup.into()), Cell::Text(["x", "y", "z"][k].into()), Cell::Number(gain)];
        row.extend(direction.iter().copied().map(Cell::Number));
        row.push(Cell::Number(direction[k].clamp(-1.0, 1.0).acos()));
        row
    };
    (0..3).map(row).collect()
}
