//! Grid plate on the table under a head in the spindle: coordinates, along the two gratings of the plate as it lies, of the foot of the head on
//! the plate. The plate lies off its place, is turned in its plane and tilted.

use super::length::STATION_MM;
use super::on_artefact::ARTEFACT_RAD;
use super::virtual_instrument::{Seen, VirtualInstrument};
use crate::physics::natural::normal_vector;
use crate::truth::{Own, PlacedSetup};
use nalgebra::{Rotation3, Vector3};
use trunnion_core::InstrumentKind;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::CrossGrid],
    mounted: |setup, _, rng| {
        let own = Own { turn_rad: normal_vector(rng) * ARTEFACT_RAD, ..Own::default() };
        PlacedSetup { own, ..PlacedSetup::new(setup, normal_vector(rng) * STATION_MM) }
    },
    reading: on_plate,
};

fn on_plate(seen: &Seen<'_>) -> [f64; 3] {
    let (poses, placed) = (seen.poses, seen.placed);
    let head = poses.machine_from_table.inverse() * (seen.tool_in_machine - poses.table_in_machine_mm);
    let zero = placed.setup.ball_in_table_mm + seen.setting;
    // The first grating runs along the letter after that of the normal, the second is square to it in the plate.
    let normal = placed.setup.instrument.direction.normalize();
    let after = [Vector3::y(), Vector3::z(), Vector3::x()][normal.iamax()];
    let second = normal.cross(&after).normalize();
    let first = second.cross(&normal);
    let lies = Rotation3::from_scaled_axis(placed.own.turn_rad);
    [(lies * first).dot(&(head - zero)), (lies * second).dot(&(head - zero)), 0.0]
}
