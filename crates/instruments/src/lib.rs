//! Observation models: what an instrument sees of the machine, exactly and to first order.
//!
//! Both forms are given the same errors by site; [`Projector::column`] is the derivative of [`predict`] at zero
//! errors (a test holds them together). One file per instrument, one line in [`REGISTRY`].

mod ball_bar;
mod r_test;

use nalgebra::{Isometry3, Point3, Vector3};
use trunnion_machine::propagation::JointFrame;
use trunnion_machine::{Errors, JointErrors, Machine, Side, Site};
use trunnion_measurement::{InstrumentKind, Setup};
use trunnion_units::{AxisLetter, AxisValues, Twist};

/// One kind of instrument.
pub struct Instrument {
    /// Which kind.
    pub kind: InstrumentKind,
    /// Exact reading, nest axes, mm, from the actual poses and the actual ball places in them.
    reading: fn(&Setup, &Contact) -> Vector3<f64>,
    /// Linear change of the reading for a relative displacement of tool against table, machine axes, mm.
    seen: fn(&Setup, &Contact, &Vector3<f64>) -> Vector3<f64>,
}

/// Every instrument.
pub const REGISTRY: [Instrument; 2] = [r_test::INSTRUMENT, ball_bar::INSTRUMENT];

/// Where both ends of the instrument are.
pub(crate) struct Contact {
    pub machine_from_table: Isometry3<f64>,
    pub machine_from_tool: Isometry3<f64>,
    /// Table-side ball or nest centre in table axes, mm.
    pub table_ball_in_table_mm: Point3<f64>,
    /// Spindle-side ball or nest centre in tool axes, mm.
    pub spindle_ball_in_tool_mm: Point3<f64>,
}

impl Contact {
    /// Spindle-side minus table-side centre, machine axes, mm.
    pub fn apart_in_machine_mm(&self) -> Vector3<f64> {
        self.machine_from_tool * self.spindle_ball_in_tool_mm
            - self.machine_from_table * self.table_ball_in_table_mm
    }
}

/// The instrument of a setup.
pub fn instrument(kind: InstrumentKind) -> &'static Instrument {
    const { &REGISTRY }
        .iter()
        .find(|instrument| instrument.kind == kind)
        .expect("every kind is registered (tested)")
}

/// Exact reading of `setup` at commanded `position` with `errors`, nest axes, mm.
pub fn predict(
    machine: &Machine,
    setup: &Setup,
    position: &AxisValues<f64>,
    errors: &Errors,
) -> Vector3<f64> {
    let contact = Contact {
        machine_from_table: machine.machine_from_table(position, &errors.joints),
        machine_from_tool: machine.machine_from_tool(position, &errors.joints),
        table_ball_in_table_mm: setup.ball_in_table_mm + errors.table_ball_mm,
        spindle_ball_in_tool_mm: Point3::from(errors.spindle_ball_mm),
    };
    (instrument(setup.instrument).reading)(setup, &contact) + errors.reading_mm
}

/// The first-order view of one setup at one position; build it once for all columns of a point.
pub struct Projector<'a> {
    setup: &'a Setup,
    instrument: &'static Instrument,
    contact: Contact,
    joints: AxisValues<Option<(Side, JointFrame)>>,
}

impl<'a> Projector<'a> {
    /// The nominal situation at `position`.
    pub fn new(machine: &Machine, setup: &'a Setup, position: &AxisValues<f64>) -> Self {
        let none = JointErrors::default();
        let contact = Contact {
            machine_from_table: machine.machine_from_table(position, &none),
            machine_from_tool: machine.machine_from_tool(position, &none),
            table_ball_in_table_mm: setup.ball_in_table_mm,
            spindle_ball_in_tool_mm: Point3::origin(),
        };
        let joints = AxisValues::from_fn(|letter: AxisLetter| {
            Some((machine.side(letter)?, machine.joint_frame(letter, position)?))
        });
        Self { setup, instrument: instrument(setup.instrument), contact, joints }
    }

    /// Change of the reading, nest axes, mm, for a small `twist` at `site`. Zero for a joint the machine lacks.
    pub fn column(&self, site: Site, twist: &Twist) -> Vector3<f64> {
        let tool_against_table = match site {
            Site::Reading => return twist.translation_mm,
            Site::TableBall => -(self.contact.machine_from_table.rotation * twist.translation_mm),
            Site::SpindleBall => self.contact.machine_from_tool.rotation * twist.translation_mm,
            Site::Joint(letter) => match &self.joints[letter] {
                None => return Vector3::zeros(),
                Some((Side::Table, frame)) => {
                    let point = self.contact.machine_from_table * self.contact.table_ball_in_table_mm;
                    -frame.displacement_mm(&point, twist)
                }
                Some((Side::Tool, frame)) => {
                    let point = self.contact.machine_from_tool * self.contact.spindle_ball_in_tool_mm;
                    frame.displacement_mm(&point, twist)
                }
            },
        };
        (self.instrument.seen)(self.setup, &self.contact, &tool_against_table)
    }
}

#[cfg(test)]
mod tests;
