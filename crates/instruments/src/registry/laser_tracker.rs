//! Laser tracker: place of a reflector in the axes of the tracker, three coordinates [docs/design/physics.md §6].
//!
//! `m = R(ω)⁻¹ p`, p the reflector seen from the tracker's zero in table axes. Unknown: where that zero is, the turn ω of the tracker's
//! axes against those of the table, and where the reflector sits on the tool or flange. A calibrated setup has readings in table axes:
//! only the reflector is unknown.
//! Limits: the setup knows zero and axes to some millimetres and milliradians (bring the readings into table axes first); one noise for
//! all three coordinates, although angles of a tracker scatter with the distance.

use crate::instrument::{Contact, Frame, Inner, Instrument, unturned};
use crate::settings::{Quantity, Setting, inner as unknown, place};
use nalgebra::{Rotation3, Vector3};
use trunnion_core::{InstrumentKind, Setup, Twist};
use trunnion_machine::Site;

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::LaserTracker,
    settings: |setup| {
        let turns =
            ["a", "b", "c"].into_iter().enumerate().map(|(k, name)| unknown(k, name, Quantity::Angle));
        let axes = place().into_iter().chain(turns).filter(|_| !setup.calibrated);
        axes.chain(reflector()).collect()
    },
    reading: |_, contact, own: &Inner| {
        turn(own).inverse() * in_table(contact, &contact.apart_in_machine_mm())
    },
    seen: |_, contact, tool_against_table| in_table(contact, tool_against_table),
    turned: unturned,
    frame: |_| Frame::Table,
    inner,
};

/// Place of the reflector on the tool, tool axes.
fn reflector() -> impl Iterator<Item = Setting> {
    ["reflector-x", "reflector-y", "reflector-z"].into_iter().enumerate().map(|(k, name)| Setting {
        name,
        quantity: Quantity::Length,
        site: Site::SpindleBall,
        twist: Twist::translation(Vector3::ith(k, 1.0)),
        u_beforehand: None,
    })
}

fn in_table(contact: &Contact, in_machine_mm: &Vector3<f64>) -> Vector3<f64> {
    contact.machine_from_table.rotation.inverse() * in_machine_mm
}

fn turn(own: &Inner) -> Rotation3<f64> {
    Rotation3::from_scaled_axis(Vector3::new(own[0], own[1], own[2]))
}

fn inner(_: &Setup, contact: &Contact, k: usize) -> Vector3<f64> {
    if k > 2 {
        return Vector3::zeros();
    }
    -Vector3::ith(k, 1.0).cross(&in_table(contact, &contact.apart_in_machine_mm()))
}
