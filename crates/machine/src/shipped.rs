//! The machine files that ship with the program, readable without a file system.

use crate::Machine;

/// Names and texts of the shipped machine files (`config/machines`).
pub const FILES: &[(&str, &str)] = &[
    ("table-bc", include_str!("../../../config/machines/table-bc.toml")),
    ("table-bc-y", include_str!("../../../config/machines/table-bc-y.toml")),
    ("table-ac", include_str!("../../../config/machines/table-ac.toml")),
    ("head-bc", include_str!("../../../config/machines/head-bc.toml")),
    ("head-bc-spindle", include_str!("../../../config/machines/head-bc-spindle.toml")),
    ("table-bc-spindle", include_str!("../../../config/machines/table-bc-spindle.toml")),
    ("head-a-table-c", include_str!("../../../config/machines/head-a-table-c.toml")),
    ("three-axis", include_str!("../../../config/machines/three-axis.toml")),
    ("hybrid-exechon", include_str!("../../../config/machines/hybrid-exechon.toml")),
];

/// The shipped machine of this name.
pub fn machine(name: &str) -> Option<Machine> {
    let (name, text) = FILES.iter().find(|(shipped, _)| *shipped == name)?;
    Some(Machine::parse(name, &format!("{name}.toml"), text).expect("shipped machine files parse (tested)"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_file_of_the_folder_is_shipped_under_its_name() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/machines");
        let files: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        let shipped: BTreeSet<String> = FILES.iter().map(|(name, _)| (*name).into()).collect();
        assert_eq!(
            shipped, files,
            "left: names of FILES in crates/machine/src/shipped.rs; right: config/machines"
        );
    }
}
