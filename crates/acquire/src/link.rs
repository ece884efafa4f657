//! What the supervisor lends to a session: where readings go, whose clock is asked, and the status it publishes.

use crate::monitor::axes::{AxesFinding, AxisWatchdog};
use crate::monitor::temperatures::{Absence, TemperatureMonitor};
use crate::monitor::values::{Finding, ValueMonitor};
use crate::session_end::SessionEnd;
use crate::status::{DeviceState, DeviceStatus};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{mpsc, watch};
use trunnion_core::reading::{Counters, LogLine, Message, Reading, SourceGap};
use trunnion_core::{Clock, HostTime};

/// One device's end of the message queue. It never waits: when the queue is full, messages are dropped and counted,
/// and a gap is sent as soon as there is room.
pub struct Outlet {
    device: u16,
    name: String,
    sender: mpsc::Sender<Message>,
    dropping_since: Option<HostTime>,
    dropped: u64,
    lost_total: u64,
}

impl Outlet {
    /// For the device with this index and name.
    pub fn new(device: u16, name: String, sender: mpsc::Sender<Message>) -> Self {
        Self { device, name, sender, dropping_since: None, dropped: 0, lost_total: 0 }
    }

    fn send(&mut self, epoch: u32, reading: Reading, now: HostTime) {
        if let Some(from) = self.dropping_since {
            let gap = SourceGap {
                source: self.name.clone(),
                from,
                to: now,
                lost_readings: Some(self.dropped),
                reason: "the program did not take the readings in time".into(),
            };
            if !self.offer(epoch, Reading::Gap(gap)) {
                self.count_loss(now);
                return;
            }
            (self.dropping_since, self.dropped) = (None, 0);
        }
        if !self.offer(epoch, reading) {
            self.count_loss(now);
        }
    }

    fn offer(&self, epoch: u32, reading: Reading) -> bool {
        match self.sender.try_send(Message { device: self.device, epoch, reading }) {
            Ok(()) => true,
            Err(TrySendError::Full(_) | TrySendError::Closed(_)) => false,
        }
    }

    fn count_loss(&mut self, now: HostTime) {
        self.dropping_since.get_or_insert(now);
        self.dropped += 1;
        self.lost_total += 1;
    }
}

/// Totals are reported at most so often.
const COUNTERS_EVERY: Duration = Duration::from_secs(1);

/// The session's link to the rest of the program.
pub struct Link {
    /// Index of the device's first channel in the list of all channels.
    pub first_channel: u16,
    /// No reading for so long must end the session.
    pub silence: Duration,
    /// Totals of the connection. Readings and losses are counted here; what was damaged, the session counts.
    pub counters: Counters,
    clock: Arc<dyn Clock>,
    outlet: Outlet,
    status: watch::Sender<DeviceStatus>,
    epoch: u32,
    healthy: bool,
    last_reading: Option<HostTime>,
    /// When the program began to look for the device.
    began: HostTime,
    /// Reason of a gap still open: there is nothing since `last_reading`, or since `began`.
    gap_reason: Option<String>,
    /// When totals were reported last, and which.
    reported: Option<(HostTime, Counters)>,
    channel_names: Vec<String>,
    /// Channel of the ball bar with what it shows at its length, mm.
    bar_zero: Option<(u16, f64)>,
    values: ValueMonitor,
    axis_watchdog: AxisWatchdog,
    temperatures: TemperatureMonitor,
    /// Why a channel has no value.
    meanings: HashMap<u16, String>,
}

impl Link {
    /// For one device; the supervisor keeps it through all sessions. `channel_names` begin with `first_channel`.
    pub fn new(
        first_channel: u16,
        channel_names: Vec<String>,
        silence: Duration,
        clock: Arc<dyn Clock>,
        outlet: Outlet,
        status: watch::Sender<DeviceStatus>,
    ) -> Self {
        Self {
            first_channel,
            silence,
            counters: Counters::default(),
            outlet,
            status,
            epoch: 0,
            healthy: false,
            last_reading: None,
            began: clock.now(),
            clock,
            gap_reason: None,
            reported: None,
            channel_names,
            bar_zero: None,
            values: ValueMonitor::default(),
            axis_watchdog: AxisWatchdog::default(),
            temperatures: TemperatureMonitor::default(),
            meanings: HashMap::new(),
        }
    }

    /// From where the channel of a ball bar counts, mm: its readings become changes from there. The raw number stays as it is.
    pub fn set_bar_zero(&mut self, bar_zero: Option<(u16, f64)>) {
        self.bar_zero = bar_zero;
    }

    /// Name of the device.
    pub fn name(&self) -> &str {
        &self.outlet.name
    }

    /// Says why the channel's next reading has no value, and what to check. It is asked, reported and recorded when the value
    /// goes; what is said until there is a value again changes nothing.
    pub fn explain(&mut self, channel: u16, meaning: impl FnOnce() -> String) {
        if !self.values.is_without_value(channel) {
            self.meanings.insert(channel, meaning());
        }
    }

    /// The clocks of the host.
    pub fn clock(&self) -> &dyn Clock {
        &*self.clock
    }

    /// The present moment.
    pub fn now(&self) -> HostTime {
        self.clock.now()
    }

    /// Publishes what the device said of itself.
    pub fn identified(&mut self, identity: String) {
        self.log(false, format!("found {identity}"));
        self.status.send_modify(|status| status.identity = identity);
    }

    /// Sends a reading that arrived at `at`; it proves health.
    pub fn reading(&mut self, reading: Reading, at: HostTime) {
        if !self.healthy {
            self.healthy = true;
            self.status.send_modify(|status| status.state = DeviceState::Streaming);
        }
        self.close_gap(at);
        self.last_reading = Some(at);
        self.count(&reading);
        if let Reading::Temperature(temperature) = &reading
            && let Some(reported) = self.temperatures.see(temperature)
        {
            self.report_temperature(temperature.name.clone(), reported);
        }
        let mut reading = reading;
        if let Reading::Probe(probe) = &mut reading {
            if let Some((_, zero_mm)) = self.bar_zero.filter(|(channel, _)| *channel == probe.channel) {
                probe.value_mm -= zero_mm;
            }
            let (channel, finding) = (probe.channel, self.values.see(probe, at));
            finding.into_iter().for_each(|finding| self.report(channel, finding));
        }
        if let Some(finding) = self.axis_watchdog.see(&reading, at) {
            self.report_axes(finding, at);
        }
        self.send(reading);
    }

    /// Logs and records that axes stand while their program goes on.
    fn report_axes(&mut self, finding: AxesFinding, at: HostTime) {
        let state = match finding {
            AxesFinding::Stuck { since, blocks } => {
                let seconds = (at - since).as_secs_f64();
                self.log(
                    true,
                    format!(
                        "the program went on by {blocks} blocks in {seconds:.1} s but no axis moved; check that the \
                         controller's positions are live (adapter, machine lock, dry run)"
                    ),
                );
                DeviceState::Stuck
            }
            AxesFinding::Moving { since } => {
                self.gap(since, at, None, "axis positions were stuck while the program went on".into());
                DeviceState::Streaming
            }
        };
        self.status.send_modify(|status| status.state = state);
    }

    /// Logs that a temperature has gone, and records how long once it is back.
    fn report_temperature(&mut self, source: String, reported: Absence) {
        match reported {
            Absence::Begun => {
                self.log(true, format!("{source} has no temperature; check the sensor and its cable"));
            }
            Absence::Ended { from, to, readings } => {
                let (lost_readings, reason) = (Some(readings), "no temperature".into());
                self.send(Reading::Gap(SourceGap { source, from, to, lost_readings, reason }));
            }
        }
    }

    /// Logs and records what the values of a channel say about its device.
    fn report(&mut self, channel: u16, finding: Finding) {
        let index = usize::from(channel.saturating_sub(self.first_channel));
        let source = self.channel_names.get(index).unwrap_or(&self.outlet.name).clone();
        let meaning = |raw: i64| {
            self.meanings
                .get(&channel)
                .cloned()
                .unwrap_or_else(|| format!("the device sends {raw} in its place"))
        };
        let gap = match finding {
            Finding::NoValue { raw } => {
                let text = format!("{source} has no value: {}", meaning(raw));
                return self.log(true, text);
            }
            Finding::Stuck { raw, since } => {
                let seconds = (self.now() - since).as_secs_f64();
                self.log(
                    true,
                    format!(
                        "{source} is stuck: it has sent {raw} for {seconds:.1} s although it trembled before; check \
                         that the probe moves freely and that its display is not held"
                    ),
                );
                self.status.send_modify(|status| status.state = DeviceState::Stuck);
                return;
            }
            Finding::ValueAgain { from, to, readings, raw } => SourceGap {
                source,
                from,
                to,
                lost_readings: Some(readings),
                reason: format!("no value: {}", meaning(raw)),
            },
            Finding::Unstuck { from, to, readings, raw } => {
                let reason = format!("stuck at {raw}");
                SourceGap { source, from, to, lost_readings: Some(readings), reason }
            }
        };
        self.send(Reading::Gap(gap));
        if self.healthy && !self.values.is_stuck() && !self.axis_watchdog.is_stuck() {
            self.status.send_if_modified(|status| {
                let was_stuck = status.state == DeviceState::Stuck;
                if was_stuck {
                    status.state = DeviceState::Streaming;
                }
                was_stuck
            });
        }
    }

    fn count(&mut self, reading: &Reading) {
        let has_value = match reading {
            Reading::Probe(probe) => probe.value_mm.is_finite(),
            Reading::Temperature(temperature) => temperature.degc.is_finite(),
            Reading::Axes(_) => true,
            Reading::Controller(_) | Reading::Counters(_) | Reading::Gap(_) | Reading::Log(_) => return,
        };
        self.counters.readings += 1;
        self.counters.error_readings += u64::from(!has_value);
    }

    /// Counts and records that readings are missing although the connection stands.
    pub fn gap(&mut self, from: HostTime, to: HostTime, lost_readings: Option<u64>, reason: String) {
        self.counters.lost_readings += lost_readings.unwrap_or(0);
        let source = self.outlet.name.clone();
        self.send(Reading::Gap(SourceGap { source, from, to, lost_readings, reason }));
    }

    /// Records what was missing until now because there was no connection.
    fn close_gap(&mut self, to: HostTime) {
        if let Some(reason) = self.gap_reason.take() {
            let from = self.last_reading.unwrap_or(self.began);
            self.gap(from, to, None, reason);
        }
    }

    /// Moment of the last reading of this or an earlier session.
    pub fn last_reading(&self) -> Option<HostTime> {
        self.last_reading
    }

    /// A line for the log of the run and of the program.
    pub fn log(&mut self, warning: bool, text: String) {
        let device = &self.outlet.name;
        if warning {
            tracing::warn!(device, "{text}");
        } else {
            tracing::info!(device, "{text}");
        }
        let at = self.now();
        self.send(Reading::Log(LogLine { warning, text, at }));
    }

    /// Sends the totals of the connection when they changed and the last ones are a second old.
    pub fn report_counters(&mut self, at: HostTime) {
        if self.reported.is_none_or(|(sent, _)| at - sent >= COUNTERS_EVERY) {
            self.report_changed_counters(at);
        }
    }

    fn report_changed_counters(&mut self, at: HostTime) {
        if self.reported.map_or(Counters::default(), |(_, reported)| reported) != self.counters {
            self.reported = Some((at, self.counters));
            self.send(Reading::Counters(self.counters));
        }
    }

    fn send(&mut self, reading: Reading) {
        let now = self.clock.now();
        self.outlet.send(self.epoch, reading, now);
        let lost = self.outlet.lost_total;
        self.status.send_if_modified(|status| std::mem::replace(&mut status.lost_messages, lost) != lost);
    }

    pub(crate) fn begin(&mut self) {
        self.epoch += 1;
        self.healthy = false;
        (self.counters, self.reported) = (Counters::default(), None);
        let epoch = self.epoch;
        self.status.send_modify(|status| {
            status.epoch = epoch;
            // Attempts on an absent device are not worth a change of its state.
            if status.state != DeviceState::Absent || epoch == 1 {
                status.state = DeviceState::Connecting;
            }
        });
    }

    pub(crate) fn was_healthy(&self) -> bool {
        self.healthy
    }

    pub(crate) fn ended(&mut self, end: &SessionEnd) {
        let now = self.now();
        self.report_changed_counters(now);
        for (channel, finding) in self.values.end(now) {
            self.report(channel, finding);
        }
        for (name, absence) in self.temperatures.end(now) {
            self.report_temperature(name, absence);
        }
        if *end == SessionEnd::Cancelled {
            self.close_gap(now);
        } else if self.healthy || self.last_reading.is_none() {
            self.gap_reason.get_or_insert_with(|| end.to_string());
        }
        if self.status.borrow().last_end.as_ref() != Some(end) {
            let warning = !matches!(end, SessionEnd::Cancelled | SessionEnd::Absent { .. });
            self.log(warning, end.to_string());
        }
        self.healthy = false;
        let state = match end {
            SessionEnd::Absent { .. } => DeviceState::Absent,
            SessionEnd::Silent { .. } => DeviceState::Silent,
            SessionEnd::WrongDevice { .. } => DeviceState::WrongDevice,
            SessionEnd::Refused { .. } => DeviceState::Refused,
            SessionEnd::Cancelled => DeviceState::Stopped,
            SessionEnd::Disconnected(_) | SessionEnd::Protocol { .. } | SessionEnd::Restarted(_) => {
                DeviceState::Failed
            }
        };
        self.status.send_modify(|status| {
            status.state = state;
            status.ends[end.kind()] += 1;
            status.last_end = Some(end.clone());
        });
    }
}
