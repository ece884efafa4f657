//! The agent's ring buffer of observations and what it answers from it.

use super::AgentConfig;
use super::controller::Line;
use std::collections::VecDeque;
use trunnion_protocol::mtconnect::{
    AgentError, Category, DataItem, Device, DevicesDocument, ErrorDocument, Header, Observation,
    ObservedValue, StreamsDocument, element_name,
};

/// One change of one data item.
#[derive(Debug, Clone)]
struct Change {
    item: usize,
    sequence: u64,
    wall_ns: i64,
    value: ObservedValue,
}

pub(super) struct Buffer {
    instance_id: u64,
    size: usize,
    items: Vec<DataItem>,
    device: String,
    changes: VecDeque<Change>,
    latest: Vec<Change>,
    next_sequence: u64,
    filters_duplicates: bool,
}

impl Buffer {
    /// An agent just started: every item is unavailable until the first line.
    pub fn new(instance_id: u64, config: &AgentConfig, items: &[DataItem], wall_ns: i64) -> Self {
        let unavailable =
            |item| Change { item, sequence: item as u64 + 1, wall_ns, value: ObservedValue::Unavailable };
        let latest: Vec<Change> = (0..items.len()).map(unavailable).collect();
        let device = items.iter().find(|item| item.component.kind == "Device");
        Self {
            instance_id,
            size: config.buffer_size,
            filters_duplicates: config.filters_duplicates,
            items: items.to_vec(),
            device: device.map(|item| item.component.name.clone()).unwrap_or_default(),
            changes: latest.iter().cloned().collect(),
            next_sequence: latest.len() as u64 + 1,
            latest,
        }
    }

    /// Takes a line; values that are the same as before are no observations, but for samples of an agent that
    /// does not filter them.
    pub fn take(&mut self, line: Line) {
        for (item, value) in line.values.into_iter().enumerate() {
            let repeats = !self.filters_duplicates && self.items[item].category == Category::Sample;
            if self.latest[item].value == value && !repeats {
                continue;
            }
            let change = Change { item, sequence: self.next_sequence, wall_ns: line.wall_ns, value };
            self.next_sequence += 1;
            if self.changes.len() == self.size {
                self.changes.pop_front();
            }
            self.latest[item] = change.clone();
            self.changes.push_back(change);
        }
    }

    /// Observations were made that nobody can have any more.
    pub fn skip(&mut self, by: u32) {
        self.next_sequence += u64::from(by);
        self.changes.clear();
    }

    pub fn first_sequence(&self) -> u64 {
        self.changes.front().map_or(self.next_sequence, |change| change.sequence)
    }

    pub fn next_sequence(&self) -> u64 {
        self.next_sequence
    }

    pub fn probe(&self, devices: Vec<Device>, now_ns: i64) -> DevicesDocument {
        DevicesDocument { header: self.header(now_ns), devices }
    }

    pub fn current(&self, now_ns: i64) -> StreamsDocument {
        self.streams(self.latest.clone(), self.next_sequence, now_ns)
    }

    /// Up to `count` observations from `from` on; the header says where to go on. An error when `from` lies outside
    /// the buffer.
    pub fn sample(&self, from: u64, count: usize, now_ns: i64) -> Result<StreamsDocument, ErrorDocument> {
        let first = self.first_sequence();
        if from < first {
            return Err(self.refuse(
                "OUT_OF_RANGE",
                &format!("'from' must be greater than {}", first - 1),
                now_ns,
            ));
        }
        if from > self.next_sequence {
            let text = format!("'from' must be less than {}", self.next_sequence + 1);
            return Err(self.refuse("OUT_OF_RANGE", &text, now_ns));
        }
        // Sequence numbers in the buffer have no gaps.
        let changes: Vec<Change> =
            self.changes.iter().skip((from - first) as usize).take(count).cloned().collect();
        let next = from + changes.len() as u64;
        Ok(self.streams(changes, next, now_ns))
    }

    pub fn refuse(&self, code: &str, text: &str, now_ns: i64) -> ErrorDocument {
        let error = AgentError { code: code.into(), text: text.into() };
        ErrorDocument { header: self.header(now_ns), errors: vec![error] }
    }

    fn streams(&self, mut changes: Vec<Change>, next_sequence: u64, now_ns: i64) -> StreamsDocument {
        // Documents are grouped by component, which is the order of the items.
        changes.sort_by_key(|change| (change.item, change.sequence));
        StreamsDocument {
            header: self.header(now_ns),
            first_sequence: self.first_sequence(),
            last_sequence: self.next_sequence - 1,
            next_sequence,
            observations: changes.into_iter().map(|change| self.observation(change)).collect(),
        }
    }

    fn observation(&self, change: Change) -> Observation {
        let item = &self.items[change.item];
        Observation {
            data_item_id: item.id.clone(),
            device: self.device.clone(),
            component: item.component.kind.clone(),
            component_id: item.component.id.clone(),
            category: item.category,
            kind: element_name(&item.kind),
            sub_type: item.sub_type.clone(),
            sequence: change.sequence,
            timestamp_ns: change.wall_ns,
            value: change.value,
        }
    }

    fn header(&self, now_ns: i64) -> Header {
        Header {
            instance_id: self.instance_id,
            sender: "cell".into(),
            creation_time_ns: Some(now_ns),
            version: "1.6.0.0".into(),
            buffer_size: self.size as u64,
        }
    }
}
