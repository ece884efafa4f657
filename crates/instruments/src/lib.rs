//! Observation models: what an instrument sees of the machine, exactly and to first order.
//!
//! Both forms are given the same errors by site; [`Projector::column`] is the derivative of [`predict`] at zero
//! errors (a test holds them together). One file per instrument, one line in [`REGISTRY`].

mod ball_bar;
mod ball_plate;
mod diagonal;
mod laser_ball_bar;
mod machined_surface;
mod passive_arm;
mod r_test;
mod settings;
mod step_diagonal;
mod touch_probe;
mod touch_probe_face;
mod tracker;

pub use settings::{Quantity, Setting};

use nalgebra::{Isometry3, Matrix3, Point3, Unit, UnitQuaternion, Vector3};
use trunnion_core::{AxisValues, InstrumentKind, Setup, State, Twist};
use trunnion_machine::propagation::JointFrame;
use trunnion_machine::{Errors, MOST_INNER, Machine, Side, Site};

/// One kind of instrument.
pub struct Instrument {
    /// Which kind.
    pub kind: InstrumentKind,
    /// Unknowns that come with every mounting of it.
    pub settings: fn(&Setup) -> Vec<Setting>,
    /// Exact reading, mm, from the actual poses and places and the inner unknowns.
    reading: fn(&Setup, &Contact, &Inner) -> Vector3<f64>,
    /// Linear change of the reading for a relative displacement of tool against table, machine axes, mm.
    seen: fn(&Setup, &Contact, &Vector3<f64>) -> Vector3<f64>,
    /// Axes in which it reads.
    frame: fn(&Setup) -> Frame,
    /// Linear change of the reading for a unit of inner unknown `k`.
    inner: fn(&Setup, &Contact, usize) -> Vector3<f64>,
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

/// Every instrument.
pub const REGISTRY: [Instrument; 11] = [
    r_test::INSTRUMENT,
    ball_bar::INSTRUMENT,
    tracker::INSTRUMENT,
    laser_ball_bar::INSTRUMENT,
    passive_arm::INSTRUMENT,
    diagonal::INSTRUMENT,
    step_diagonal::INSTRUMENT,
    ball_plate::INSTRUMENT,
    touch_probe::INSTRUMENT,
    touch_probe_face::INSTRUMENT,
    machined_surface::INSTRUMENT,
];

/// For instruments without inner unknowns.
fn none(_: &Setup, _: &Contact, _: usize) -> Vector3<f64> {
    Vector3::zeros()
}

/// Ends nearer than this are together, mm.
const TOGETHER_MM: f64 = 2e-3;

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
}

impl Contact {
    fn new(machine: &Machine, setup: &Setup, state: &State, errors: &Errors) -> Self {
        let origin = setup.ball_in_table_mm;
        let turn = UnitQuaternion::from_scaled_axis(errors.table_ball.rotation_rad);
        let arm_mm = setup.target_in_table_mm(state.target) - origin;
        let normal = setup.artefact.as_ref().and_then(|artefact| artefact.normal_in_table(state.target));
        Self {
            machine_from_table: machine.machine_from_table(&state.position, &errors.joints),
            machine_from_tool: machine.machine_from_tool(&state.position, &errors.joints),
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
    fn turned_in_table_mm(&self) -> Point3<f64> {
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

/// The instrument of a setup.
pub fn instrument(kind: InstrumentKind) -> &'static Instrument {
    const { &REGISTRY }
        .iter()
        .find(|instrument| instrument.kind == kind)
        .expect("every kind is registered (tested)")
}

/// Exact reading of `setup` at commanded `state` with `errors`, nest axes, mm.
pub fn predict(machine: &Machine, setup: &Setup, state: &State, errors: &Errors) -> Vector3<f64> {
    let contact = Contact::new(machine, setup, state, errors);
    (instrument(setup.instrument).reading)(setup, &contact, &errors.instrument) + errors.reading_mm
}

/// The first-order view of one setup at one position; build it once for all columns of a point.
pub struct Projector<'a> {
    setup: &'a Setup,
    instrument: &'static Instrument,
    contact: Contact,
    joints: AxisValues<Option<(Side, JointFrame)>>,
}

impl<'a> Projector<'a> {
    /// The nominal situation at the position and target of `state`.
    pub fn new(machine: &Machine, setup: &'a Setup, state: &State) -> Self {
        let contact = Contact::new(machine, setup, state, &Errors::default());
        let joints = AxisValues::of(machine.joints(), |letter| {
            Some((machine.side(letter)?, machine.joint_frame(letter, &state.position)?))
        });
        Self { setup, instrument: instrument(setup.instrument), contact, joints }
    }

    /// Change of the reading for a displacement of tool against table by one mm along each machine axis: what this
    /// instrument sees of a displacement, rows its components.
    pub fn seen(&self) -> Matrix3<f64> {
        let along = |k: usize| (self.instrument.seen)(self.setup, &self.contact, &Vector3::ith(k, 1.0));
        Matrix3::from_columns(&[along(0), along(1), along(2)])
    }

    /// Change of the reading, nest axes, mm, for a small `twist` at `site`. Zero for a joint the machine lacks.
    pub fn column(&self, site: Site, twist: &Twist) -> Vector3<f64> {
        let tool_against_table = match site {
            Site::Reading => return twist.translation_mm,
            Site::Instrument(k) => {
                return (self.instrument.inner)(self.setup, &self.contact, k) * twist.translation_mm.x;
            }
            Site::TableBall => {
                let arm_mm = self.contact.turned_in_table_mm() - self.setup.ball_in_table_mm;
                let moved = twist.translation_mm + twist.rotation_rad.cross(&arm_mm);
                -(self.contact.machine_from_table.rotation * moved)
            }
            Site::SpindleBall => self.contact.machine_from_tool.rotation * twist.translation_mm,
            Site::Joint(letter) => match &self.joints[letter] {
                None => return Vector3::zeros(),
                Some((Side::Table, frame)) => -frame.displacement_mm(&self.point(Frame::Table), twist),
                Some((Side::Tool, frame)) => frame.displacement_mm(&self.point(Frame::Tool), twist),
            },
        };
        (self.instrument.seen)(self.setup, &self.contact, &tool_against_table)
    }

    /// The point at which a joint of `side` displaces one end against the other, machine axes, mm: that end itself, or, when
    /// the reading is in the axes that the joint turns, the other one. Ends that are together but for the rounding of the
    /// commanded positions count as one: else that rounding would show directions that no reading can see.
    fn point(&self, side: Frame) -> Point3<f64> {
        let at_table = self.contact.machine_from_table * self.contact.table_ball_in_table_mm;
        let at_tool = self.contact.machine_from_tool * self.contact.spindle_ball_in_tool_mm;
        let apart = (at_tool - at_table).norm() > TOGETHER_MM;
        let turns_the_axes = apart && (self.instrument.frame)(self.setup) == side;
        if (side == Frame::Table) != turns_the_axes { at_table } else { at_tool }
    }
}

#[cfg(test)]
mod tests;
