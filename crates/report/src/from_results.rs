//! From results to what is shown: the one place where inside units become screen units and poses become pictures.

use crate::{CompareInput, LadderRow, Noise, Place, PointView, SetupView, Trial};
use nalgebra::{DVector, Isometry3, Matrix3, UnitQuaternion, Vector3};
use std::collections::HashMap;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{AxisValues, Point, Setup};
use trunnion_cycles::RunKind;
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::compare::places as worst_places;
use trunnion_engine::{Experiment, Identification};
use trunnion_machine::{JointErrors, Machine};
use trunnion_results as results;
use trunnion_results::sentences::noise_origin;
use trunnion_results::{Diagnosis, Parameter, Verdict};

impl CompareInput {
    /// The report of one fit. Label, ladder, losses and timing are the caller's to fill in.
    pub fn new(experiment: &Experiment, fit: &Identification, diagnosis: Option<Diagnosis>) -> Self {
        let identification = results::Identification::from(fit);
        let noise = Noise::of(&identification);
        // Where the diagnosis hears nothing but noise, no place is blamed.
        let silent = diagnosis.as_ref().is_some_and(|d| d.verdict == Verdict::NoiseFloor);
        let places = if silent { Vec::new() } else { worst_places(experiment, &fit.residual_mm, &fit.used) };
        Self {
            identification,
            noise,
            label: String::new(),
            setups: experiment.setups.iter().map(SetupView::from).collect(),
            points: points_of(experiment, &fit.predicted_mm, &fit.used),
            every: every(experiment),
            on_the_fly: experiment.kinds.contains(&RunKind::OnTheFly),
            rotary: experiment.machine().rotary_joints(),
            places,
            ladder: Vec::new(),
            diagnosis,
            trial: None,
            losses: Vec::new(),
            timing: Vec::new(),
        }
    }
}

impl Trial {
    /// The fits without and with `entry`, which carries the ladder row of all that was added, `added` entry by entry; `then` is the
    /// diagnosis of the model with it.
    pub fn new(
        experiment: &Experiment,
        entry: &ModelEffect,
        added: &[ModelEffect],
        before: &Identification,
        after: &Identification,
        then: Option<Diagnosis>,
    ) -> Self {
        let silent = then.as_ref().is_some_and(|d| d.verdict == Verdict::NoiseFloor);
        let places = |fit: &Identification| worst_places(experiment, &fit.residual_mm, &fit.used);
        let fits = [before, after];
        let view = results::Identification::from(after);
        let components: Vec<&str> = added.iter().filter_map(|entry| entry.component.as_deref()).collect();
        let expression = match (&entry.site, &entry.expression) {
            (Some(site), Some(expression)) => format!("{} at {site}: {expression}", components.join(", ")),
            _ => String::new(),
        };
        let is_new = |p: &Parameter| added.iter().any(|entry| entry.id == p.effect);
        Self {
            effect: entry.id.clone(),
            expression,
            fit_um: fits.map(|fit| um_from_mm(fit.rms_mm)),
            holdout_um: fits.map(|fit| fit.holdout_rms_mm().map(um_from_mm)),
            noise: Noise::of(&view),
            parameters: view.parameters.into_iter().filter(is_new).collect(),
            moved: entry.ladder.as_ref().map_or(Vec::new(), |row| results::LadderRow::from(row).moved),
            places: [places(before), if silent { Vec::new() } else { places(after) }],
            points: fits.map(|fit| points_of(experiment, &fit.predicted_mm, &fit.used)),
            then,
        }
    }
}

/// The ladder rows that a model carries.
pub fn ladder_of(model: &Model) -> Vec<LadderRow> {
    let row = |entry: &ModelEffect| {
        let ladder = entry.ladder.as_ref()?;
        Some(LadderRow {
            effect: entry.id.clone(),
            date: ladder.date.clone(),
            run: ladder.run.clone(),
            fit_before_um: ladder.error_before_um,
            fit_after_um: ladder.error_after_um,
            holdout_before_um: ladder.holdout_before_um,
            holdout_after_um: ladder.holdout_after_um,
            noise_um: ladder.noise_um,
            moved: ladder.moved.iter().map(results::Moved::from).collect(),
        })
    };
    model.effects.iter().filter_map(row).collect()
}

/// A direction held by fewer than this share of a setup's points is where passes turn round, not a pass of its own.
const SMALLEST_PASS: f64 = 0.2;

/// Directions of the rotary axes of each point, those of turning round replaced by those of the pass around them.
fn pass_directions(experiment: &Experiment) -> Vec<AxisValues<f64>> {
    let rotary: Vec<_> = experiment.machine().rotary().iter().map(|axis| axis.letter).collect();
    let points = &experiment.points;
    let sign = |direction: f64| i8::from(direction > 0.0) - i8::from(direction < 0.0);
    let group = |i: usize| (experiment.run_of_point[i], points[i].state.setup);
    let key = |i: usize| {
        let signs = rotary.iter().map(|&letter| sign(points[i].state.direction[letter]));
        (group(i), signs.collect::<Vec<_>>())
    };
    let (mut of_key, mut of_group) = (HashMap::new(), HashMap::new());
    for i in 0..points.len() {
        *of_key.entry(key(i)).or_insert(0.0) += 1.0;
        *of_group.entry(group(i)).or_insert(0.0) += 1.0;
    }
    let is_pass = |i: usize| of_key[&key(i)] >= SMALLEST_PASS * of_group[&group(i)];
    let mut directions: Vec<_> = points.iter().map(|point| point.state.direction).collect();
    let mut near = HashMap::new();
    let mut lone = Vec::new();
    for i in (0..points.len()).rev() {
        if is_pass(i) {
            near.insert(group(i), directions[i]);
        } else {
            match near.get(&group(i)) {
                Some(direction) => directions[i] = *direction,
                None => lone.push(i),
            }
        }
    }
    // The last poses of a setup belong to the pass before them.
    for i in lone {
        if let Some(before) = (0..i).rev().find(|&k| group(k) == group(i) && is_pass(k)) {
            directions[i] = directions[before];
        }
    }
    directions
}

/// Share below which an instrument does not see a direction.
const UNSEEN: f64 = 1e-6;

/// Longer runs are drawn by every n-th point.
const MOST_POINTS: usize = 20_000;

fn every(experiment: &Experiment) -> usize {
    experiment.points.len().div_ceil(MOST_POINTS).max(1)
}

/// Points with their place, of long runs every n-th; `predicted_mm` has the rows of the experiment, mm, and `used` one entry a point (points beyond
/// its end count as used).
pub fn points_of(experiment: &Experiment, predicted_mm: &DVector<f64>, used: &[bool]) -> Vec<PointView> {
    let directions = pass_directions(experiment);
    let view = |(i, point): (usize, &Point)| {
        let setup = &experiment.setups[point.state.setup];
        let mut predicted = [0.0; 3];
        for (k, row) in experiment.rows_of(i).enumerate() {
            predicted[k] = predicted_mm.get(row).copied().unwrap_or(f64::NAN);
        }
        let (in_machine, in_table_plane) =
            places(experiment.machine(), setup, point, &experiment.seen_of_tool(i));
        PointView {
            setup: point.state.setup,
            position: point.state.position,
            direction: directions[i],
            time_s: point.state.time_s,
            measured_mm: point.reading_mm,
            predicted_mm: predicted,
            table_from_machine: rotation(
                &experiment
                    .machine()
                    .machine_from_table(&point.state.position, &JointErrors::default())
                    .inverse(),
            ),
            outlier: !used.get(i).copied().unwrap_or(true),
            in_machine,
            in_table_plane,
        }
    };
    experiment.points.iter().enumerate().step_by(every(experiment)).map(view).collect()
}

/// Place of the table-side ball or nest in machine axes and in the axes that carry the turning table.
fn places(machine: &Machine, setup: &Setup, point: &Point, seen: &Matrix3<f64>) -> (Place, Place) {
    let position = &point.state.position;
    let machine_from_table = machine.machine_from_table(position, &JointErrors::default());
    let ball_in_machine = machine_from_table * setup.target_in_table_mm(point.state.target);
    // The table side moves against what the instrument sees of the tool; nothing across what it sees.
    let shift_from_reading = -seen.pseudo_inverse(UNSEEN).unwrap_or_else(|_| Matrix3::zeros());
    let in_machine = Place { commanded_mm: ball_in_machine.coords, shift_from_reading };
    let turning = machine.table.iter().find(|axis| axis.is_rotary());
    let Some((axis, frame)) =
        turning.and_then(|axis| Some((axis, machine.joint_frame(axis.letter, position)?)))
    else {
        return (in_machine.clone(), in_machine);
    };
    let carrier_from_plane = UnitQuaternion::rotation_between(&Vector3::z(), &axis.direction)
        .unwrap_or_else(UnitQuaternion::identity);
    let plane_from_machine = (frame.machine_from_carrier * carrier_from_plane).inverse();
    let in_table_plane = Place {
        commanded_mm: plane_from_machine * (ball_in_machine - frame.origin_in_machine_mm),
        shift_from_reading: plane_from_machine.to_rotation_matrix().into_inner() * shift_from_reading,
    };
    (in_machine, in_table_plane)
}

fn rotation(pose: &Isometry3<f64>) -> Matrix3<f64> {
    pose.rotation.to_rotation_matrix().into_inner()
}

impl From<&Setup> for SetupView {
    fn from(setup: &Setup) -> Self {
        Self {
            name: setup.name.clone(),
            components: setup.instrument.components().iter().map(|name| (*name).into()).collect(),
            ball_in_table_mm: setup.ball_in_table_mm.coords,
        }
    }
}

impl Noise {
    /// The repeatability of a fit, with its origin.
    pub fn of(fit: &results::Identification) -> Self {
        Self { rms_um: fit.noise_um, origin: noise_origin(fit) }
    }
}
