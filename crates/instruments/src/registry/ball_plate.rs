//! Ball plate and other artefacts: x, y, z of calibrated balls, each measured minus nominal centre [S2 §3.3].
//!
//! `m = p_ball − p_tool`, machine axes: what a probe in the spindle finds at the ball's nominal place. Every placement of the
//! artefact has six unknowns; the form of an uncalibrated one is the effect `artefact-form`.
//! Limits: a rigid artefact; length at 20 °C.

use crate::instrument::{Contact, Frame, Inner, Instrument, none, unturned};
use crate::settings::placement;
use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, Setup};

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::BallPlate,
    settings: |_| placement(),
    reading,
    seen,
    turned: unturned,
    frame: |_| Frame::Machine,
    inner: none,
};

pub(crate) fn reading(setup: &Setup, contact: &Contact, _: &Inner) -> Vector3<f64> {
    seen(setup, contact, &contact.apart_in_machine_mm())
}

pub(crate) fn seen(_: &Setup, _: &Contact, tool_against_table: &Vector3<f64>) -> Vector3<f64> {
    -tool_against_table
}
