//! Calibration of the nest by known linear steps, where the runs hold them [S1 §3.2].
//!
//! With both rotary axes at rest the linear axes move the ball by commanded steps t; component k of the reading shows
//! `m_k = a_k·t + m_0`: a_k is its direction vector times its gain. They are fitted as those of probes
//! ([`trunnion_sync::nest::calibrate`]); the readings of the setup become `A⁻¹ m`. The spindle's angle is on no recording, so the ball's offset from the spindle line is taken as removed before.
//! Limits: linear axes free of error over the steps; steps that span three directions.

use crate::findings::{Cell, Column, FoundTable};
use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, Point, Quality, Slot};
use trunnion_cycles::Run;
use trunnion_effects::Unit;
use trunnion_instruments::predict;
use trunnion_machine::Errors;
use trunnion_sync::nest::{NestFit, NestStep, STEP_MM, calibrate};

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
            let fit = match calibrate(&steps) {
                Ok(fit) => fit,
                Err(error) => {
                    unusable.push(format!("{} of run {} ({error})", setup.name, run.name));
                    continue;
                }
            };
            rows.extend(rows_of(&format!("{} of {}", setup.name, run.name), &fit));
            let nest_from_probes = fit.calibration.nest_from_probes;
            for point in put_right.points.iter_mut().filter(|point| point.state.setup == s) {
                point.reading_mm = (nest_from_probes * Vector3::from(point.reading_mm)).into();
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
            " The steps of {} give no calibration and are excluded: move the ball in X, Y and Z.",
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
fn steps(run: &Run, setup: usize) -> Option<Vec<NestStep>> {
    let of_setup = |p: &&Point| p.state.setup == setup && p.quality == Quality::Good;
    let first = run.points.iter().filter(of_setup).find(|point| is_step(run, point))?;
    let same_pose = |p: &&Point| {
        let turned = |letter: Slot| (p.state.position[letter] - first.state.position[letter]).abs();
        Slot::ALL.into_iter().filter(|slot| slot.is_rotary()).all(|slot| turned(slot) < 1e-6)
    };
    let here = run.points.iter().filter(of_setup).filter(same_pose);
    let step = |p: &Point| NestStep { ball_in_nest_mm: commanded_mm(run, p), probes_mm: p.reading_mm };
    Some(here.map(step).collect())
}

fn rows_of(setup: &str, fit: &NestFit) -> Vec<Vec<Cell>> {
    let row = |k: usize| {
        let (gain, direction) = (fit.gains[k], fit.directions[k]);
        let mut row =
            vec![Cell::Text(setup.into()), Cell::Text(["x", "y", "z"][k].into()), Cell::Number(gain)];
        row.extend(direction.iter().copied().map(Cell::Number));
        row.push(Cell::Number(direction[k].clamp(-1.0, 1.0).acos()));
        row
    };
    (0..3).map(row).collect()
}
