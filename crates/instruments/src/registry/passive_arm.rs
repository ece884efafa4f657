//! Passive serial link of two arms in the table's XY plane: its joint angles [S2 §3.4].
//!
//! `p = l₁ e(θ₁) + l₂ e(θ₁+θ₂)`, p the tool seen from the foot, e(θ) = (cos θ, sin θ); read are θ₁ − o₁, θ₂ − o₂, kept as arcs L₁θ₁, L₂θ₂ with
//! the nominal lengths L. Unknown next to the foot: lengths l₁, l₂ and encoder zeros o₁, o₂. The elbow is on the right
//! (θ₂ ≥ 0). Differentials: dθ = J⁻¹ (dp − ∂p/∂l dl).
//! Limits: joint axes parallel to the table's Z; Z is not seen; not stretched and not folded.

use crate::instrument::{Contact, Frame, Inner, Instrument, unturned};
use crate::settings::{Quantity, inner as unknown, place};
use nalgebra::{Matrix2, Vector2, Vector3};
use trunnion_core::{InstrumentKind, Setup};

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::PassiveArm,
    settings: |_| {
        let own = [
            unknown(0, "arm-1", Quantity::Length),
            unknown(1, "arm-2", Quantity::Length),
            unknown(2, "zero-1", Quantity::Angle),
            unknown(3, "zero-2", Quantity::Angle),
        ];
        place().into_iter().chain(own).collect()
    },
    reading,
    seen: |setup, contact, tool_against_table| {
        let in_table = contact.machine_from_table.rotation.inverse() * tool_against_table;
        arcs(setup, &turned_by(setup, contact, &in_table.xy()))
    },
    turned: unturned,
    frame: |_| Frame::Table,
    inner,
};

fn reading(setup: &Setup, contact: &Contact, own: &Inner) -> Vector3<f64> {
    let [arm_1, arm_2] = arms(setup);
    let angles = joint_angles(&in_plane(contact), arm_1 + own[0], arm_2 + own[1]);
    arcs(setup, &(angles - Vector2::new(own[2], own[3])))
}

fn inner(setup: &Setup, contact: &Contact, k: usize) -> Vector3<f64> {
    let [first, second] = directions(setup, contact);
    match k {
        0 => arcs(setup, &turned_by(setup, contact, &-first)),
        1 => arcs(setup, &turned_by(setup, contact, &-second)),
        2 => arcs(setup, &-Vector2::x()),
        _ => arcs(setup, &-Vector2::y()),
    }
}

fn arms(setup: &Setup) -> [f64; 2] {
    setup.arms_mm.unwrap_or([1.0, 1.0])
}

/// The tool seen from the foot, table axes, mm.
fn in_plane(contact: &Contact) -> Vector2<f64> {
    (contact.machine_from_table.rotation.inverse() * contact.apart_in_machine_mm()).xy()
}

/// θ₁, θ₂ that reach `p`; NaN out of reach.
fn joint_angles(p: &Vector2<f64>, arm_1: f64, arm_2: f64) -> Vector2<f64> {
    let elbow = ((p.norm_squared() - arm_1.powi(2) - arm_2.powi(2)) / (2.0 * arm_1 * arm_2)).acos();
    let shoulder = p.y.atan2(p.x) - (arm_2 * elbow.sin()).atan2(arm_1 + arm_2 * elbow.cos());
    Vector2::new(shoulder, elbow)
}

/// e(θ₁), e(θ₁+θ₂) at the nominal place.
fn directions(setup: &Setup, contact: &Contact) -> [Vector2<f64>; 2] {
    let [arm_1, arm_2] = arms(setup);
    let angles = joint_angles(&in_plane(contact), arm_1, arm_2);
    [angles.x, angles.x + angles.y].map(|angle| Vector2::new(angle.cos(), angle.sin()))
}

/// dθ for a displacement of the tool.
fn turned_by(setup: &Setup, contact: &Contact, displacement_mm: &Vector2<f64>) -> Vector2<f64> {
    let [arm_1, arm_2] = arms(setup);
    let [first, second] = directions(setup, contact);
    let across = |direction: Vector2<f64>| Vector2::new(-direction.y, direction.x);
    let by_elbow = across(second) * arm_2;
    let jacobian = Matrix2::from_columns(&[across(first) * arm_1 + by_elbow, by_elbow]);
    jacobian.try_inverse().map_or_else(|| Vector2::repeat(f64::NAN), |inverse| inverse * displacement_mm)
}

fn arcs(setup: &Setup, angles: &Vector2<f64>) -> Vector3<f64> {
    let [arm_1, arm_2] = arms(setup);
    Vector3::new(angles.x * arm_1, angles.y * arm_2, 0.0)
}
