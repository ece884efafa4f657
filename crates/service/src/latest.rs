//! The latest value of everything that is read: the one snapshot that the screen, the page and MQTT show.
//!
//! Values are taken from the same messages as a recording's; taking one costs a lookup. What the snapshot says of them is worked
//! out when somebody asks for it.

mod channel;
mod rate;
mod readiness;
mod say;

pub use readiness::{NotReady, Readiness};

use channel::ChannelValues;
use rate::Rate;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;
use trunnion::Machine;
use trunnion::page::losses;
use trunnion::results::{
    BallOffset, Live, LiveAxis, LiveCycle, LiveDevice, LiveFormat, LiveProbe, LiveTemperature, Zone,
};
use trunnion_acquire::config::channels;
use trunnion_acquire::{DeviceConfig, DeviceState, DeviceStatus};
use trunnion_core::channel::instrument_channels;
use trunnion_core::reading::{AxisReading, Message, Reading};
use trunnion_core::{Channel, Clock, Gap, HostTime, Joint, NestSide, Role, convert};
use trunnion_protocol::mtconnect::timestamp;
use trunnion_record::{RecordSender, RecorderStatus};
use trunnion_sync::plan::Plan;
use trunnion_sync::{NestCalibration, Progress};

/// A value older than this is none, s; the slowest indicators speak every second.
const OLD_S: f64 = 2.5;

/// Gaps of the cycle under way that are shown; all are in its recording.
const SHOWN_GAPS: usize = 5;

/// How the probes stand in the machine.
#[derive(Clone, Debug)]
pub struct Mounted {
    /// Probe directions.
    pub nest: NestCalibration,
    /// What the nest rides on.
    pub side: NestSide,
    /// The machine that moves it.
    pub machine: Machine,
}

impl Mounted {
    /// As the first setup of a cycle has it.
    pub fn of(plan: &Plan) -> Self {
        Self { nest: plan.nest, side: plan.cycle.setups[0].nest, machine: plan.machine.clone() }
    }
}

/// The latest values, shared by who takes them and who shows them.
#[derive(Clone)]
pub struct Latest {
    values: Arc<Mutex<Values>>,
    devices: Arc<[Named]>,
    channels: Arc<[Channel]>,
    states: Vec<watch::Receiver<DeviceStatus>>,
    clock: Arc<dyn Clock>,
    /// The recorder of the newest cycle. A lock of its own: the watchdog asks while the loop that hangs may hold that of the values.
    recorder: Arc<Mutex<Option<RecordSender>>>,
    /// Of the loop that takes them: odd while it works, even while it waits.
    turn: Arc<AtomicU64>,
}

/// The loop that takes values waits; it works again when this is dropped.
pub struct Turn(Arc<AtomicU64>);

impl Drop for Turn {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// What the configuration says of a device.
struct Named {
    name: String,
    driver: &'static str,
    range_mm: Option<[f64; 2]>,
    bar_zero_mm: Option<f64>,
}

impl Named {
    /// Measuring range of one of its channels, mm: that of a bar counts from where the bar does.
    fn range_mm(&self, channel: &Channel) -> Option<[f64; 2]> {
        let zero_mm = self.bar_zero_mm.filter(|_| channel.role == Role::Bar).unwrap_or(0.0);
        self.range_mm.map(|range_mm| range_mm.map(|end_mm| end_mm - zero_mm))
    }
}

#[derive(Default)]
struct Values {
    channels: Vec<ChannelValues>,
    /// Axis positions, and the device that reports them.
    axes: Option<(u16, AxisReading)>,
    /// Temperatures by channel, with the device, °C and time.
    temperatures: BTreeMap<String, (u16, f64, HostTime)>,
    /// Last warning of each device, by its index.
    warnings: BTreeMap<u16, String>,
    mounted: Option<Mounted>,
    cycle: Option<LiveCycle>,
    /// What the readings of the newest cycle put in doubt.
    doubt: Option<String>,
    rate: Rate,
}

impl Latest {
    /// Of devices with these states, in the same order; no value yet.
    pub fn new(
        devices: &[DeviceConfig],
        states: Vec<watch::Receiver<DeviceStatus>>,
        clock: Arc<dyn Clock>,
    ) -> Self {
        let channels = channels(devices);
        let none = channels.iter().map(|_| ChannelValues::default()).collect();
        let named = |d: &DeviceConfig| Named {
            name: d.name.clone(),
            driver: d.driver,
            range_mm: d.range_mm,
            bar_zero_mm: d.device.bar_zero_mm(),
        };
        Self {
            values: Arc::new(Mutex::new(Values { channels: none, ..Values::default() })),
            devices: devices.iter().map(named).collect(),
            channels: channels.into(),
            states,
            clock,
            recorder: Arc::default(),
            turn: Arc::default(),
        }
    }

    /// The loop that takes values waits until this is dropped.
    pub fn waits(&self) -> Turn {
        // One loop alone counts.
        let turn = Turn(self.turn.clone());
        turn.0.store((turn.0.load(Ordering::Relaxed) | 1) + 1, Ordering::Relaxed);
        turn
    }

    /// Odd while the loop works, even while it waits.
    pub fn turn(&self) -> u64 {
        self.turn.load(Ordering::Relaxed)
    }

    /// From now on the place of the ball is known from the probes.
    pub fn set_mounted(&self, mounted: Mounted) {
        self.lock().mounted = Some(mounted);
    }

    /// A cycle of this name is being measured, and how far it is; or none is.
    pub fn set_cycle(&self, cycle: Option<(&str, Progress, &[Gap])>) {
        self.lock().cycle = cycle.map(|(name, now, gaps)| LiveCycle {
            name: name.into(),
            state: "measuring".into(),
            done: now.done,
            planned: now.total,
            gaps: gaps.len(),
            newest_gaps: newest(gaps),
        });
    }

    /// The readings of the newest cycle put this in doubt, or nothing.
    pub fn set_doubt(&self, doubt: Option<String>) {
        self.lock().doubt = doubt;
    }

    /// What stands against the next cycle; `None` while one is measured, as that moves the probes.
    pub fn before_a_cycle(&self, needed: &[u16]) -> Option<Vec<NotReady>> {
        let is_measuring = self.lock().cycle.is_some();
        (!is_measuring).then(|| self.not_ready(needed))
    }

    /// Why a cycle that is measured with these channels should not begin: a channel without value, stuck, or out of its centre
    /// zone; a device that does not read. Empty when all is well.
    pub fn not_ready(&self, needed: &[u16]) -> Vec<NotReady> {
        let live = self.snapshot();
        let of_channel = |&index: &u16| {
            let channel = &self.channels[usize::from(index)];
            let probe = live.probes.iter().find(|probe| probe.name == channel.name)?;
            let why = probe.say.clone();
            (!probe.zone.is_good()).then(|| NotReady { source: probe.name.clone(), zone: probe.zone, why })
        };
        let measures = |device: usize| {
            self.channels.iter().any(|c| usize::from(c.device) == device && c.role != Role::Temperature)
        };
        // A device that measures is named by its channels.
        let others = live.devices.iter().enumerate().filter(|(index, _)| !measures(*index));
        let of_device = |(_, device): (usize, &LiveDevice)| {
            let (source, zone) = (device.name.clone(), Zone::NoValue);
            device.remedy.clone().map(|why| NotReady { source, zone, why })
        };
        needed.iter().filter_map(of_channel).chain(others.filter_map(of_device)).collect()
    }

    /// A cycle is recorded by this recorder.
    pub fn set_recorder(&self, recorder: RecordSender) {
        *self.recorder.lock().unwrap_or_else(PoisonError::into_inner) = Some(recorder);
    }

    /// How the recorder of the newest cycle is doing; `None` before the first.
    pub fn recorder(&self) -> Option<RecorderStatus> {
        let recorder = self.recorder.lock().unwrap_or_else(PoisonError::into_inner);
        recorder.as_ref().map(RecordSender::status)
    }

    /// Readings of all devices, 1/s.
    pub fn readings_per_s(&self) -> f64 {
        self.lock().rate.per_s()
    }

    /// Takes a message of a device.
    pub fn take(&self, message: &Message) {
        let mut values = self.lock();
        match &message.reading {
            Reading::Probe(reading) => {
                values.rate.take(reading.arrival);
                if let Some(channel) = values.channels.get_mut(usize::from(reading.channel)) {
                    channel.take(reading);
                }
            }
            Reading::Axes(reading) => {
                values.rate.take(reading.arrival);
                values.axes = Some((message.device, *reading));
            }
            Reading::Temperature(reading) => {
                values
                    .temperatures
                    .insert(reading.name.clone(), (message.device, reading.degc, reading.arrival));
            }
            Reading::Log(line) if line.warning => {
                values.warnings.insert(message.device, line.text.clone());
            }
            Reading::Log(_) | Reading::Controller(_) | Reading::Counters(_) | Reading::Gap(_) => {}
        }
    }

    /// Everything as it is now.
    pub fn snapshot(&self) -> Live {
        let (values, now) = (self.lock(), self.clock.now());
        let devices = self.devices();
        let probes = self.probes(&values, now, &devices);
        let (ball, ball_said) = self.ball(&values, &probes);
        let say = say::sentences(values.doubt.as_deref(), &devices, &probes, ball_said);
        let axes_device = values.axes.map_or_else(String::new, |(device, _)| self.device(device));
        let fresh = |at: HostTime| now.seconds_since(at) <= OLD_S;
        let temperature = |(name, (device, degc, at)): (&String, &(u16, f64, HostTime))| LiveTemperature {
            name: name.clone(),
            device: self.device(*device),
            value_degc: Some(*degc).filter(|degc| degc.is_finite() && fresh(*at)),
        };
        Live {
            format: LiveFormat::V1,
            at: timestamp(self.clock.wall_ns()).to_string(),
            ball_offset_mm: ball,
            say,
            axes: self.axes(&values).iter().flat_map(|axes| live_axes(axes, &axes_device)).collect(),
            devices,
            temperatures: values.temperatures.iter().map(temperature).collect(),
            cycle: values.cycle.clone(),
            probes,
        }
    }

    /// Axes that stand may be silent for long: their last positions hold while the controller is connected.
    fn axes(&self, values: &Values) -> Option<AxisReading> {
        let (device, axes) = values.axes?;
        let state = self.states.get(usize::from(device))?.borrow().state;
        matches!(state, DeviceState::Streaming | DeviceState::Stuck).then_some(axes)
    }

    fn probes(&self, values: &Values, now: HostTime, devices: &[LiveDevice]) -> Vec<LiveProbe> {
        let measuring = |(index, channel): (usize, &Channel)| {
            (channel.role != Role::Temperature)
                .then(|| self.probe(values, now, index, (channel, &devices[usize::from(channel.device)])))
        };
        self.channels.iter().enumerate().filter_map(measuring).collect()
    }

    fn probe(
        &self,
        values: &Values,
        now: HostTime,
        index: usize,
        (channel, live): (&Channel, &LiveDevice),
    ) -> LiveProbe {
        let device = &self.devices[usize::from(channel.device)];
        let range_mm = device.range_mm(channel);
        let value_mm = values.channels[index].value_mm(now, OLD_S);
        let stuck = value_mm.and_then(|_| self.stuck(values, now, index));
        let zone = match stuck {
            Some(_) => Zone::Stuck,
            None => Zone::of(value_mm, range_mm),
        };
        let centre_mm = range_mm.map(|[from_mm, to_mm]| (from_mm + to_mm) / 2.0);
        let warning = values.warnings.get(&channel.device).filter(|text| text.starts_with(&channel.name));
        // A device that does not read has no value for a reason of its own; of one that is stuck its channel says more.
        let remedy = live.remedy.as_ref().filter(|remedy| *remedy != say::STUCK).or(warning);
        let say = say::probe(zone, value_mm.zip(centre_mm), stuck, remedy.map(String::as_str));
        let (name, role) = (channel.name.clone(), channel.role.name().into());
        LiveProbe { name, device: device.name.clone(), role, value_mm, range_mm, centre_mm, zone, say }
    }

    /// For how long a channel has kept one number, s, while another of the same kind, which is named, trembled.
    fn stuck(&self, values: &Values, now: HostTime, index: usize) -> Option<(f64, &str)> {
        let kept_s = values.channels[index].kept_s(now)?;
        let driver = |k: usize| self.devices[usize::from(self.channels[k].device)].driver;
        let other = (0..self.channels.len())
            .find(|&k| k != index && driver(k) == driver(index) && values.channels[k].trembles())?;
        Some((kept_s, &self.channels[other].name))
    }

    /// The ball from the centre in directions of the machine, and what to say of it.
    fn ball(&self, values: &Values, probes: &[LiveProbe]) -> (Option<BallOffset>, Option<String>) {
        let Some(three) = instrument_channels(&self.channels, false) else { return (None, None) };
        let Some(mounted) = &values.mounted else { return (None, Some(say::NO_NEST.into())) };
        let of = |channel: &u16| {
            let name = &self.channels[usize::from(*channel)].name;
            probes.iter().find(|probe| probe.name == *name)
        };
        let three: Vec<&LiveProbe> = three.iter().filter_map(of).collect();
        if three.iter().any(|probe| probe.centre_mm.is_none()) {
            return (None, Some(say::NO_RANGE.into()));
        }
        let off: Option<Vec<f64>> =
            three.iter().map(|probe| Some(probe.value_mm? - probe.centre_mm?)).collect();
        let Some(off_mm) = off.and_then(|off| <[f64; 3]>::try_from(off).ok()) else { return (None, None) };
        let ball_in_nest_mm = mounted.nest.reading_mm(off_mm);
        let position = self.axes(values).map(|axes| axes.position);
        let (machine, errors) = (&mounted.machine, Default::default());
        let (ball_mm, known) = match position {
            Some(position) => {
                let machine_from_nest = match mounted.side {
                    NestSide::Table => machine.machine_from_table(&position, &errors).rotation,
                    NestSide::Spindle => machine.machine_from_tool(&position, &errors).rotation,
                };
                (machine_from_nest * ball_in_nest_mm, true)
            }
            None => (ball_in_nest_mm, false),
        };
        let ball = BallOffset { x: ball_mm.x, y: ball_mm.y, z: ball_mm.z };
        (Some(ball), Some(say::ball(&ball, known)))
    }

    fn devices(&self) -> Vec<LiveDevice> {
        let device = |(named, state): (&Named, &watch::Receiver<DeviceStatus>)| {
            let status = state.borrow();
            let remedy = match (status.state, &status.last_end) {
                (DeviceState::Streaming, _) => None,
                (DeviceState::Stuck, _) => Some(say::STUCK.into()),
                (_, Some(end)) => Some(end.to_string()),
                (_, None) => Some("it is being asked".into()),
            };
            LiveDevice { name: named.name.clone(), state: format!("{:?}", status.state), remedy }
        };
        self.devices.iter().zip(&self.states).map(device).collect()
    }

    /// Name of a device; empty for one that there is not.
    fn device(&self, index: u16) -> String {
        self.devices.get(usize::from(index)).map_or_else(String::new, |device| device.name.clone())
    }

    fn lock(&self) -> MutexGuard<'_, Values> {
        self.values.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The newest gaps in words, the newest first.
fn newest(gaps: &[Gap]) -> Vec<String> {
    let newest = &gaps[gaps.len().saturating_sub(SHOWN_GAPS)..];
    losses(newest, 0).into_iter().rev().collect()
}

fn live_axes(axes: &AxisReading, device: &str) -> Vec<LiveAxis> {
    let axis = |joint: Joint| {
        let position = axes.position[joint];
        let (value, unit) = match joint.is_rotary() {
            true => (convert::deg_from_rad(position), "deg"),
            false => (position, "mm"),
        };
        LiveAxis { name: joint.to_string(), device: device.into(), value, unit: unit.into() }
    };
    Joint::ISO.into_iter().filter(|&joint| axes.present[joint]).map(axis).collect()
}

#[cfg(test)]
mod tests;
