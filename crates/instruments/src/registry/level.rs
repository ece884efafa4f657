//! Level, one angle of an autocollimator, angular interferometer: turn of the tool against the table about one direction.
//!
//! `m = L n·(θ_tool − θ_table) − zero`, θ the turn of each side against its nominal attitude, n the direction of the setup in machine
//! axes, L = 1 m, so that 1 µm/m is 1 µrad [docs/design/physics.md §6]. An autocollimator reads two angles: two setups.
//! Limits: small turns; of a level, the difference of one on the tool's side and one on the table's.

use crate::instrument::{Contact, Frame, Inner, Instrument, none};
use crate::settings::offset;
use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, Setup};

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::Level,
    settings: |_| vec![offset("zero", -1.0)],
    reading: |setup, contact, _: &Inner| turned(setup, &contact.tool_against_table_rad),
    seen: |_, _: &Contact, _| Vector3::zeros(),
    turned,
    frame: |_| Frame::Machine,
    inner: none,
};

/// Length whose end a turn moves by the reading, mm.
const ARM_MM: f64 = 1000.0;

fn turned(setup: &Setup, tool_against_table_rad: &Vector3<f64>) -> Vector3<f64> {
    let about = setup.direction.map_or_else(Vector3::zeros, |direction| direction.into_inner());
    Vector3::new(ARM_MM * about.dot(tool_against_table_rad), 0.0, 0.0)
}
