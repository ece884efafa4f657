//! What an instrument file provides, and what it is given: where both ends of the instrument are.

use crate::Setting;
use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use trunnion_core::{InstrumentKind, Setup, State};
use trunnion_machine::{Errors, JointErrors, MOST_INNER, Machine};

/// One kind of instrument.
pub struct Instrument {
    /// Which kind.
    pub kind: InstrumentKind,
    /// Unknowns that come with every mounting of it.
    pub settings: fn(&Setup) -> Vec<Setting>,
    /// Exact reading, mm, from the actual poses and places and the inner unknowns.
    pub(crate) reading: fn(&Setup, &Contact, &Inner) -> Vector3<f64>,
    /// Linear change of the reading for a relative displacement of tool against table, machine axes, mm.
    pub(crate) seen: fn(&Setup, &Contact, &Vector3<f64>) -> Vector3<f64>,
    /// Linear change of the reading for a turn of tool against table, machine axes, rad.
    pub(crate) turned: fn(&Setup, &Vector3<f64>) -> Vector3<f64>,
    /// Axes in which it reads.
    pub(crate) frame: fn(&Setup) -> Frame,
    /// Linear change of the reading for a unit of inner unknown `k`.
    pub(crate) inner: fn(&Setup, &Contact, usize) -> Vector3<f64>,
}

/// Axes in which an instrument reads: a turn of these axes shows as far as both ends are apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Frame {
    /// Table axes.
    Table,
    /// Tool axes.
    Tool,
    /// Machine axes, or a length that no axes count for.
    Machine,
}

/// Inner unknowns of an instrument, mm or rad.
pub(crate) type Inner = [f64; MOST_INNER];

/// For instruments without inner unknowns.
pub(crate) fn none(_: &Setup, _: &Contact, _: usize) -> Vector3<f64> {
    Vector3::zeros()
}

/// For instruments that see displacements only.
pub(crate) fn unturned(_: &Setup, _: &Vector3<f64>) -> Vector3<f64> {
    Vector3::zeros()
}

/// Where both ends of the instrument are.
pub(crate) struct Contact {
    pub machine_from_table: Isometry3<f64>,
    pub machine_from_tool: Isometry3<f64>,
    /// Table-side ball, nest, target or station in table axes, mm.
    pub table_ball_in_table_mm: Point3<f64>,
    /// Spindle-side ball, nest, reflector or stylus in tool axes, mm.
    pub spindle_ball_in_tool_mm: Point3<f64>,
    /// Outward normal of the face that is measured, table axes.
    pub normal_in_table: Option<Unit<Vector3<f64>>>,
    /// Turn of tool against table, actual against nominal, machine axes, rad; zero for instruments that read none.
    pub tool_against_table_rad: Vector3<f64>,
}

impl Contact {
    /// The situation at `state` with `errors`.
    pub fn new(machine: &Machine, setup: &Setup, state: &State, errors: &Errors) -> Self {
        let origin = setup.ball_in_table_mm;
        let turn = UnitQuaternion::from_scaled_axis(errors.table_ball.rotation_rad);
        let arm_mm = setup.target_in_table_mm(state.target) - origin;
        let normal = setup.artefact.as_ref().and_then(|artefact| artefact.normal_in_table(state.target));
        let machine_from_table = machine.machine_from_table(&state.position, &errors.joints);
        let machine_from_tool = machine.machine_from_tool(&state.position, &errors.joints);
        let tool_against_table_rad = match setup.instrument.reads_turn() {
            false => Vector3::zeros(),
            true => {
                let none = JointErrors::default();
                let turned = |actual: &Isometry3<f64>, nominal: Isometry3<f64>| {
                    (actual.rotation * nominal.rotation.inverse()).scaled_axis()
                };
                turned(&machine_from_tool, machine.machine_from_tool(&state.position, &none))
                    - turned(&machine_from_table, machine.machine_from_table(&state.position, &none))
            }
        };
        Self {
            machine_from_table,
            machine_from_tool,
            tool_against_table_rad,
            table_ball_in_table_mm: origin + errors.table_ball.translation_mm + turn * arm_mm,
            spindle_ball_in_tool_mm: setup.ball_in_tool_mm + errors.spindle_ball_mm,
            normal_in_table: normal.map(|normal| turn * normal),
        }
    }

    /// Spindle-side minus table-side centre, machine axes, mm.
    pub fn apart_in_machine_mm(&self) -> Vector3<f64> {
        self.machine_from_tool * self.spindle_ball_in_tool_mm
            - self.machine_from_table * self.table_ball_in_table_mm
    }

    /// What a turn of the artefact carries along the reading, table axes, mm: the target; where a face turns its normal as well,
    /// the point of the tool.
    pub fn turned_in_table_mm(&self) -> Point3<f64> {
        match self.normal_in_table {
            None => self.table_ball_in_table_mm,
            Some(_) => {
                self.machine_from_table.inverse() * (self.machine_from_tool * self.spindle_ball_in_tool_mm)
            }
        }
    }

    /// Outward normal of the measured face, machine axes; zero without one.
    pub fn normal_in_machine(&self) -> Vector3<f64> {
        self.normal_in_table
            .map_or_else(Vector3::zeros, |normal| self.machine_from_table.rotation * normal.into_inner())
    }
}
