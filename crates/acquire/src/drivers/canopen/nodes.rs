//! The nodes while they measure: values to readings, SYNC numbers, heartbeats, silence.

mod answers;

use super::description::NodeConfig;
use crate::link::Link;
use crate::session_end::SessionEnd;
use answers::Answers;
use std::time::Duration;
use trunnion_core::reading::{ProbeReading, Reading, TemperatureReading};
use trunnion_core::{HostTime, Role};
use trunnion_protocol::can::{CanFrame, CanId};
use trunnion_protocol::canopen::cia404::{InputStatus, Quantity};
use trunnion_protocol::canopen::node::Scaling;
use trunnion_protocol::canopen::{
    Message, NmtState, NodeDescription, RawBits, Reading as NodeReading, Transmission, Value,
};

/// Device clock of this driver: µs since the session began to measure.
const TICK_S: f64 = 1e-6;
/// After so many SYNCs without one acknowledgement the adapter gives none.
const SYNCS_WITHOUT_ACK: u64 = 10;
/// Bit of the error register 1001h for errors of what the device profile measures.
const PROFILE_ERROR: u8 = 0x20;
/// A SYNC that did not come back after this time will not.
const ECHO_LIMIT: Duration = Duration::from_millis(200);
/// A stamp so long before a SYNC was written is that of an earlier one.
const STAMP_SLACK: Duration = Duration::from_millis(1);
/// SYNCs whose moments are kept.
const SYNCS_KEPT: usize = 256;

/// All nodes of the bus.
pub(super) struct Nodes {
    nodes: Vec<Node>,
    began: HostTime,
    /// Moments of the last SYNCs, by index modulo the length.
    syncs: Vec<HostTime>,
    written: u64,
    accepted: u64,
    /// The moments are those of the frames on the bus, not of our writing them.
    stamped: bool,
}

struct Node {
    config: NodeConfig,
    channel: u16,
    description: NodeDescription,
    /// Values come with SYNC; those it sends by event are not taken.
    by_sync: bool,
    answers: Answers,
    /// TPDO that brought it.
    last_id: Option<CanId>,
    last_value: HostTime,
    /// It has reported an error of its measurement (emergency with error register bit 5, CiA 301 §7.5.2.2).
    cannot_measure: bool,
    heartbeat: Option<HostTime>,
    longest_heartbeat: Duration,
}

impl Nodes {
    pub(super) fn new(
        configs: &[NodeConfig],
        descriptions: Vec<NodeDescription>,
        first_channel: u16,
        began: HostTime,
    ) -> Self {
        let node = |(index, (config, description)): (usize, (&NodeConfig, NodeDescription))| Node {
            config: *config,
            channel: first_channel + index as u16,
            by_sync: has_synchronous_value(&description),
            description,
            answers: Answers::of(config.id.get()),
            last_id: None,
            last_value: began,
            cannot_measure: false,
            heartbeat: None,
            longest_heartbeat: Duration::ZERO,
        };
        let nodes = configs.iter().zip(descriptions).enumerate().map(node).collect();
        Self { nodes, began, syncs: vec![began; SYNCS_KEPT], written: 0, accepted: 0, stamped: false }
    }

    pub(super) fn sync_written(&mut self, at: HostTime) {
        self.written += 1;
        self.syncs[self.written as usize % SYNCS_KEPT] = at;
    }

    /// True when fewer than `most` SYNCs are under way. A single one whose answer stays out is given up; where several may be,
    /// each keeps its place until it is acknowledged, unless the adapter acknowledges nothing.
    pub(super) fn may_sync(&mut self, most: u64, now: HostTime, link: &mut Link) -> bool {
        if self.written - self.accepted < most {
            return true;
        }
        if most > 1 {
            return self.accepted == 0;
        }
        let written_at = self.syncs[self.written as usize % SYNCS_KEPT];
        let given_up = now - written_at > ECHO_LIMIT;
        if given_up {
            self.accepted = self.written;
            let reason = "the interface lost a SYNC, and none was sent until it was given up".into();
            link.gap(written_at, now, None, reason);
        }
        given_up
    }

    /// The oldest SYNC under way was sent, at a moment the transport may know better than we.
    pub(super) fn sync_accepted(&mut self, at: Option<HostTime>) {
        let written_at = self.syncs[self.written as usize % SYNCS_KEPT];
        if let Some(at) = at.filter(|&at| written_at - at > STAMP_SLACK) {
            // The one given up came back after all; its values follow.
            self.syncs[self.accepted as usize % SYNCS_KEPT] = at;
            return;
        }
        self.accepted = (self.accepted + 1).min(self.written);
        if let Some(at) = at {
            self.syncs[self.accepted as usize % SYNCS_KEPT] = at;
            self.stamped = true;
        }
    }

    /// Index of the SYNC that values arriving now belong to.
    fn sync_now(&self) -> u64 {
        let silent_adapter = self.accepted == 0 && self.written > SYNCS_WITHOUT_ACK;
        let index = if silent_adapter { self.written } else { self.accepted };
        index.max(self.written.saturating_sub(SYNCS_KEPT as u64 - 1))
    }

    pub(super) fn take(
        &mut self,
        frame: &CanFrame,
        arrival: HostTime,
        link: &mut Link,
    ) -> Result<(), SessionEnd> {
        if let Some(message) = Message::from_frame(frame) {
            self.supervise(message, arrival, link)?;
        }
        let mut sync = self.sync_now();
        // Stamps come with the echo of the interface, which is not lost: a second answer before it is a late one.
        if !self.stamped
            && sync < self.written
            && self.nodes.iter().any(|node| node.has_answered(sync, frame))
        {
            // A node answers each SYNC once: the acknowledgement of the next one was lost.
            self.sync_accepted(None);
            link.counters.resyncs += 1;
            sync = self.sync_now();
        }
        let sync_at = self.syncs[sync as usize % SYNCS_KEPT];
        let (began, stamped) = (self.began, self.stamped);
        for node in &mut self.nodes {
            let Some(readings) = node.description.decode(frame) else { continue };
            let readings = readings.map_err(|error| SessionEnd::Restarted(error.source.to_string()))?;
            let every = node.every_sync(frame);
            if node.by_sync && every.is_none() {
                continue;
            }
            if every.is_some() && node.has_answered(sync, frame) {
                node.answers.came_again(arrival, link);
                continue;
            }
            let (sequence, moment) = match every {
                Some(_) => (sync, sync_at),
                None => (node.answers.last.map_or(1, |(count, _)| count + 1), arrival),
            };
            node.answers.came(sequence, every, moment, link);
            node.last_value = arrival;
            node.last_id = Some(frame.id());
            let ticks = (moment.0 - began.0).max(0).cast_unsigned() / 1000;
            let known = if stamped { moment } else { arrival };
            node.publish(&readings, sequence, ticks, known, link);
        }
        Ok(())
    }

    fn supervise(&mut self, message: Message, arrival: HostTime, link: &mut Link) -> Result<(), SessionEnd> {
        let find = |nodes: &mut Vec<Node>, id| nodes.iter().position(|node| node.config.id == id);
        match message {
            Message::Heartbeat(id, state) => {
                let Some(index) = find(&mut self.nodes, id) else { return Ok(()) };
                let node = &mut self.nodes[index];
                if let Some(last) = node.heartbeat {
                    node.longest_heartbeat = node.longest_heartbeat.max(arrival - last);
                }
                node.heartbeat = Some(arrival);
                // The start command may still be on its way in the first moments.
                if state == NmtState::BootUp || node.answers.last.is_some() && state != NmtState::Operational
                {
                    return Err(SessionEnd::Restarted(format!("node {} is {state:?}", id.get())));
                }
            }
            Message::Emergency(id, emergency) => {
                let (code, register) = (emergency.code, emergency.register);
                let mut text = format!("node {} emergency {code:04X}h, register {register:02X}h", id.get());
                if let Some(index) = find(&mut self.nodes, id) {
                    let node = &mut self.nodes[index];
                    node.cannot_measure = register & PROFILE_ERROR != 0;
                    if node.cannot_measure {
                        text += ": it cannot measure, its values are not taken until it says that the error is over";
                    }
                }
                link.log(code != 0, text);
            }
            Message::Nmt(..)
            | Message::Sync(_)
            | Message::Tpdo(..)
            | Message::SdoAnswer(_)
            | Message::SdoRequest(_) => {}
        }
        Ok(())
    }

    /// Every node must send values; one that once sent heartbeats must go on.
    pub(super) fn check_silence(&self, now: HostTime, silence: Duration) -> Result<(), SessionEnd> {
        for node in &self.nodes {
            let id = node.config.id.get();
            let waited = now - node.last_value;
            if waited > silence {
                return Err(SessionEnd::Silent { who: format!("node {id} sends no values"), waited });
            }
            let limit = silence.max(3 * node.longest_heartbeat);
            let known = node.longest_heartbeat > Duration::ZERO;
            if let Some(last) = node.heartbeat.filter(|&last| known && now - last > limit) {
                let who = format!("node {id} sends no heartbeat any more");
                return Err(SessionEnd::Silent { who, waited: now - last });
            }
        }
        Ok(())
    }

    /// At the end of a session, whose gap begins with the last value of any node: what is missing of those that were silent before.
    pub(super) fn count_silent(&self, link: &mut Link) {
        let of_sync = self.nodes.iter().filter(|node| node.by_sync);
        let answered = of_sync.filter_map(|node| node.answers.last).map(|(sync, _)| sync).max();
        for node in &self.nodes {
            match answered.filter(|_| node.by_sync) {
                Some(answered) => {
                    let until = self.syncs[answered as usize % SYNCS_KEPT];
                    node.answers.ended(self.began, answered, until, link);
                }
                None => {
                    let (now, others) = (link.now(), link.last_reading());
                    if now - node.last_value > link.silence && others > Some(node.last_value) {
                        let reason = format!("node {} sends no values", node.config.id.get());
                        link.gap(node.last_value, now, None, reason);
                    }
                }
            }
        }
    }
}

/// True when a TPDO bound to SYNC carries a measured value.
fn has_synchronous_value(description: &NodeDescription) -> bool {
    let mut keys =
        description.synchronous_tpdos().flat_map(|tpdo| tpdo.mapping.entries()).map(|entry| entry.key);
    keys.any(|key| {
        matches!(description.scaling.get(&key), Some(Scaling::Process { .. } | Scaling::Position { .. }))
    })
}

impl Node {
    /// True when this frame answers a SYNC and the node has answered this one already.
    fn has_answered(&self, sync: u64, frame: &CanFrame) -> bool {
        let same =
            self.answers.last.is_some_and(|(last, _)| last == sync) && self.last_id == Some(frame.id());
        same && self.every_sync(frame).is_some()
    }

    /// Values come after every so many SYNCs; none when they are not bound to SYNC.
    fn every_sync(&self, frame: &CanFrame) -> Option<u64> {
        let tpdo = self.description.tpdos.iter().find(|tpdo| tpdo.communication.can_id() == frame.id())?;
        match tpdo.communication.transmission {
            Transmission::EverySync(n) => Some(u64::from(n)),
            Transmission::SyncOnChange => Some(u64::MAX),
            Transmission::OnRequest | Transmission::Event | Transmission::Reserved(_) => None,
        }
    }

    fn publish(
        &self,
        readings: &[NodeReading],
        sequence: u64,
        device_ticks: u64,
        arrival: HostTime,
        link: &mut Link,
    ) {
        let is_temperature = self.config.role == Role::Temperature;
        let wanted = |r: &&NodeReading| match r.value {
            Value::NoValue => true,
            Value::Quantity(Quantity::TemperatureC(_)) => is_temperature,
            Value::Quantity(Quantity::LengthMm(_)) => !is_temperature,
            Value::Quantity(Quantity::Other { .. })
            | Value::SpeedMmPerS(_)
            | Value::Status(_)
            | Value::Raw => false,
        };
        let Some(found) = readings.iter().find(wanted) else {
            link.counters.damaged += 1; // a TPDO of this node that carries nothing for its role
            return;
        };
        let fault = self.fault(readings, found);
        let value = match found.value {
            Value::Quantity(Quantity::LengthMm(value) | Quantity::TemperatureC(value)) if fault.is_none() => {
                value
            }
            _ => f64::NAN,
        };
        let reading = match self.config.role {
            Role::Temperature => Reading::Temperature(TemperatureReading {
                name: format!("node-{}", self.config.id.get()),
                degc: value,
                arrival,
            }),
            Role::Probe(_) | Role::Bar => {
                if let Some(fault) = fault {
                    link.explain(self.channel, || fault.to_string());
                }
                Reading::Probe(ProbeReading {
                    channel: self.channel,
                    device_ticks,
                    tick_s: TICK_S,
                    sequence,
                    raw: found.raw.signed(),
                    value_mm: value,
                    arrival,
                })
            }
        };
        link.reading(reading, arrival);
    }

    /// Why the value found is none.
    fn fault(&self, readings: &[NodeReading], found: &NodeReading) -> Option<NoValue> {
        let status = readings.iter().find_map(|reading| match reading.value {
            Value::Status(status) if !status.is_good() => Some(NoValue::Status(status)),
            _ => None,
        });
        let emergency = self.cannot_measure.then_some(NoValue::Emergency);
        let marked = (found.value == Value::NoValue).then_some(NoValue::Marked(found.raw));
        emergency.or(status).or(marked)
    }
}

/// Why a node has no value, and what to check.
#[derive(Clone, Copy, Debug, thiserror::Error)]
enum NoValue {
    #[error(
        "the node reported by an emergency that it cannot measure; check its sensor or reading head, and the cable between"
    )]
    Emergency,
    #[error("the node calls its value {0}; bring it back into the range, or check the sensor and its cable")]
    Status(InputStatus),
    #[error("the node sends {:X}h, which CiA 404 keeps for no value; check that it is within its range, and the sensor and its cable", .0.unsigned())]
    Marked(RawBits),
}

#[cfg(test)]
mod tests;
