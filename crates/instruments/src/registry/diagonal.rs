//! Laser interferometer along a body diagonal: `l = b·(p_tool − p_start) − z` [S2 §3.2, eq. 7].
//!
//! b the direction of the beam, machine axes; z the zero of the display. Along the diagonal itself a tilt of the beam is a
//! cosine error, of second order: the fit says that it is not observable, and u of what is holds it.
//! Limits: retroreflector, so that angles of the tool do not count except by their arm.

use crate::instrument::{Contact, Frame, Instrument, unturned};
use crate::settings::{beam, offset};
use nalgebra::{Unit, Vector3};
use trunnion_core::{InstrumentKind, Setup};

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::Diagonal,
    settings: |_| vec![offset("zero", -1.0), beam(0, "beam-1"), beam(1, "beam-2")],
    reading: |setup, contact, tilts| {
        let beam = tilted(setup, &tilts[..2]);
        Vector3::new(beam.dot(&contact.apart_in_machine_mm()), 0.0, 0.0)
    },
    seen,
    turned: unturned,
    frame: |_| Frame::Machine,
    inner: |setup, contact, k| {
        let lateral = laterals(setup).get(k).map_or(0.0, |side| side.dot(&contact.apart_in_machine_mm()));
        Vector3::new(lateral, 0.0, 0.0)
    },
};

pub(crate) fn seen(setup: &Setup, _: &Contact, tool_against_table: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(along(setup).dot(tool_against_table), 0.0, 0.0)
}

/// Nominal direction of the beam.
pub(crate) fn along(setup: &Setup) -> Unit<Vector3<f64>> {
    setup.direction.unwrap_or_else(Vector3::x_axis)
}

/// Two directions across the beam: the first level in X and Y where it can be.
pub(crate) fn laterals(setup: &Setup) -> [Unit<Vector3<f64>>; 2] {
    let beam = along(setup);
    let reference = if beam.z.abs() > 0.99 { Vector3::y() } else { Vector3::z() };
    let first = Unit::new_normalize(reference.cross(&beam));
    [first, Unit::new_normalize(beam.cross(&first))]
}

/// The beam leaning by two small angles towards its lateral directions.
pub(crate) fn tilted(setup: &Setup, tilts_rad: &[f64]) -> Unit<Vector3<f64>> {
    let leaning = laterals(setup).into_iter().zip(tilts_rad).map(|(side, tilt)| side.into_inner() * *tilt);
    Unit::new_normalize(leaning.fold(along(setup).into_inner(), |sum, part| sum + part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laterals_are_square_to_the_beam_and_to_each_other() {
        let mut setup = crate::tests::setup_of(InstrumentKind::Diagonal);
        for beam in [[1.0, 1.0, 1.0], [0.0, 0.0, 1.0], [-1.0, 1.0, -1.0]] {
            setup.direction = Some(Unit::new_normalize(Vector3::from(beam)));
            let [first, second] = laterals(&setup);
            for (a, b) in [(first, second), (first, along(&setup)), (second, along(&setup))] {
                assert!(a.dot(&b).abs() < 1e-14);
            }
        }
    }
}
