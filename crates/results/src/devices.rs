//! What is connected, and what the devices of a configuration read.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `trunnion-devices/1`: ports, interfaces and servers with what answers there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DevicesFound {
    /// Format and version.
    pub format: DevicesFormat,
    /// Every place that was asked, in order.
    pub places: Vec<DevicePlace>,
}

/// `trunnion-devices/1`: the devices of a configuration with their first readings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DevicesChecked {
    /// Format and version.
    pub format: DevicesFormat,
    /// Every device, in the order of the configuration.
    pub devices: Vec<CheckedDevice>,
}

/// Format and version of a list of devices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum DevicesFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-devices/1")]
    V1,
}

/// A place that was asked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DevicePlace {
    /// Address for the configuration.
    pub address: String,
    /// Address of the moment, e.g. `/dev/ttyUSB0`.
    pub device: String,
    /// What the system knows of it.
    pub about: String,
    /// Driver whose device answered; null where none did.
    pub driver: Option<String>,
    /// What the device says it is; null where none answered.
    pub identity: Option<String>,
    /// Lines for the configuration; null where no device answered.
    pub config: Option<String>,
    /// What is wrong, and what to do; null where nothing is.
    pub trouble: Option<String>,
    /// Questions that were sent.
    pub asked: Vec<String>,
}

/// A device of a configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CheckedDevice {
    /// Its name.
    pub name: String,
    /// Its driver.
    pub driver: String,
    /// Its address.
    pub address: String,
    /// State of its connection.
    pub state: String,
    /// What it says it is; empty where it did not answer.
    pub identity: String,
    /// Last reading of each channel or axis, with its unit.
    pub readings: BTreeMap<String, String>,
    /// Warnings while it was connected.
    pub warnings: Vec<String>,
    /// What is wrong; null where it reads.
    pub trouble: Option<String>,
}
