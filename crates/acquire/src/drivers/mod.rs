//! The drivers: one file each and one line in [`DRIVERS`].
//!
//! A session opens, identifies the device, reads, and ends with a reason. It never retries: that is the
//! supervisor's work. Dropping a session at any await is safe; the port is closed with it.

pub mod ascii;
mod canopen;
pub mod canopen_slcan;
pub mod canopen_socketcan;
pub mod keyence_dl_rs1a;
pub mod linuxcnc;
pub mod mtconnect;
pub mod opcua;
pub mod optoncdt;

use crate::probe::Probe;
use crate::supervisor::{Link, SessionEnd};
use std::convert::Infallible;
use std::fmt::Debug;
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use trunnion_core::Role;
use trunnion_core::input::Table;

/// A session under way; it ends with a reason only.
pub type Session<'a> = Pin<Box<dyn Future<Output = Result<Infallible, SessionEnd>> + Send + 'a>>;

/// A configured device: what a driver makes of its table.
pub trait Device: Debug + Send + Sync {
    /// Channels of the device: name suffix (empty when there is one) and role.
    fn channels(&self) -> Vec<(String, Role)>;
    /// Port or address, for messages and to find two devices on one port.
    fn address(&self) -> &str;
    /// One connection, from opening to its end.
    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a>;
}

/// One kind of device.
pub struct Driver {
    /// Name in `trunnion.toml`; the file is named after it, `-` as `_`.
    pub name: &'static str,
    /// One line for `trunnion devices`.
    pub about: &'static str,
    /// `silence_ms` when the table has none.
    pub default_silence_ms: f64,
    /// Reads the driver's keys, noting problems.
    pub read: fn(&Table<'_>) -> Option<Arc<dyn Device>>,
    /// How `trunnion devices` finds one; `None` when nothing harmless can be asked.
    pub probe: Option<Probe>,
}

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
