//! Measured against predicted, point by point: the inside units of a fit become screen units, and poses become places.

use crate::number::finite;
use nalgebra::{DVector, Matrix3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use trunnion_core::convert::{deg_from_rad, um_from_mm};
use trunnion_core::{AxisValues, Joint, Point, Setup};
use trunnion_cycles::RunKind;
use trunnion_engine::Experiment;
use trunnion_machine::{JointErrors, Machine};

/// Measured and predicted readings of a fit, with the places they belong to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Residuals {
    /// Axes of the machine; positions and directions of the points are in this order.
    pub axes: Vec<ResidualAxis>,
    /// Setups; the points give their index.
    pub setups: Vec<ResidualSetup>,
    /// Of long runs only every n-th point is listed; 1: all are.
    pub every: usize,
    /// True when the points were sampled while an axis moved.
    pub on_the_fly: bool,
    /// Points in the order in which they were taken.
    pub points: Vec<ResidualPoint>,
}

/// An axis of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualAxis {
    /// Its name.
    pub name: String,
    /// True for a rotary axis.
    pub rotary: bool,
}

/// One instrument mounted in one way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualSetup {
    /// Name, e.g. `low`.
    pub name: String,
    /// Names of the components of a reading: x y z, or r.
    pub components: Vec<String>,
    /// Nominal centre of the table-side ball or nest, table axes, mm.
    pub ball_in_table_mm: [f64; 3],
}

/// One point: where it was, what was read, what the model predicts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualPoint {
    /// Index of its setup.
    pub setup: usize,
    /// Commanded position of each axis, mm and degrees.
    pub position: Vec<f64>,
    /// Direction of each axis in the pass that the point belongs to: −1, 0 (unknown), +1. Where a pass turns round, the
    /// few poses approached from the other side stay with it.
    pub direction: Vec<i8>,
    /// Time since the run began, s; null without time stamps.
    pub time_s: Option<f64>,
    /// Reading, nest axes, µm; one value for each component of the setup.
    pub measured_um: Vec<f64>,
    /// What the model predicts for it, µm.
    pub predicted_um: Vec<f64>,
    /// Measured − predicted, µm.
    pub residual_um: Vec<f64>,
    /// True when the robust loss excluded it from the fit.
    pub excluded: bool,
    /// The residual as motion of the tool against the table, machine axes, µm; zero along what the instrument does not see.
    pub tool_residual_um: [f64; 3],
    /// The same in the axes of the turned table.
    pub tool_residual_in_table_um: [f64; 3],
    /// The table-side ball or nest in machine axes.
    pub in_machine: ShiftedPlace,
    /// The same in the axes of the part that carries the turning axis, Z along that axis: the table plane is its XY plane.
    pub in_table_plane: ShiftedPlace,
}

/// A commanded place of the table side, and how far readings say that it is off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShiftedPlace {
    /// Commanded place, mm.
    pub commanded_mm: [f64; 3],
    /// Shift of the table side against the tool as measured, µm.
    pub measured_um: [f64; 3],
    /// The same as predicted.
    pub predicted_um: [f64; 3],
}

impl ShiftedPlace {
    /// Measured less predicted shift, µm.
    pub fn residual_um(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.measured_um[k] - self.predicted_um[k])
    }
}

/// Longer runs list every n-th point.
const MOST_POINTS: usize = 20_000;

impl Residuals {
    /// The residual of a fit; `predicted_mm` has the rows of the experiment, `used` says which points took part (points beyond
    /// its end did).
    pub fn new(experiment: &Experiment, predicted_mm: &DVector<f64>, used: &[bool]) -> Self {
        let joints = experiment.machine().joints();
        let directions = pass_directions(experiment);
        let every = experiment.points.len().div_ceil(MOST_POINTS).max(1);
        let point = |(i, point): (usize, &Point)| {
            let mut predicted = Vector3::zeros();
            for (k, row) in experiment.rows_of(i).enumerate() {
                predicted[k] = predicted_mm[row];
            }
            let used = used.get(i).copied().unwrap_or(true);
            ResidualPoint {
                direction: joints.iter().map(|&joint| sign(directions[i][joint])).collect(),
                excluded: !used,
                ..residual_point(experiment, i, point, &joints, &predicted)
            }
        };
        Self {
            axes: joints.iter().map(ResidualAxis::from).collect(),
            setups: experiment.setups.iter().map(residual_setup).collect(),
            every,
            on_the_fly: experiment.kinds.contains(&RunKind::OnTheFly),
            points: experiment.points.iter().enumerate().step_by(every).map(point).collect(),
        }
    }
}

impl From<&Joint> for ResidualAxis {
    fn from(joint: &Joint) -> Self {
        Self { name: joint.to_string(), rotary: joint.is_rotary() }
    }
}

fn residual_setup(setup: &Setup) -> ResidualSetup {
    ResidualSetup {
        name: setup.name.clone(),
        components: setup.instrument.components().iter().map(|name| (*name).into()).collect(),
        ball_in_table_mm: setup.ball_in_table_mm.coords.into(),
    }
}

fn residual_point(
    experiment: &Experiment,
    i: usize,
    point: &Point,
    joints: &[Joint],
    predicted: &Vector3<f64>,
) -> ResidualPoint {
    let (machine, position) = (experiment.machine(), &point.state.position);
    let measured = Vector3::from(point.reading_mm);
    let components = experiment.rows_of(i).len();
    let um = |reading: &Vector3<f64>| reading.iter().take(components).copied().map(um_from_mm).collect();
    let places = places(machine, &experiment.setups[point.state.setup], point, &experiment.seen_of_tool(i));
    let [in_machine, in_table_plane] = places.map(|place| ShiftedPlace {
        commanded_mm: place.commanded_mm.into(),
        measured_um: (place.shift_from_reading * measured).map(um_from_mm).into(),
        predicted_um: (place.shift_from_reading * predicted).map(um_from_mm).into(),
    });
    // The tool moves against the table as the table moves against the tool, the other way.
    let of_tool_um = -Vector3::from(in_machine.residual_um());
    let machine_from_table = machine.machine_from_table(position, &JointErrors::default());
    ResidualPoint {
        setup: point.state.setup,
        position: joints.iter().map(|&joint| on_screen(joint, position[joint])).collect(),
        time_s: point.state.time_s.and_then(finite),
        measured_um: um(&measured),
        predicted_um: um(predicted),
        residual_um: um(&(measured - predicted)),
        tool_residual_um: of_tool_um.into(),
        tool_residual_in_table_um: machine_from_table.rotation.inverse_transform_vector(&of_tool_um).into(),
        in_machine,
        in_table_plane,
        ..ResidualPoint::default()
    }
}

fn on_screen(joint: Joint, position: f64) -> f64 {
    if joint.is_rotary() { deg_from_rad(position) } else { position }
}

fn sign(direction: f64) -> i8 {
    i8::from(direction > 0.0) - i8::from(direction < 0.0)
}

/// A direction held by fewer than this share of a setup's points is where passes turn round, not a pass of its own.
const SMALLEST_PASS: f64 = 0.2;

/// Directions of the rotary axes of each point, those of turning round replaced by those of the pass around them.
fn pass_directions(experiment: &Experiment) -> Vec<AxisValues<f64>> {
    let rotary = experiment.machine().rotary_joints();
    let points = &experiment.points;
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

/// A commanded place, mm, and how a reading moves it: `actual = commanded + shift_from_reading · reading`.
struct Place {
    commanded_mm: Vector3<f64>,
    shift_from_reading: Matrix3<f64>,
}

/// Place of the table-side ball or nest in machine axes and in the axes that carry the turning table.
fn places(machine: &Machine, setup: &Setup, point: &Point, seen: &Matrix3<f64>) -> [Place; 2] {
    let position = &point.state.position;
    let machine_from_table = machine.machine_from_table(position, &JointErrors::default());
    let ball_in_machine = machine_from_table * setup.target_in_table_mm(point.state.target);
    // The table side moves against what the instrument sees of the tool; nothing across what it sees.
    let shift_from_reading = -seen.pseudo_inverse(UNSEEN).unwrap_or_else(|_| Matrix3::zeros());
    let in_machine = || Place { commanded_mm: ball_in_machine.coords, shift_from_reading };
    let turning = machine.table.iter().find(|axis| axis.is_rotary());
    let Some((axis, frame)) =
        turning.and_then(|axis| Some((axis, machine.joint_frame(axis.letter, position)?)))
    else {
        return [in_machine(), in_machine()];
    };
    let carrier_from_plane = UnitQuaternion::rotation_between(&Vector3::z(), &axis.direction)
        .unwrap_or_else(UnitQuaternion::identity);
    let plane_from_machine = (frame.machine_from_carrier * carrier_from_plane).inverse();
    let in_table_plane = Place {
        commanded_mm: plane_from_machine * (ball_in_machine - frame.origin_in_machine_mm),
        shift_from_reading: plane_from_machine.to_rotation_matrix().into_inner() * shift_from_reading,
    };
    [in_machine(), in_table_plane]
}
