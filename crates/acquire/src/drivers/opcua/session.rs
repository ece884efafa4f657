//! One session: subscribe, bring the axes to common instants, report what the controller does.

#[cfg(test)]
mod tests;

use super::connect::{self, Connection, end_of};
use super::instants::{Instant, Instants};
use super::missing::{Missing, Stamped};
use super::nodes::{self, Nodes};
use super::settings::OpcUa;
use super::status::{execution, number, signal as signal_in, text};
use super::subscription::{Notification, Tap, Use, items, subscribe};
use crate::controller_stamp::of_measurement;
use crate::link::Link;
use crate::session_end::SessionEnd;
use opcua::types::{
    AttributeId, DataValue, DateTime, NodeId, ReadValueId, StatusCode, TimestampsToReturn, Variant,
};
use std::collections::HashSet;
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::time::MissedTickBehavior;
use trunnion_core::reading::{AxisReading, ControllerReading, Execution, Reading};
use trunnion_core::{AxisValues, HostTime, Joint};

/// Notifications between the library's task and this one.
const QUEUE: usize = 1024;
/// When nothing changed for so long, the server is asked whether it is still there.
const HEARTBEAT: Duration = Duration::from_millis(100);
/// Longest time from a change at the controller to its arrival here, beyond the publishing interval.
const ON_THE_WAY: Duration = Duration::from_millis(50);
/// An axis that reports nothing for so long, beyond three samplings, stands.
const HOLD: Duration = Duration::from_millis(20);
/// 100 ns ticks of OPC UA from 1601 to 1970.
const TICKS_TO_1970: i64 = 116_444_736_000_000_000;

/// From opening to the end.
pub(super) async fn run(device: &OpcUa, link: &mut Link) -> Result<Infallible, SessionEnd> {
    let mut connection = connect::open(device, link).await?;
    let nodes = nodes::find(device, &connection, link).await?;
    let letters: Vec<&str> = nodes.axes.iter().map(|axis| axis.letter.as_str()).collect();
    let security = if device.certificates.is_some() { "Basic256Sha256" } else { "no encryption" };
    link.identified(format!("OPC UA server {}, {security}, axes {}", connection.server, letters.join(" ")));
    let (items, heartbeat) = (items(&nodes), nodes.axes[0].node.clone());
    let mut model = Model::new(nodes, device.interval, link.now());
    let (sender, mut notifications) = mpsc::channel(QUEUE);
    let lost = Arc::new(AtomicU64::new(0));
    subscribe(device, &connection, &items, Tap { sender, lost: lost.clone() }, link).await?;
    let mut beats = tokio::time::interval(HEARTBEAT);
    beats.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            biased;
            ended = &mut connection.events => {
                let status = ended.unwrap_or(StatusCode::BadUnexpectedError);
                return Err(end_of(device, status, "the server closed the connection"));
            }
            notification = notifications.recv() => match notification {
                None => return Err(SessionEnd::Disconnected(format!("{}: the subscription ended", device.url))),
                Some(Notification::Ended(status)) => {
                    let why = format!("{}: the server ended the subscription ({status})", device.url);
                    return Err(SessionEnd::Disconnected(why));
                }
                Some(Notification::Values(values)) => model.take(values, link),
            },
            _ = beats.tick() => {
                if link.now() - model.heard >= HEARTBEAT {
                    ask_for_life(device, &connection, &heartbeat, link).await?;
                }
                if link.now() - model.moved >= HEARTBEAT && notifications.is_empty() {
                    model.nothing_changed(link);
                }
            }
        }
        model.check_silence(device, link)?;
        let missed = lost.swap(0, Ordering::Relaxed);
        if missed > 0 {
            let now = link.now();
            link.gap(model.heard, now, Some(missed), "notifications were not taken in time".into());
        }
        let now = link.now();
        link.report_counters(now);
    }
}

/// The server answers a read of a position.
async fn ask_for_life(
    device: &OpcUa,
    connection: &Connection,
    node: &NodeId,
    link: &Link,
) -> Result<(), SessionEnd> {
    let read = [ReadValueId::new(node.clone(), AttributeId::Value)];
    let asked = connection.session.read(&read, TimestampsToReturn::Source, 0.0);
    match tokio::time::timeout(link.silence, asked).await {
        Err(_) => Err(connect::silent(device, link.silence)),
        Ok(Err(error)) => Err(end_of(device, error.status(), "asking whether it is still there")),
        Ok(Ok(_)) => Ok(()),
    }
}

/// Latest values.
struct Model {
    nodes: Nodes,
    uses: Vec<Use>,
    instants: Instants,
    missing: Missing,
    delay: Duration,
    /// When the last notification came.
    heard: HostTime,
    /// When the last change of an axis came: the program may go on while all stand.
    moved: HostTime,
    /// When the last axis reading was sent.
    sent: HostTime,
    /// Axes without a value, with what the server says of them, and since when.
    bad: HashSet<usize>,
    bad_since: Option<(HostTime, String)>,
    sequence: u64,
    controller: (Execution, String, String, Option<u32>),
    /// Its stamp, while it is not reported yet.
    controller_ns: Option<i64>,
    /// What is not reported yet holds a new state of the program.
    state_changed: bool,
}

impl Model {
    fn new(nodes: Nodes, interval: Duration, now: HostTime) -> Self {
        let interval_ns = interval.as_nanos() as i64;
        let hold_ns = 3 * interval_ns + HOLD.as_nanos() as i64;
        let instants = Instants::new(nodes.axes.len(), interval_ns, hold_ns);
        let uses: Vec<Use> = items(&nodes).into_iter().map(|(what, _)| what).collect();
        Self {
            nodes,
            missing: Missing::new(uses.len(), now),
            uses,
            instants,
            delay: interval + ON_THE_WAY,
            heard: now,
            moved: now,
            sent: now,
            bad: HashSet::new(),
            bad_since: None,
            sequence: 0,
            controller: Default::default(),
            controller_ns: None,
            state_changed: false,
        }
    }

    fn take(&mut self, values: Vec<(u32, DataValue)>, link: &mut Link) {
        let arrival = link.now();
        for (handle, value) in values {
            let item = (handle as usize).checked_sub(1).filter(|item| *item < self.uses.len());
            let Some(item) = item else {
                link.counters.damaged += 1;
                continue;
            };
            let stamp_ns = stamp_ns(&value);
            self.overflow(item, &value, stamp_ns, arrival, link);
            match self.uses[item] {
                Use::Axis(axis) => self.axis(axis, &value, stamp_ns, arrival, link),
                other => {
                    // A message may hold the end of one program and the beginning of the next.
                    if matches!(other, Use::State) && self.state_changed {
                        self.report_controller(arrival, link);
                    }
                    self.state_changed |= matches!(other, Use::State);
                    self.state(other, &value);
                    self.controller_ns = Some(stamp_ns.unwrap_or_default());
                }
            }
        }
        self.heard = arrival;
        self.missing.notified();
        if self.bad.is_empty() {
            if let Some((since, why)) = self.bad_since.take() {
                link.gap(since, arrival, None, why);
            }
            let instants = self.instants.take();
            self.send(instants, false, link);
        }
        self.report_controller(arrival, link);
    }

    /// Values of an item that the server could not keep are a gap.
    fn overflow(
        &mut self,
        item: usize,
        value: &DataValue,
        stamp_ns: Option<i64>,
        arrival: HostTime,
        link: &mut Link,
    ) {
        let stamp_ns = stamp_ns.filter(|_| matches!(self.uses[item], Use::Axis(_)));
        let set_back = stamp_ns.is_some_and(|stamp_ns| self.instants.is_set_back(stamp_ns));
        let overflow = value.status().overflow();
        let found = self.missing.take(&Stamped { item, stamp_ns, set_back, overflow, arrival });
        if let Some((from, to)) = found {
            link.gap(from, to, Some(1), "the server's queue of an item ran over".into());
        }
    }

    /// While axes have no value, what the program does is no proof of health, and comes with them.
    fn report_controller(&mut self, arrival: HostTime, link: &mut Link) {
        let Some(stamp_ns) = self.controller_ns.take_if(|_| self.bad.is_empty()) else { return };
        self.state_changed = false;
        let (execution, program, block, signal) = self.controller.clone();
        let reading = ControllerReading { execution, program, block, signal, stamp_ns, arrival };
        link.reading(Reading::Controller(reading), arrival);
    }

    fn axis(
        &mut self,
        axis: usize,
        value: &DataValue,
        stamp_ns: Option<i64>,
        arrival: HostTime,
        link: &mut Link,
    ) {
        let position = vouched(value).and_then(number);
        let (Some(position), Some(stamp_ns)) = (position, stamp_ns) else {
            link.counters.error_readings += 1;
            self.bad.insert(axis);
            let letter = self.nodes.axes[axis].letter;
            let why = match position {
                Some(_) => format!("the server has no source time stamp for axis {letter}"),
                None => no_position(letter, value),
            };
            self.bad_since.get_or_insert((arrival, why));
            self.instants.forget();
            return;
        };
        self.bad.remove(&axis);
        self.moved = arrival;
        self.instants.sample(axis, stamp_ns, position * self.nodes.axes[axis].unit);
    }

    fn state(&mut self, what: Use, value: &DataValue) {
        let variant = vouched(value);
        let words = variant.map(text).unwrap_or_default();
        let (now, program, block, signal) = &mut self.controller;
        match what {
            Use::Program => *program = words,
            Use::State => *now = variant.map_or(Execution::Unknown, |v| execution(v, self.nodes.numbers)),
            Use::Block => *block = words,
            Use::Signal => *signal = variant.and_then(signal_in),
            Use::Axis(_) => {}
        }
    }

    /// The server is up and reported no change: all axes stand, as long after their stamp as after its arrival.
    fn nothing_changed(&mut self, link: &mut Link) {
        let waited = (link.now() - self.moved).saturating_sub(self.delay);
        let Some(newest_ns) = self.instants.newest_ns().filter(|_| self.bad.is_empty() && !waited.is_zero())
        else {
            return;
        };
        self.missing.stood_until(self.moved + waited);
        let instants = self.instants.all_stand(newest_ns + waited.as_nanos() as i64);
        self.send(instants, true, link);
    }

    fn send(&mut self, instants: Vec<Instant>, held: bool, link: &mut Link) {
        let arrival = link.now();
        let last = instants.len().saturating_sub(1);
        for (k, instant) in instants.into_iter().enumerate() {
            let (mut position, mut present) = (AxisValues::default(), AxisValues::default());
            for (axis, value) in self.nodes.axes.iter().zip(&instant.positions) {
                (position[axis.letter], present[axis.letter]) = (*value, true);
            }
            self.sequence += 1;
            self.sent = arrival;
            let reading = AxisReading {
                stamp_ns: instant.stamp_ns,
                arrival,
                position,
                present,
                sequence: self.sequence,
                // Only the last of them was carried on by the host's clock.
                held: held && k == last,
                skew_ns: instant.skew_ns,
            };
            link.reading(Reading::Axes(reading), arrival);
        }
    }

    fn check_silence(&self, device: &OpcUa, link: &Link) -> Result<(), SessionEnd> {
        let waited = link.now() - self.sent;
        if waited < link.silence.max(Duration::from_secs(1)) {
            return Ok(());
        }
        let who = match &self.bad_since {
            Some((_, why)) => format!("{}: {why}; is the server's link to the controller up?", device.url),
            None => format!("{} sends no positions of all axes", device.url),
        };
        Err(SessionEnd::Silent { who, waited })
    }
}

/// A value that the server stands for. One of uncertain quality may be old or a substitute [OPC UA part 8, table of status codes], and both
/// look like a measured one.
fn vouched(value: &DataValue) -> Option<&Variant> {
    value.value.as_ref().filter(|_| value.status().is_good())
}

/// Why a position is none.
fn no_position(letter: Joint, value: &DataValue) -> String {
    let status = value.status();
    match &value.value {
        _ if status.is_uncertain() => {
            format!("the server is not certain of the value of axis {letter} ({status})")
        }
        _ if !status.is_good() => format!("the server has no value for axis {letter} ({status})"),
        None | Some(Variant::Empty) => format!("the server sends Null for axis {letter}"),
        Some(_) => format!("the server sends no number for axis {letter}"),
    }
}

/// Source time stamp, ns since 1970; `None` where it is no time of a measurement.
fn stamp_ns(value: &DataValue) -> Option<i64> {
    let stamp: &DateTime = value.source_timestamp.as_ref().filter(|stamp| !stamp.is_null())?;
    let picoseconds = i64::from(value.source_picoseconds.unwrap_or(0)) * 10;
    let whole_ns = stamp.ticks().checked_sub(TICKS_TO_1970)?.checked_mul(100)?;
    of_measurement(whole_ns.checked_add(picoseconds / 1000)?)
}
