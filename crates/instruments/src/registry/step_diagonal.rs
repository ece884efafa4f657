//! Step-diagonal test: a flat mirror in the spindle, X, Y and Z stepping in turn [S2 §3.2].
//!
//! `l = m·(p_tool − p_start)/(m·b) − z`, m the normal of the mirror, b the beam. Each step moves the mirror sideways, so its tilt
//! enters in first order and biases the result unless it is an unknown; that of the beam only by its product with that of the mirror,
//! and its square.
//! Limits: mirror flat over the lateral travel.

use super::diagonal::{laterals, seen, tilted};
use crate::instrument::{Frame, Instrument, unturned};
use crate::settings::{Quantity, beam, inner, offset};
use nalgebra::Vector3;
use trunnion_core::InstrumentKind;

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::StepDiagonal,
    settings: |_| {
        vec![
            offset("zero", -1.0),
            inner(0, "mirror-1", Quantity::Angle),
            inner(1, "mirror-2", Quantity::Angle),
            beam(2, "beam-1"),
            beam(3, "beam-2"),
        ]
    },
    reading: |setup, contact, tilts| {
        let (mirror, beam) = (tilted(setup, &tilts[..2]), tilted(setup, &tilts[2..]));
        Vector3::new(mirror.dot(&contact.apart_in_machine_mm()) / mirror.dot(&beam), 0.0, 0.0)
    },
    seen,
    turned: unturned,
    frame: |_| Frame::Machine,
    inner: |setup, contact, k| {
        let lateral = laterals(setup).get(k).map_or(0.0, |side| side.dot(&contact.apart_in_machine_mm()));
        Vector3::new(lateral, 0.0, 0.0)
    },
};
