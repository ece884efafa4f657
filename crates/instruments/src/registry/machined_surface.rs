//! Machining tests: a surface cut by the machine, measured afterwards along its normal [S2 §4.5].
//!
//! `m = n·(p_tool − p_surface) − ρ`, n the outward normal, ρ the error of the tool radius: the tool leaves the surface where it
//! is at the pose of cutting. The alignment of the workpiece on the measuring machine has six unknowns.
//! Limits: no deflection by cutting forces; the surface is what the last cut left.

use crate::instrument::{Contact, Frame, Inner, Instrument, none, unturned};
use crate::settings::{known, offset, placement};
use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, Setup};

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::MachinedSurface,
    settings: |setup| known(setup, placement(), offset("tool-radius", -1.0)),
    reading,
    seen,
    turned: unturned,
    frame: |_| Frame::Table,
    inner: none,
};

/// What a face is off along its outward normal, mm.
pub(super) fn reading(setup: &Setup, contact: &Contact, _: &Inner) -> Vector3<f64> {
    seen(setup, contact, &contact.apart_in_machine_mm())
}

/// The same for a displacement of the tool.
pub(super) fn seen(_: &Setup, contact: &Contact, tool_against_table: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(contact.normal_in_machine().dot(tool_against_table), 0.0, 0.0)
}
