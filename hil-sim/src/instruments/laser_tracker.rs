//! Place of a reflector in the axes of a laser tracker: `turn⁻¹ (p_reflector − zero)`, both in table axes.

use super::length::STATION_MM;
use super::on_artefact::ARTEFACT_RAD;
use super::virtual_instrument::VirtualInstrument;
use crate::physics::natural::normal_vector;
use crate::truth::{Own, PlacedSetup};
use nalgebra::Rotation3;
use trunnion_core::InstrumentKind;

/// How far the reflector is off its place on the flange, mm.
const REFLECTOR_MM: f64 = 0.1;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::LaserTracker],
    mounted: |setup, _, rng| {
        let (turn_rad, reflector_mm) = (normal_vector(rng) * ARTEFACT_RAD, normal_vector(rng) * REFLECTOR_MM);
        let own = Own { turn_rad, reflector_mm, ..Own::default() };
        PlacedSetup { own, ..PlacedSetup::new(setup, normal_vector(rng) * STATION_MM) }
    },
    reading: |seen| {
        let (poses, placed) = (seen.poses, seen.placed);
        let reflector = seen.tool_in_machine + poses.machine_from_tool.rotation * placed.own.reflector_mm;
        let in_table = poses.machine_from_table.inverse() * (reflector - poses.table_in_machine_mm);
        let from_zero = in_table - (placed.setup.ball_in_table_mm + seen.setting);
        (Rotation3::from_scaled_axis(placed.own.turn_rad).inverse() * from_zero).into()
    },
};
