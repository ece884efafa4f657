//! Two arms that turn in the table's XY plane: joint angles as arcs by the law of cosines, elbow right [S2 §3.4].

use super::virtual_instrument::{Seen, VirtualInstrument};
use crate::physics::natural::normal_vector;
use crate::truth::{Own, PlacedSetup};
use nalgebra::Vector3;
use trunnion_core::InstrumentKind;

/// Lengths of arms and zeros of their joints.
const ARM_MM: f64 = 0.05;
const JOINT_RAD: f64 = 500e-6;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::PassiveArm],
    mounted: |setup, setting_mm, rng| {
        let (arms, joints): (Vector3<f64>, Vector3<f64>) = (normal_vector(rng), normal_vector(rng));
        let arms_mm = [arms.x * ARM_MM, arms.y * ARM_MM];
        let joints_rad = [joints.x * JOINT_RAD, joints.y * JOINT_RAD];
        let own = Own { arms_mm, joints_rad, ..Own::default() };
        PlacedSetup { own, ..PlacedSetup::new(setup, setting_mm) }
    },
    reading: arcs,
};

fn arcs(seen: &Seen<'_>) -> [f64; 3] {
    let (own, nominal_mm) = (&seen.placed.own, seen.placed.setup.instrument.arms_mm);
    let apart = seen.poses.machine_from_table.rotation.inverse() * seen.apart;
    let [a, b] = [0, 1].map(|k| nominal_mm[k] + own.arms_mm[k]);
    let reach = apart.xy().norm();
    // Law of cosines in the triangle foot, elbow, tool.
    let at_elbow = ((a * a + b * b - reach * reach) / (2.0 * a * b)).acos();
    let at_foot = ((a * a + reach * reach - b * b) / (2.0 * a * reach)).acos();
    let angles = [apart.y.atan2(apart.x) - at_foot, std::f64::consts::PI - at_elbow];
    let [first, second] = [0, 1].map(|k| (angles[k] - own.joints_rad[k]) * nominal_mm[k]);
    [first, second, 0.0]
}
