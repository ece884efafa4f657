//! The rules of a session, without a connection: what is sent for a view, in which order, with which numbers [Sparkplug 3.0 §5, §6.4].

use super::metrics::{Metric, Metrics, Value, View};
use super::wire::{Payload, Properties, Property, WireMetric, WireValue};
use prost::Message as _;
use rumqttc::QoS;
use std::collections::BTreeMap;

/// Numbers of data types.
const INT64: u32 = 4;
const DOUBLE: u32 = 10;
const BOOLEAN: u32 = 11;
const STRING: u32 = 12;
/// Metrics that every node has.
const BD_SEQ: &str = "bdSeq";
const REBIRTH: &str = "Node Control/Rebirth";
/// The property of a metric in which hosts look for its unit.
const UNIT: &str = "engUnit";

/// A message on its way to the broker; never retained.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Where.
    pub topic: String,
    /// How surely.
    pub qos: QoS,
    /// What, encoded.
    pub payload: Vec<u8>,
}

/// An edge node from one birth to the next.
#[derive(Debug)]
pub struct Session {
    group: String,
    node: String,
    /// Number of the present CONNECT, which its birth and its death share; `None` before the first.
    bd_seq: Option<u8>,
    /// Number of the next message.
    seq: u8,
    /// What hosts know; `None` when the next message is a birth.
    known: Option<View>,
}

impl Session {
    /// Before the first connection.
    pub fn new(group: &str, node: &str) -> Self {
        Self { group: group.into(), node: node.into(), bd_seq: None, seq: 0, known: None }
    }

    /// The topic of commands of hosts.
    pub fn commands(&self) -> String {
        self.topic("NCMD", None)
    }

    /// The last will of the next CONNECT.
    pub fn next_death(&mut self) -> Message {
        self.bd_seq = Some(self.bd_seq.map_or(0, |number| number.wrapping_add(1)));
        self.death()
    }

    /// The death that belongs to the present birth: without a number of its own, for the broker sends it whenever we are lost.
    pub fn death(&self) -> Message {
        let payload = Payload { metrics: vec![self.bd_seq_metric(None)], ..Payload::default() };
        Message { topic: self.topic("NDEATH", None), qos: QoS::AtLeastOnce, payload: payload.encode_to_vec() }
    }

    /// Hosts know nothing, or nothing right: the next news begin with the birth.
    pub fn bear_again(&mut self) {
        self.known = None;
    }

    /// Whether a command asks for that.
    pub fn asks_for_rebirth(&self, payload: &[u8]) -> bool {
        let asks = |metric: &WireMetric| {
            metric.name.as_deref() == Some(REBIRTH) && metric.value == Some(WireValue::Boolean(true))
        };
        Payload::decode(payload).is_ok_and(|payload| payload.metrics.iter().any(asks))
    }

    /// What hosts do not know yet of a view, in the order in which it must be sent.
    pub fn news(&mut self, now: View, at_ms: u64) -> Vec<Message> {
        let Some(known) = self.known.take() else { return self.births(now, at_ms) };
        let Some((node, changed)) = followed(&known.node, now.node.clone()) else {
            return self.births(now, at_ms);
        };
        let mut messages = Vec::new();
        if !changed.is_empty() {
            messages.push(self.message("NDATA", None, &changed, at_ms));
        }
        let mut devices = BTreeMap::new();
        for name in known.devices.keys().filter(|name| !now.devices.contains_key(*name)) {
            messages.push(self.message("DDEATH", Some(name), &Metrics::new(), at_ms));
        }
        for (name, metrics) in now.devices {
            let before = known.devices.get(&name);
            let shown = match before.and_then(|before| followed(before, metrics.clone())) {
                Some((shown, changed)) => {
                    if !changed.is_empty() {
                        messages.push(self.message("DDATA", Some(&name), &changed, at_ms));
                    }
                    shown
                }
                None => {
                    messages.push(self.message("DBIRTH", Some(&name), &metrics, at_ms));
                    metrics
                }
            };
            devices.insert(name, shown);
        }
        self.known = Some(View { node, devices });
        messages
    }

    fn births(&mut self, now: View, at_ms: u64) -> Vec<Message> {
        self.seq = 0;
        let mut messages = vec![self.message("NBIRTH", None, &now.node, at_ms)];
        for (name, metrics) in &now.devices {
            messages.push(self.message("DBIRTH", Some(name), metrics, at_ms));
        }
        self.known = Some(now);
        messages
    }

    fn message(&mut self, kind: &str, device: Option<&str>, metrics: &Metrics, at_ms: u64) -> Message {
        let is_birth = kind.ends_with("BIRTH");
        let mut metrics: Vec<WireMetric> =
            metrics.iter().map(|(name, metric)| on_wire(name, metric, is_birth, at_ms)).collect();
        if kind == "NBIRTH" {
            let rebirth = Metric { value: Value::Flag(Some(false)), unit: String::new() };
            metrics.extend([self.bd_seq_metric(Some(at_ms)), on_wire(REBIRTH, &rebirth, true, at_ms)]);
        }
        let payload = Payload { timestamp: Some(at_ms), metrics, seq: Some(self.seq.into()) };
        self.seq = self.seq.wrapping_add(1);
        Message { topic: self.topic(kind, device), qos: QoS::AtMostOnce, payload: payload.encode_to_vec() }
    }

    fn bd_seq_metric(&self, at_ms: Option<u64>) -> WireMetric {
        WireMetric {
            name: Some(BD_SEQ.into()),
            timestamp: at_ms,
            datatype: Some(INT64),
            value: Some(WireValue::Long(self.bd_seq.unwrap_or(0).into())),
            ..WireMetric::default()
        }
    }

    fn topic(&self, kind: &str, device: Option<&str>) -> String {
        let node = format!("spBv1.0/{}/{kind}/{}", self.group, self.node);
        match device {
            Some(device) => format!("{node}/{}", part_of_topic(device)),
            None => node,
        }
    }
}

/// A name with what would change the topic replaced.
pub(super) fn part_of_topic(name: &str) -> String {
    name.replace(['/', '+', '#'], "_")
}

/// Metrics as they are now under the names of their birth, and those of them that changed; what is not there any more has no value. `None` when
/// there is one that the birth did not name.
fn followed(known: &Metrics, now: Metrics) -> Option<(Metrics, Metrics)> {
    let is_named = |(name, metric): (&String, &Metric)| {
        known
            .get(name)
            .is_some_and(|before| before.unit == metric.unit && before.value.none() == metric.value.none())
    };
    if !now.iter().all(is_named) {
        return None;
    }
    let mut shown = now;
    for (name, before) in known {
        let gone = || Metric { value: before.value.none(), unit: before.unit.clone() };
        shown.entry(name.clone()).or_insert_with(gone);
    }
    let changed = shown.iter().filter(|(name, metric)| known.get(*name) != Some(metric));
    let changed = changed.map(|(name, metric)| (name.clone(), metric.clone())).collect();
    Some((shown, changed))
}

/// Type and unit are in births alone.
fn on_wire(name: &str, metric: &Metric, is_birth: bool, at_ms: u64) -> WireMetric {
    let (datatype, value) = match &metric.value {
        Value::Text(text) => (STRING, text.clone().map(WireValue::Text)),
        Value::Number(number) => (DOUBLE, number.map(WireValue::Double)),
        Value::Count(count) => (INT64, count.map(|count| WireValue::Long(count.cast_unsigned()))),
        Value::Flag(flag) => (BOOLEAN, flag.map(WireValue::Boolean)),
    };
    let unit = || Properties {
        keys: vec![UNIT.into()],
        values: vec![Property { kind: Some(STRING), text: Some(metric.unit.clone()) }],
    };
    WireMetric {
        name: Some(name.into()),
        timestamp: Some(at_ms),
        datatype: is_birth.then_some(datatype),
        is_null: value.is_none().then_some(true),
        properties: (is_birth && !metric.unit.is_empty()).then(unit),
        value,
    }
}
