//! R-test: three probes around a ball, read as x, y, z of the ball relative to the nest.
//!
//! nest on the table [S1]: ball rides in the spindle, reading in table axes;
//! nest in the spindle [S0]: ball sits on the table, reading in tool axes (machine axes when no head turns).
//! Limits: probe directions and gains are calibrated before (S1 §3.2); cosine errors of the probe tips ignored.

use crate::instrument::{Contact, Frame, Inner, Instrument, none, unturned};
use crate::settings::place;
use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, NestSide, Setup};

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::RTest,
    settings: |_| place(),
    reading,
    seen,
    turned: unturned,
    frame: |setup| match setup.nest {
        NestSide::Table => Frame::Table,
        NestSide::Spindle => Frame::Tool,
    },
    inner: none,
};

fn reading(setup: &Setup, contact: &Contact, _: &Inner) -> Vector3<f64> {
    seen(setup, contact, &contact.apart_in_machine_mm())
}

fn seen(setup: &Setup, contact: &Contact, tool_against_table: &Vector3<f64>) -> Vector3<f64> {
    match setup.nest {
        NestSide::Table => contact.machine_from_table.rotation.inverse() * tool_against_table,
        NestSide::Spindle => contact.machine_from_tool.rotation.inverse() * -tool_against_table,
    }
}
