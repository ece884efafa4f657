//! The `[[device]]` tables of `trunnion.toml`.
//!
//! ```toml
//! [[device]]
//! name = "probe-x"
//! driver = "optoncdt"            # any name of drivers::DRIVERS
//! port = "/dev/serial/by-id/usb-…"
//! role = "probe-1"
//! range_mm = 10
//! rate_khz = 1
//! silence_ms = 200               # no reading for so long ends the connection
//! travel_mm = [-1, 1]            # measuring range, of drivers that do not know it
//! zero_mm = 10.0                 # of a channel with role "bar": what it shows at the length of the bar
//! ```
//! Further keys belong to the driver and are described in its file.

use crate::driver::Device;
use crate::drivers::DRIVERS;
use std::sync::Arc;
use std::time::Duration;
use trunnion_core::input::{Document, Table};
use trunnion_core::{Channel, Problems, Role};

/// One configured device.
#[derive(Clone, Debug)]
pub struct DeviceConfig {
    /// Name, unique.
    pub name: String,
    /// Name of the driver.
    pub driver: &'static str,
    /// No reading for so long ends the connection.
    pub silence: Duration,
    /// Measuring range of its displacement channels, mm, where somebody says it.
    pub range_mm: Option<[f64; 2]>,
    /// The driver's own settings, ready to connect.
    pub device: Arc<dyn Device>,
}

/// The channels of all devices; `ProbeReading::channel` is an index into this list.
pub fn channels(devices: &[DeviceConfig]) -> Vec<Channel> {
    let of = |(index, config): (usize, &DeviceConfig)| {
        let device = index as u16;
        let named = |(suffix, role): (String, Role)| {
            let name =
                if suffix.is_empty() { config.name.clone() } else { format!("{}.{suffix}", config.name) };
            Channel { device, name, role }
        };
        config.device.channels().into_iter().map(named).collect::<Vec<_>>()
    };
    devices.iter().enumerate().flat_map(of).collect()
}

/// Reads a file that holds nothing but `[[device]]` tables.
///
/// # Errors
/// Every problem of the file with its line.
pub fn parse_devices(file: &str, text: &str) -> Result<Vec<DeviceConfig>, Problems> {
    let document = Document::parse(file, text)?;
    let root = document.root();
    let devices = read_devices(&root);
    root.no_other_keys();
    drop(root);
    document.finish(devices)
}

/// Reads the `[[device]]` tables of a larger file; the list may be empty. Problems are noted in the document.
pub fn read_devices(root: &Table<'_>) -> Option<Vec<DeviceConfig>> {
    let tables = root.tables("device");
    let mut devices: Vec<DeviceConfig> = Vec::new();
    let mut roles: Vec<(Role, String)> = Vec::new();
    for table in &tables {
        let Some(config) = read_device(table) else { continue };
        if devices.iter().any(|other| other.name == config.name) {
            table.problem("name", format!("= \"{}\" appears twice", config.name), "a name of its own", "");
        }
        if let Some(other) = devices.iter().find(|other| other.device.address() == config.device.address()) {
            table.problem(
                "driver",
                format!("uses {}, as \"{}\" does", config.device.address(), other.name),
                "one device for each port or address",
                "",
            );
        }
        for (_, role) in config.device.channels().into_iter().filter(|(_, role)| *role != Role::Temperature) {
            if let Some((_, other)) = roles.iter().find(|(taken, _)| *taken == role) {
                table.problem(
                    "role",
                    format!("\"{}\" is taken by \"{other}\"", role.name()),
                    "each role once",
                    "",
                );
            }
            roles.push((role, config.name.clone()));
        }
        devices.push(config);
    }
    (devices.len() == tables.len()).then_some(devices)
}

fn read_device(table: &Table<'_>) -> Option<DeviceConfig> {
    let name = table.string("name");
    let names: Vec<&str> = DRIVERS.iter().map(|driver| driver.name).collect();
    let chosen = table.one_of("driver", &names);
    let silence_ms = table.optional_number("silence_ms", 20.0..=10_000.0);
    let travel_mm = read_travel(table);
    let driver = DRIVERS.iter().find(|driver| Some(driver.name) == chosen.as_deref())?;
    let device = (driver.read)(table);
    table.no_other_keys();
    let of_driver = device.as_ref().and_then(|device| device.range_mm());
    Some(DeviceConfig {
        range_mm: travel_mm.or(of_driver),
        name: name?,
        driver: driver.name,
        silence: Duration::from_secs_f64(silence_ms.unwrap_or(driver.default_silence_ms) / 1e3),
        device: device?,
    })
}

/// The key `travel_mm`: for gauges whose driver does not know their range.
fn read_travel(table: &Table<'_>) -> Option<[f64; 2]> {
    let numbers = table.optional_numbers("travel_mm")?;
    match numbers[..] {
        [from_mm, to_mm] if from_mm < to_mm => Some([from_mm, to_mm]),
        _ => {
            table.problem("travel_mm", format!("= {numbers:?}"), "both ends, e.g. [-1, 1]", "");
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_core::channel::instrument_channels;

    const GOOD: &str = r#"
[[device]]
name = "probe-x"
driver = "optoncdt"
port = "/dev/ttyUSB0"
role = "probe-1"
range_mm = 10
rate_khz = 2
silence_ms = 100

[[device]]
name = "bus"
driver = "canopen-slcan"
port = "/dev/ttyACM0"
bitrate = 1000000
nodes = [{ id = 2, role = "probe-2" }, { id = 3, role = "probe-3" }]

[[device]]
name = "cnc"
driver = "mtconnect"
url = "http://10.0.0.5:5000"
"#;

    #[test]
    fn channels_are_numbered_through_all_devices_and_found_by_role() {
        let devices = parse_devices("t.toml", GOOD).unwrap();
        let channels = channels(&devices);
        let names: Vec<_> = channels.iter().map(|c| (c.device, c.name.as_str())).collect();
        assert_eq!(names, [(0, "probe-x"), (1, "bus.node-2"), (1, "bus.node-3")]);
        assert_eq!(instrument_channels(&channels, false), Some(vec![0, 1, 2]));
        assert_eq!(instrument_channels(&channels, true), None);
    }

    #[test]
    fn the_range_is_that_of_the_driver_or_of_travel_mm() {
        let text = GOOD.replace("bitrate = 1000000", "bitrate = 1000000\ntravel_mm = [-1, 1.5]");
        let ranges: Vec<_> = parse_devices("t.toml", &text).unwrap().iter().map(|d| d.range_mm).collect();
        assert_eq!(ranges, [Some([0.0, 10.0]), Some([-1.0, 1.5]), None]);
        let shown = parse_devices("t.toml", &text.replace("[-1, 1.5]", "[1, -1]")).unwrap_err().to_string();
        assert!(shown.contains("travel_mm = [1.0, -1.0]") && shown.contains("both ends"), "{shown}");
    }

    #[test]
    fn every_problem_is_reported_with_its_line_and_what_is_allowed() {
        let text = GOOD
            .replace("silence_ms = 100", "silence_ms = 5")
            .replace("rate_khz = 2", "rate_khz = 3")
            .replace("id = 3, role = \"probe-3\"", "id = 200, role = \"probe-4\"")
            .replace("http://", "https://");
        let shown = parse_devices("t.toml", &text).unwrap_err().to_string();
        let expect = |piece: &str| assert!(shown.contains(piece), "{piece:?} not in:\n{shown}");
        expect("t.toml:9:14: device[0].silence_ms = 5; allowed: 20..=10000");
        expect("rate_khz = 3; allowed: 0.25, 0.5, 1, 2, 4");
        expect("nodes[1].id = 200; allowed: 1..=127");
        expect("probe-4");
        expect("https");
    }

    #[test]
    fn a_role_or_port_cannot_be_given_twice() {
        let text = GOOD.replace("role = \"probe-2\"", "role = \"probe-1\"").replace("ttyACM0", "ttyUSB0");
        let shown = parse_devices("t.toml", &text).unwrap_err().to_string();
        assert!(shown.contains("\"probe-1\" is taken by \"probe-x\""), "{shown}");
        assert!(shown.contains("uses /dev/ttyUSB0, as \"probe-x\" does"), "{shown}");
    }
}
