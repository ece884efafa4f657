//! Touch-trigger probing of faces, e.g. of a column, at indexed angles [S2 §4.3].
//!
//! `m = n·(p_face − p_stylus) + ρ`, n the outward normal, ρ the error of the stylus radius: where the face is found minus where
//! it should be, the opposite of a surface that the tool left. The column's place and direction (six unknowns) are part of every mounting.
//! Limits: plane faces, small tilts: a face is met at its nominal point.

use super::machined_surface;
use crate::instrument::{Contact, Frame, Inner, Instrument, none, unturned};
use crate::settings::{known, offset, placement};
use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, Setup};

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::TouchProbeFace,
    settings: |setup| known(setup, placement(), offset("radius", 1.0)),
    reading,
    seen,
    turned: unturned,
    frame: |_| Frame::Table,
    inner: none,
};

fn reading(setup: &Setup, contact: &Contact, inner: &Inner) -> Vector3<f64> {
    -machined_surface::reading(setup, contact, inner)
}

fn seen(setup: &Setup, contact: &Contact, tool_against_table: &Vector3<f64>) -> Vector3<f64> {
    -machined_surface::seen(setup, contact, tool_against_table)
}
