//! `trunnion devices --config`: the devices of a configuration, connected as the service connects them.

use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::bail;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{Instant, timeout_at};
use tokio_util::sync::CancellationToken;
use trunnion::results::{CheckedDevice, DevicesChecked, DevicesFormat};
use trunnion_acquire::config::channels;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceConfig, DeviceState, DeviceStatus, parse_devices, start};
use trunnion_core::Joint;
use trunnion_core::reading::{Message, Reading};
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;

/// Longest wait for a first reading: SDO transfers with several nodes take some seconds.
const LIMIT: Duration = Duration::from_secs(15);
/// After all are there, readings are shown as they are so much later.
const SETTLE: Duration = Duration::from_millis(500);

/// What came of one device.
struct Checked {
    name: String,
    driver: &'static str,
    address: String,
    status: DeviceStatus,
    /// Last reading of each channel or axis, as text.
    readings: BTreeMap<String, String>,
    warnings: Vec<String>,
}

impl Checked {
    fn is_good(&self) -> bool {
        self.status.state == DeviceState::Streaming
    }

    fn trouble(&self) -> Option<String> {
        match &self.status.last_end {
            _ if self.is_good() => None,
            Some(end) => Some(end.to_string()),
            None => Some(format!("no reading within {} s", LIMIT.as_secs())),
        }
    }
}

pub async fn run(path: &Path, as_json: bool) -> anyhow::Result<Outcome> {
    let devices = read_devices(path)?;
    if devices.is_empty() {
        bail!("{} has no [[device]]; `trunnion devices` finds them", path.display());
    }
    let mut checked: Vec<Checked> = devices
        .iter()
        .map(|device| Checked {
            name: device.name.clone(),
            driver: device.driver,
            address: device.device.address().to_owned(),
            status: DeviceStatus::default(),
            readings: BTreeMap::new(),
            warnings: Vec::new(),
        })
        .collect();
    let names: Vec<String> = channels(&devices).into_iter().map(|channel| channel.name).collect();
    let clock = Arc::new(SystemClock::start());
    let mut acquisition = start(devices, clock, CancellationToken::new(), QUEUE_LENGTH);
    listen(&mut acquisition, &names, &mut checked).await;
    for (device, state) in checked.iter_mut().zip(&acquisition.states) {
        device.status = state.borrow().clone();
    }
    acquisition.stop().await;
    if as_json {
        terminal::print_json(&value(&checked))?
    } else {
        terminal::print(&to_text(&checked))?
    }
    let missing = checked.iter().filter(|device| !device.is_good()).count();
    if missing > 0 {
        bail!("{missing} of {} devices give no readings", checked.len());
    }
    Ok(Outcome::Done)
}

/// The devices of a whole configuration, or of a file that holds nothing else.
fn read_devices(path: &Path) -> anyhow::Result<Vec<DeviceConfig>> {
    let text = load::read(path)?;
    if text.lines().any(|line| line.trim_start().starts_with("format")) {
        return Ok(Config::parse(path, &text)?.devices);
    }
    Ok(parse_devices(&path.display().to_string(), &text)?)
}

/// Takes messages until every device reads or has failed, and a little longer.
async fn listen(acquisition: &mut Acquisition, names: &[String], checked: &mut [Checked]) {
    let mut deadline = Instant::now() + LIMIT;
    let mut settled = false;
    while let Ok(Some(message)) = timeout_at(deadline, acquisition.messages.recv()).await {
        take(message, names, checked);
        let decided = acquisition.states.iter().all(|state| {
            let status = state.borrow();
            status.state == DeviceState::Streaming || status.last_end.is_some()
        });
        if decided && !settled {
            settled = true;
            deadline = deadline.min(Instant::now() + SETTLE);
        }
    }
}

fn take(message: Message, names: &[String], checked: &mut [Checked]) {
    let Some(device) = checked.get_mut(usize::from(message.device)) else { return };
    match message.reading {
        Reading::Probe(probe) => {
            let name = names.get(usize::from(probe.channel)).cloned().unwrap_or_default();
            let shown =
                if probe.value_mm.is_nan() { "no value".into() } else { format!("{:.4} mm", probe.value_mm) };
            device.readings.insert(name, shown);
        }
        Reading::Temperature(temperature) => {
            let shown = if temperature.degc.is_nan() {
                "no value".into()
            } else {
                format!("{:.2} °C", temperature.degc)
            };
            device.readings.insert(temperature.name, shown);
        }
        Reading::Axes(axes) => {
            for letter in Joint::ISO.into_iter().filter(|&letter| axes.present[letter]) {
                let value = axes.position[letter];
                let shown = match letter.is_rotary() {
                    true => format!("{:.4}°", value.to_degrees()),
                    false => format!("{value:.4} mm"),
                };
                device.readings.insert(letter.to_string(), shown);
            }
        }
        Reading::Log(line) if line.warning => device.warnings.push(line.text),
        Reading::Log(_) | Reading::Controller(_) | Reading::Counters(_) | Reading::Gap(_) => {}
    }
}

fn to_text(checked: &[Checked]) -> String {
    let mut text = String::new();
    for device in checked {
        text +=
            &format!("{} ({}, {}): {:?}\n", device.name, device.driver, device.address, device.status.state);
        if !device.status.identity.is_empty() {
            text += &format!("  {}\n", device.status.identity);
        }
        for (name, reading) in &device.readings {
            text += &format!("  {name} = {reading}\n");
        }
        let trouble = device.trouble();
        // The end of a session is logged too.
        for line in device.warnings.iter().filter(|line| Some(*line) != trouble.as_ref()).chain(&trouble) {
            text += &format!("  {line}\n");
        }
    }
    text
}

fn value(checked: &[Checked]) -> DevicesChecked {
    let device = |device: &Checked| CheckedDevice {
        name: device.name.clone(),
        driver: device.driver.into(),
        address: device.address.clone(),
        state: format!("{:?}", device.status.state),
        identity: device.status.identity.clone(),
        readings: device.readings.clone(),
        warnings: device.warnings.clone(),
        trouble: device.trouble(),
    };
    DevicesChecked { format: DevicesFormat::V1, devices: checked.iter().map(device).collect() }
}
