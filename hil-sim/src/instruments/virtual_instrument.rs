//! What the file of a virtual instrument provides, and what it is given: actual places of both ends.

use crate::truth::{PlacedSetup, SimSetup};
use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;
use trunnion_core::InstrumentKind;

/// One instrument, or several that read the same.
pub(super) struct VirtualInstrument {
    /// What files call it.
    pub kinds: &'static [InstrumentKind],
    /// How a person mounts it, from the offset of ball against nest, mm: what is off about it.
    pub mounted: fn(&SimSetup, Vector3<f64>, &mut ChaCha8Rng) -> PlacedSetup,
    /// What it reads, exactly and without noise, mm.
    pub reading: fn(&Seen<'_>) -> [f64; 3],
}

/// Actual poses at one state.
pub(crate) struct Poses {
    pub machine_from_table: Isometry3<f64>,
    pub machine_from_tool: Isometry3<f64>,
    /// Displacement of the table and of the tool as a whole, machine axes, mm.
    pub table_in_machine_mm: Vector3<f64>,
    pub tool_in_machine_mm: Vector3<f64>,
    /// Offset of ball against nest, table axes, mm.
    pub setting_in_table_mm: Vector3<f64>,
}

/// Where both ends of an instrument are.
pub(super) struct Seen<'a> {
    pub placed: &'a PlacedSetup,
    pub poses: &'a Poses,
    /// Spindle-side centre, machine axes, mm.
    pub tool_in_machine: Point3<f64>,
    /// Offset of ball against nest, table axes, mm.
    pub setting: Vector3<f64>,
    /// Spindle-side minus table-side centre, machine axes, mm.
    pub apart: Vector3<f64>,
    /// Outward normal of the target, machine axes; zero without one.
    pub normal: Vector3<f64>,
}

impl<'a> Seen<'a> {
    pub(super) fn new(placed: &'a PlacedSetup, target: usize, poses: &'a Poses) -> Self {
        let setup = &placed.setup;
        let in_tool_mm = setup.ball_in_tool_mm + placed.own.off_spindle_mm;
        let tool_in_machine = poses.machine_from_tool * in_tool_mm + poses.tool_in_machine_mm;
        let setting = placed.setting_mm + poses.setting_in_table_mm;
        let origin = setup.ball_in_table_mm;
        let turn = Rotation3::from_scaled_axis(placed.own.turn_rad);
        let form = placed.form_mm.get(target).copied().unwrap_or_default();
        let target = setup.targets.get(target);
        let place = target.map_or(origin, |target| origin + turn * (target.in_table_mm + form - origin));
        let in_machine = poses.machine_from_table * (place + setting) + poses.table_in_machine_mm;
        let apart = tool_in_machine - in_machine;
        let normal = target
            .map_or_else(Vector3::zeros, |target| poses.machine_from_table.rotation * (turn * target.normal));
        Self { placed, poses, tool_in_machine, setting, apart, normal }
    }
}
