//! What each instrument reads of actual poses, exactly.
//!
//! R-test, nest on the table: `table_from_machine·p_tool − nominal nest + setting`, table axes [docs/design/physics.md §1, S1 eq. 4]; nest in the
//! spindle: `p_table − p_tool`, machine axes [S0]. Ball bar: `|p_tool − p_table| − L`. Length: `|p_tool − p_table| − zero` [S2 eq. 8].
//! Line: along the beam, or what a tilted flat mirror reflects [S2 §3.2]. Centre, face: where a probe finds them. Cut: where the
//! tool leaves the surface. Arm: joint angles by the law of cosines, elbow right [S2 §3.4].

use crate::truth::{Instrument, NestOn, PlacedSetup};
use nalgebra::{Isometry3, Point3, Rotation3, Vector3};

/// Actual poses at one state.
pub(super) struct Poses {
    pub machine_from_table: Isometry3<f64>,
    pub machine_from_tool: Isometry3<f64>,
    /// Displacement of the table and of the tool as a whole, machine axes, mm.
    pub table_in_machine_mm: Vector3<f64>,
    pub tool_in_machine_mm: Vector3<f64>,
    /// Offset of ball against nest, table axes, mm.
    pub setting_in_table_mm: Vector3<f64>,
}

/// Noise-free reading, mm.
pub(super) fn read_mm(placed: &PlacedSetup, target: usize, poses: &Poses) -> [f64; 3] {
    let setup = &placed.setup;
    let tool_in_machine = poses.machine_from_tool * setup.ball_in_tool_mm + poses.tool_in_machine_mm;
    let setting = placed.setting_mm + poses.setting_in_table_mm;
    let origin = setup.ball_in_table_mm;
    let turn = Rotation3::from_scaled_axis(placed.own.turn_rad);
    let form = placed.form_mm.get(target).copied().unwrap_or_default();
    let target = setup.targets.get(target);
    let place = target.map_or(origin, |target| origin + turn * (target.in_table_mm + form - origin));
    let in_table = place + setting;
    let in_machine = poses.machine_from_table * in_table + poses.table_in_machine_mm;
    let apart = tool_in_machine - in_machine;
    let normal = target
        .map_or_else(Vector3::zeros, |target| poses.machine_from_table.rotation * (turn * target.normal));
    match (setup.instrument, setup.nest) {
        (Instrument::RTest, NestOn::Table) => {
            let tool_in_table =
                poses.machine_from_table.inverse() * (tool_in_machine - poses.table_in_machine_mm);
            // The setting is that of the ball against the nest.
            (tool_in_table - origin + setting).into()
        }
        (Instrument::RTest, NestOn::Spindle) | (Instrument::Centre, _) => (-apart).into(),
        (Instrument::BallBar { length_mm }, _) => [apart.norm() - length_mm, 0.0, 0.0],
        (Instrument::Length, _) => [apart.norm() - placed.own.zero_mm, 0.0, 0.0],
        (Instrument::Arm { arms_mm }, _) => {
            arcs(&(poses.machine_from_table.rotation.inverse() * apart), arms_mm, placed)
        }
        (Instrument::Line { direction, mirror }, _) => {
            let beam = Rotation3::from_scaled_axis(placed.own.beam_rad) * direction.normalize();
            let normal = Rotation3::from_scaled_axis(placed.own.mirror_rad) * direction.normalize();
            let along = if mirror { normal.dot(&apart) / normal.dot(&beam) } else { beam.dot(&apart) };
            [along - placed.own.zero_mm, 0.0, 0.0]
        }
        (Instrument::Face, _) => [placed.own.zero_mm - normal.dot(&apart), 0.0, 0.0],
        (Instrument::Cut, _) => [normal.dot(&apart) - placed.own.zero_mm, 0.0, 0.0],
    }
}

fn arcs(apart: &Vector3<f64>, nominal_mm: [f64; 2], placed: &PlacedSetup) -> [f64; 3] {
    let [a, b] = [0, 1].map(|k| nominal_mm[k] + placed.own.arms_mm[k]);
    let reach = Point3::new(apart.x, apart.y, 0.0).coords.norm();
    // Law of cosines in the triangle foot, elbow, tool.
    let at_elbow = ((a * a + b * b - reach * reach) / (2.0 * a * b)).acos();
    let at_foot = ((a * a + reach * reach - b * b) / (2.0 * a * reach)).acos();
    let angles = [apart.y.atan2(apart.x) - at_foot, std::f64::consts::PI - at_elbow];
    let [first, second] = [0, 1].map(|k| (angles[k] - placed.own.joints_rad[k]) * nominal_mm[k]);
    [first, second, 0.0]
}
