//! The machine files that ship with the program, readable without a file system.

use crate::Machine;

/// Names and texts of the shipped machine files (`config/machines`).
pub const FILES: [(&str, &str); 7] = [
    ("table-bc", include_str!("../../../config/machines/table-bc.toml")),
    ("table-bc-y", include_str!("../../../config/machines/table-bc-y.toml")),
    ("table-ac", include_str!("../../../config/machines/table-ac.toml")),
    ("head-bc", include_str!("../../../config/machines/head-bc.toml")),
    ("head-a-table-c", include_str!("../../../config/machines/head-a-table-c.toml")),
    ("three-axis", include_str!("../../../config/machines/three-axis.toml")),
    ("hybrid-exechon", include_str!("../../../config/machines/hybrid-exechon.toml")),
];

/// The shipped machine of this name.
pub fn machine(name: &str) -> Option<Machine> {
    let (name, text) = FILES.into_iter().find(|(shipped, _)| *shipped == name)?;
    Some(Machine::parse(name, &format!("{name}.toml"), text).expect("shipped machine files parse (tested)"))
}
