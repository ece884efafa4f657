//! Calibration of the nest by known linear steps, where the runs hold them [S1 §3.2].
//!
//! With both rotary axes at rest the linear axes move the ball by commanded steps t; component k of the reading shows
//! `m_k = a_k·t + m_0`: a_k is its direction vector times its gain. They are fitted as those of probes
//! ([`trunnion_sync::nest::calibrate`]); the readings of the setup become `A⁻¹ m`. The ball's offset from the
//! spindle line turns with the spindle: it is taken as removed before, unless the machine file has the spindle as a joint, whose angle is then a position of
//! every reading (S2 tables 2–3).
//! Limits: linear axes free of error over the steps; steps that span three directions.

use crate::findings::{Cell, Column, FoundTable};
use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, Joint, Point, Slot};
use trunnion_cycles::Run;
use trunnion_effects::Unit;
use trunnion_instruments::predict;
use trunnion_machine::Errors;
use trunnion_sync::nest::{NestFit, NestStep, STEP_MM, calibrate};

/// Angles nearer than this are the same, rad: below the last digit of a position in a file (0.0001°).
const SAME_RAD: f64 = 1e-6;

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
    note += spindle_note(runs);
    let mut columns = vec![Column::plain("setup"), Column::plain("component"), Column::plain("gain")];
    columns.extend(["x", "y", "z"].map(|axis| Column::plain(format!("direction {axis}"))));
    columns.push(Column::of("angle to its axis", Unit::DEG));
    let caption = "Probe directions and gains by linear steps".into();
    let table = (!rows.is_empty()).then_some(FoundTable { caption, columns, rows });
    (Calibration { table, note }, calibrated)
}

/// What must be true of the ball's offset from the spindle line.
fn spindle_note(runs: &[Run]) -> &'static str {
    let joints: Vec<_> = runs.iter().filter_map(|run| Some((run, run.machine.spindle?))).collect();
    let angle_rad = |(run, joint): &(&Run, Joint)| {
        let angles = run.points.iter().map(|point| point.state.position[*joint]);
        angles
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), angle| (low.min(angle), high.max(angle)))
    };
    let (low, high) = joints
        .iter()
        .map(angle_rad)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (l, h)| (low.min(l), high.max(h)));
    if joints.is_empty() {
        " The machine file has no joint of the spindle, so its angle is not read. Keep the spindle at one angle, or remove the ball's offset from the \
         spindle line before (S1 §3.2)."
    } else if high - low > SAME_RAD {
        " The spindle turns in these runs. The map takes no account of the ball's offset from the spindle line; the joint fit (identify without --method) has the \
         errors of that line."
    } else {
        " The spindle stands at one angle, so the ball's offset from the spindle line is part of the setting of the ball."
    }
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
    let of_setup = |p: &&Point| p.state.setup == setup && p.is_good();
    let first = run.points.iter().filter(of_setup).find(|point| is_step(run, point))?;
    let same_pose = |p: &&Point| {
        let turned = |letter: Slot| (p.state.position[letter] - first.state.position[letter]).abs();
        Slot::ALL.into_iter().filter(|slot| slot.is_rotary()).all(|slot| turned(slot) < SAME_RAD)
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
