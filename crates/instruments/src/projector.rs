//! What an instrument sees: the exact reading, and its change to first order.

use crate::instrument::{Contact, Frame};
use crate::{Instrument, instrument};
use nalgebra::{Matrix3, Point3, Vector3};
use trunnion_core::{AxisValues, Setup, State, Twist};
use trunnion_machine::propagation::JointFrame;
use trunnion_machine::{Errors, Machine, Side, Site};

/// Ends nearer than this are together, mm.
const TOGETHER_MM: f64 = 2e-3;

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
                Some((side, frame)) if self.setup.instrument.reads_turn() => {
                    let turned_rad = frame.turned(twist).rotation_rad;
                    let tool_against_table_rad = if *side == Side::Table { -turned_rad } else { turned_rad };
                    return (self.instrument.turned)(self.setup, &tool_against_table_rad);
                }
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
