//! Cross-grid encoder (grid plate): both coordinates of its head in the plane of the grid [S2 §3.3; ISO 230-4].
//!
//! `(u, v) = (e_u·R⁻¹p, e_v·R⁻¹p)`, p the head seen from the zero of the grid, table axes; n the normal of the plate, e_u along the letter
//! that follows that of n (X, Y, Z, X), e_v = n × e_u; R the turn ψ about n and the tilts α about e_u, β about e_v by which the plate is off. Unknown:
//! the zero in the plane, ψ, and the tilts, which act in second order (cosine error) where the head keeps its height: u of what is seen holds them.
//! The plate is calibrated. Displacements along n and turns of the head are not seen.
//! Limits: plate at 20 °C; the product α β, which is a squareness (0.2 µrad where both are as large as their u), is in no u.

use crate::instrument::{Contact, Frame, Inner, Instrument, unturned};
use crate::settings::{Quantity, Setting, inner as unknown};
use nalgebra::{Rotation3, Unit, Vector3};
use trunnion_core::{InstrumentKind, Setup, Twist};
use trunnion_machine::Site;

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::CrossGrid,
    settings: |setup| {
        let [e_u, e_v] = setup.gratings();
        vec![
            zero("u", e_u),
            zero("v", e_v),
            unknown(0, "turn", Quantity::Angle),
            tilt(1, "tilt-1"),
            tilt(2, "tilt-2"),
        ]
    },
    reading: |setup, contact, own: &Inner| {
        let turn = Rotation3::from_scaled_axis((0..3).map(|k| about(setup, k).into_inner() * own[k]).sum());
        on_grid(setup, &(turn.inverse() * in_table(contact, &contact.apart_in_machine_mm())))
    },
    seen: |setup, contact, tool_against_table| on_grid(setup, &in_table(contact, tool_against_table)),
    turned: unturned,
    frame: |_| Frame::Table,
    inner: |setup, contact, k| match k {
        0..3 => on_grid(setup, &-about(setup, k).cross(&in_table(contact, &contact.apart_in_machine_mm()))),
        _ => Vector3::zeros(),
    },
};

/// Place of the zero along one grating.
fn zero(name: &'static str, along: Unit<Vector3<f64>>) -> Setting {
    let twist = Twist::translation(along.into_inner());
    Setting { name, quantity: Quantity::Length, site: Site::TableBall, twist, u_beforehand: None }
}

/// A tilt of the plate. The head reads only as long as its gap of 0.5 mm stays within ± 0.05 mm [HEIDENHAIN KGM], over 70 mm from the middle of a
/// plate of 140 mm. So the tilt lies anywhere within ± 0.7 mrad, with the standard uncertainty of [GUM 4.3.7].
fn tilt(k: usize, name: &'static str) -> Setting {
    const WITHIN_RAD: f64 = 0.05 / 70.0;
    Setting { u_beforehand: Some(WITHIN_RAD / 3.0_f64.sqrt()), ..unknown(k, name, Quantity::Angle) }
}

/// n, e_u, e_v.
fn about(setup: &Setup, k: usize) -> Unit<Vector3<f64>> {
    let [e_u, e_v] = setup.gratings();
    [setup.direction.unwrap_or_else(Vector3::z_axis), e_u, e_v][k]
}

fn on_grid(setup: &Setup, in_table_mm: &Vector3<f64>) -> Vector3<f64> {
    let [e_u, e_v] = setup.gratings();
    Vector3::new(e_u.dot(in_table_mm), e_v.dot(in_table_mm), 0.0)
}

fn in_table(contact: &Contact, in_machine_mm: &Vector3<f64>) -> Vector3<f64> {
    contact.machine_from_table.rotation.inverse() * in_machine_mm
}
