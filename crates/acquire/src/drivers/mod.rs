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
pub const DRIVERS: [&Driver; 8] = [
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
        assert_eq!(files, DRIVERS.map(|driver| driver.name));
        assert!(DRIVERS.iter().all(|driver| !driver.about.is_empty()));
    }
}
