//! Ball bar: change of the distance between two balls, `r = |p_tool − p_table| − L` [S4; S2 §3.1; docs/design/physics.md §5].
//!
//! Limits: the bar must have a direction, i.e. the balls must be apart at every position.

use crate::instrument::{Contact, Frame, Inner, Instrument, none, unturned};
use crate::settings::{known, offset, place};
use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, Setup};

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::BallBar,
    settings: |setup| known(setup, place(), offset("length", -1.0)),
    reading,
    seen,
    turned: unturned,
    frame: |_| Frame::Machine,
    inner: none,
};

pub(crate) fn reading(setup: &Setup, contact: &Contact, _: &Inner) -> Vector3<f64> {
    let length_mm = setup.bar_length_mm.unwrap_or(0.0);
    Vector3::new(contact.apart_in_machine_mm().norm() - length_mm, 0.0, 0.0)
}

pub(crate) fn seen(_: &Setup, contact: &Contact, tool_against_table: &Vector3<f64>) -> Vector3<f64> {
    let along_bar = contact.apart_in_machine_mm().try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
    Vector3::new(along_bar.dot(tool_against_table), 0.0, 0.0)
}
