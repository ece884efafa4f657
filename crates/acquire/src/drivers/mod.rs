//! The drivers: one file each and one line in [`DRIVERS`].

pub mod ascii;
mod canopen;
pub mod canopen_slcan;
pub mod canopen_socketcan;
pub mod keyence_dl_rs1a;
pub mod linuxcnc;
pub mod mtconnect;
pub mod opcua;
pub mod optoncdt;

use crate::driver::Driver;

/// Every driver.
pub static DRIVERS: &[&Driver] = &[
    &ascii::DRIVER,
    &canopen_slcan::DRIVER,
    &canopen_socketcan::DRIVER,
    &keyence_dl_rs1a::DRIVER,
    &linuxcnc::DRIVER,
    &mtconnect::DRIVER,
    &opcua::DRIVER,
    &optoncdt::DRIVER,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_driver_file_is_registered_under_its_own_name() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/drivers");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter_map(|name| name.strip_suffix(".rs").map(|stem| stem.replace('_', "-")))
            .filter(|stem| stem != "mod")
            .collect();
        files.sort();
        let registered: Vec<&str> = DRIVERS.iter().map(|driver| driver.name).collect();
        assert_eq!(
            registered, files,
            "left: names of DRIVERS in crates/acquire/src/drivers/mod.rs, in their order; right: the files of its folder"
        );
        assert!(DRIVERS.iter().all(|driver| !driver.about.is_empty()));
    }

    #[test]
    fn the_guide_shows_how_to_configure_every_driver() {
        let guide = include_str!("../../../../docs/use/connect.md");
        for driver in DRIVERS {
            let line = format!("driver = \"{}\"", driver.name);
            assert!(
                guide.contains(&line),
                "docs/use/connect.md needs a section with a table that holds {line}"
            );
        }
    }
}
