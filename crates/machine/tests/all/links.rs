//! The components of a machine, each against the one that carries it.

use nalgebra::Isometry3;
use std::collections::HashMap;
use trunnion_core::AxisValues;
use trunnion_machine::{JointErrors, shipped};

#[test]
fn links_one_after_the_other_lead_to_table_and_tool() {
    for (name, _) in shipped::FILES {
        let machine = shipped::machine(name).unwrap();
        let mut position = AxisValues::default();
        for (k, joint) in machine.joints().into_iter().enumerate() {
            position[joint] = if joint.is_rotary() { 0.3 + 0.2 * k as f64 } else { 7.0 - 3.0 * k as f64 };
        }
        let mut machine_from = HashMap::from([("machine".to_owned(), Isometry3::identity())]);
        for link in machine.links(&position) {
            let carried = machine_from[&link.carrier] * link.carrier_from_carried;
            assert!(machine_from.insert(link.carried.clone(), carried).is_none(), "{name}: {}", link.carried);
        }
        let errors = JointErrors::default();
        for (tip, expected) in [
            ("table", machine.machine_from_table(&position, &errors)),
            ("tool", machine.machine_from_tool(&position, &errors)),
        ] {
            let found = machine_from[tip];
            assert!((found.inverse() * expected).to_homogeneous().is_identity(1e-9), "{name}: {tip} {found}");
        }
    }
}
