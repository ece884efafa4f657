//! Object dictionary of a node: identity, communication parameters that can be written, and the values it measures.

use super::config::{NodeConfig, NodeKind};
use crate::devices::world::World;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::Arc;
use trunnion_protocol::canopen::cia404::{InputStatus, ProcessValue, STATUS_INDEX, Unit};
use trunnion_protocol::canopen::{
    AbortCode, CobId, ObjectDictionary, ObjectKey, PdoCommunication, PdoEntry, PdoMapping, RawBits,
    Transmission, cia404, cia406,
};

/// TPDO 1 by event timer, TPDO 2 by SYNC (CiA 406 default); the same for the probes.
pub(super) const TPDOS: u16 = 2;
const PROBE_RANGE_MM: RangeInclusive<f64> = -1.0..=1.0;
const THERMOMETER_RANGE_DEGC: RangeInclusive<f64> = -40.0..=100.0;
const HEARTBEAT: ObjectKey = ObjectKey::new(0x1017, 0);
const POSITION: ObjectKey = ObjectKey::new(0x6004, 0);
const NOT_MAPPABLE: AbortCode = AbortCode(0x0604_0041);
const PDO_TOO_LONG: AbortCode = AbortCode(0x0604_0042);

pub(super) struct Objects {
    world: Arc<dyn World>,
    kind: NodeKind,
    stored: BTreeMap<ObjectKey, Vec<u8>>,
    /// When a value asked for by SDO is measured, time of the cell, s.
    pub now_s: f64,
    /// What is measured lies outside the range.
    pub out_of_range: bool,
}

impl Objects {
    pub fn new(config: &NodeConfig, world: Arc<dyn World>) -> Self {
        let mut objects =
            Self { world, kind: config.kind, stored: BTreeMap::new(), now_s: 0.0, out_of_range: false };
        let (device_type, product, name) = match config.kind {
            NodeKind::BallBar { .. } => (8 << 16 | u32::from(cia406::PROFILE), 0x0406, "Ball bar (CiA 406)"),
            NodeKind::Probe { .. } => (2 << 16 | u32::from(cia404::PROFILE), 0x0404, "Probe (CiA 404)"),
            NodeKind::Thermometer { .. } => {
                (2 << 16 | u32::from(cia404::PROFILE), 0x0405, "Thermometer (CiA 404)")
            }
        };
        objects.store(0x1000, 0, &device_type.to_le_bytes());
        objects.store(0x1001, 0, &[0]);
        objects.store(0x1008, 0, name.as_bytes());
        objects.store(0x100A, 0, b"1.00");
        objects.store(HEARTBEAT.index, 0, &config.heartbeat_ms.to_le_bytes());
        objects.store(0x1018, 0, &[4]);
        for (sub, number) in [(1, 0x2D_u32), (2, product), (3, 0x0001_0000), (4, config.serial)] {
            objects.store(0x1018, sub, &number.to_le_bytes());
        }
        let off = if config.event_timer_ms == 0 { 0x8000_0000 } else { 0 };
        for (pdo, switched_off, transmission, event_timer_ms) in
            [(0, off, 254, config.event_timer_ms), (1, 0, 1, 0)]
        {
            let cob_id = CobId::Tpdo(pdo as u8 + 1, config.id).can_id().raw();
            objects.store(0x1800 + pdo, 0, &[5]);
            objects.store(0x1800 + pdo, 1, &(cob_id | switched_off).to_le_bytes());
            objects.store(0x1800 + pdo, 2, &[transmission]);
            objects.store(0x1800 + pdo, 5, &event_timer_ms.to_le_bytes());
            let entries = config.kind.values();
            objects.store(0x1A00 + pdo, 0, &[entries.len() as u8]);
            for (sub, entry) in (1..).zip(entries) {
                objects.store(0x1A00 + pdo, sub, &entry.to_raw().to_le_bytes());
            }
        }
        match config.kind {
            NodeKind::BallBar { step_nm, .. } => {
                objects.store(cia406::MEASURING_STEP.index, 0, &step_nm.to_le_bytes());
            }
            NodeKind::Probe { digits, .. } => objects.store_scale(Unit::MILLIMETRE, digits),
            NodeKind::Thermometer { digits } => objects.store_scale(Unit::CELSIUS, digits),
        }
        objects
    }

    fn store_scale(&mut self, unit: Unit, digits: u8) {
        self.store(cia404::unit_key(1).index, 1, &unit.raw.to_le_bytes());
        self.store(cia404::digits_key(1).index, 1, &[digits]);
    }

    /// Another device answers: digital inputs and outputs of another maker, CiA 401.
    pub fn become_another(&mut self) {
        self.store(0x1000, 0, &0x0003_0191_u32.to_le_bytes());
        self.store(0x1008, 0, b"I/O module (CiA 401)");
        self.store(0x1018, 1, &0x9A_u32.to_le_bytes());
        self.store(0x1018, 4, &99_u32.to_le_bytes());
    }

    /// Producer heartbeat time, s; `None` when there is no heartbeat.
    pub fn heartbeat_s(&self) -> Option<f64> {
        let ms = self.number(HEARTBEAT);
        (ms > 0).then(|| f64::from(ms) * 1e-3)
    }

    /// Identifier and timing of a TPDO, counted from 0.
    pub fn communication(&self, pdo: u16) -> PdoCommunication {
        PdoCommunication {
            cob_id_raw: self.number(ObjectKey::new(0x1800 + pdo, 1)),
            transmission: Transmission::from_raw(self.number(ObjectKey::new(0x1800 + pdo, 2)) as u8),
            event_timer_ms: self.number(ObjectKey::new(0x1800 + pdo, 5)) as u16,
        }
    }

    /// The data of a TPDO with the values measured at `t_s`.
    pub fn pdo_data(&self, pdo: u16, t_s: f64) -> Vec<u8> {
        let count = self.number(ObjectKey::new(0x1A00 + pdo, 0)) as u8;
        let entry = |sub| PdoEntry::from_raw(self.number(ObjectKey::new(0x1A00 + pdo, sub)));
        let mapping = PdoMapping::new((1..=count).map(entry).collect());
        let mapping = mapping.expect("a mapping is checked when it is written");
        mapping.encode(|key| self.measured(key, t_s).map_or(0, RawBits::unsigned))
    }

    fn measured(&self, key: ObjectKey, t_s: f64) -> Option<RawBits> {
        match (self.kind, key.index, key.sub) {
            (NodeKind::BallBar { step_nm, zero_mm }, 0x6004, 0) => {
                if self.out_of_range {
                    return Some(RawBits::new(0, 32));
                }
                let counts = ((zero_mm + self.world.bar_reading_mm(t_s)) * 1e6 / f64::from(step_nm)).round();
                Some(RawBits::new(u64::from(counts.max(0.0) as u32), 32))
            }
            (NodeKind::Probe { channel, digits }, index, 1) => {
                let seen_mm = self.world.probe_readings_mm(t_s)[channel];
                self.input(index, seen_mm, PROBE_RANGE_MM, digits)
            }
            (NodeKind::Thermometer { digits }, index, 1) => {
                self.input(index, self.world.temperature_degc(t_s), THERMOMETER_RANGE_DEGC, digits)
            }
            _ => None,
        }
    }

    /// Process value or status of an analogue input that sees this.
    fn input(&self, index: u16, seen: f64, range: RangeInclusive<f64>, digits: u8) -> Option<RawBits> {
        let reading = if self.out_of_range { f64::INFINITY } else { seen };
        let status = InputStatus(match reading {
            above if above > *range.end() => 0b011,
            below if below < *range.start() => 0b101,
            _ => 0,
        });
        if index == STATUS_INDEX {
            return Some(RawBits::new(u64::from(status.0), 8));
        }
        // A value outside the range is sent as the lowest integer.
        let shown = if status.is_good() { reading } else { f64::INFINITY };
        ProcessValue::of(index).map(|kind| kind.bits_of(shown, digits))
    }

    fn number(&self, key: ObjectKey) -> u32 {
        self.stored
            .get(&key)
            .and_then(|bytes| RawBits::from_bytes(bytes))
            .map_or(0, |raw| raw.unsigned() as u32)
    }

    fn store(&mut self, index: u16, sub: u8, bytes: &[u8]) {
        self.stored.insert(ObjectKey::new(index, sub), bytes.to_vec());
    }

    fn check_mapping(&self, pdo_index: u16, count: u8) -> Result<(), AbortCode> {
        let entry = |sub| PdoEntry::from_raw(self.number(ObjectKey::new(pdo_index, sub)));
        let entries: Vec<PdoEntry> = (1..=count).map(entry).collect();
        let mappable = self.kind.values();
        if entries.iter().any(|entry| entry.key.index > 0x1F && !mappable.contains(entry)) {
            return Err(NOT_MAPPABLE);
        }
        PdoMapping::new(entries).map(|_| ()).map_err(|_| PDO_TOO_LONG)
    }
}

impl NodeKind {
    /// The objects of the profile that can be mapped, in the order of the default mapping.
    fn values(self) -> Vec<PdoEntry> {
        match self {
            NodeKind::BallBar { .. } => vec![PdoEntry { key: POSITION, bits: 32 }],
            NodeKind::Probe { .. } => Self::input(0x9130, 32),
            NodeKind::Thermometer { .. } => Self::input(0x7130, 16),
        }
    }

    /// Process value and status of an analogue input.
    fn input(index: u16, bits: u8) -> Vec<PdoEntry> {
        let status = PdoEntry { key: ObjectKey::new(STATUS_INDEX, 1), bits: 8 };
        vec![PdoEntry { key: ObjectKey::new(index, 1), bits }, status]
    }
}

impl ObjectDictionary for Objects {
    fn read(&mut self, key: ObjectKey) -> Result<Vec<u8>, AbortCode> {
        if let Some(raw) = self.measured(key, self.now_s) {
            return Ok(raw.unsigned().to_le_bytes()[..usize::from(raw.bits()) / 8].to_vec());
        }
        self.stored.get(&key).cloned().ok_or_else(|| {
            let known = self.stored.keys().any(|stored| stored.index == key.index);
            if known { AbortCode::NO_SUB_INDEX } else { AbortCode::NO_OBJECT }
        })
    }

    fn write(&mut self, key: ObjectKey, data: &[u8]) -> Result<(), AbortCode> {
        let length = match (key.index, key.sub) {
            (0x1017, 0) => 2,
            (0x1800..=0x1801, 1) => 4,
            (0x1800..=0x1801, 2) => 1,
            (0x1800..=0x1801, 5) => 2,
            (0x1A00..=0x1A01, 0) => 1,
            (0x1A00..=0x1A01, 1..=8) => 4,
            _ => {
                self.read(key)?;
                return Err(AbortCode::READ_ONLY);
            }
        };
        if data.len() != length {
            return Err(AbortCode::LENGTH);
        }
        if let (0x1A00..=0x1A01, 0) = (key.index, key.sub) {
            self.check_mapping(key.index, data[0])?;
        } else if key.index >= 0x1A00 && self.number(ObjectKey::new(key.index, 0)) != 0 {
            return Err(AbortCode(0x0800_0022)); // a mapping in use is not changed (CiA 301 §7.5.2.36)
        }
        self.store(key.index, key.sub, data);
        Ok(())
    }
}
