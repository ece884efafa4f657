//! What a node has said about itself, and the decoder of its TPDOs built from it.

use super::cia404::{InputStatus, ProcessValue, Quantity, STATUS_INDEX, Unit};
use super::cia406::{self, EncoderValue};
use super::network::NodeId;
use super::objects::{ObjectKey, RawBits};
use super::pdo::{PdoCommunication, PdoError, PdoMapping};
use crate::can::CanFrame;
use std::collections::BTreeMap;
use thiserror::Error;

/// Device profile, the low word of 1000h.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Profile {
    /// CiA 404, measuring device.
    MeasuringDevice,
    /// CiA 406, encoder.
    Encoder,
    /// Any other number.
    Other(u16),
}

impl Profile {
    /// From 1000h.
    pub fn of(device_type: u32) -> Self {
        match device_type as u16 {
            super::cia404::PROFILE => Self::MeasuringDevice,
            cia406::PROFILE => Self::Encoder,
            other => Self::Other(other),
        }
    }
}

/// Identity object 1018h; only the vendor is mandatory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Identity {
    /// Sub-index 1.
    pub vendor: u32,
    /// Sub-index 2.
    pub product: Option<u32>,
    /// Sub-index 3.
    pub revision: Option<u32>,
    /// Sub-index 4.
    pub serial: Option<u32>,
}

/// One transmit PDO that is switched on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tpdo {
    /// 1..=512, as in 1800h + number − 1.
    pub number: u16,
    /// Identifier and timing.
    pub communication: PdoCommunication,
    /// Objects in its frames.
    pub mapping: PdoMapping,
}

/// How the numbers of an object become quantities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scaling {
    /// CiA 404 process value.
    Process {
        /// Type of the object.
        kind: ProcessValue,
        /// Unit 6131h of its channel.
        unit: Unit,
        /// Digits 6132h of its channel.
        digits: u8,
    },
    /// CiA 404 status.
    Status,
    /// CiA 406 position, step in nm.
    Position {
        /// Signed or unsigned.
        kind: EncoderValue,
        /// Step, nm.
        step_nm: u32,
    },
    /// CiA 406 speed, step in 0.01 mm/s.
    Speed {
        /// Step, 0.01 mm/s.
        step: u32,
    },
}

/// A number with its meaning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// A quantity of a probe or encoder position.
    Quantity(Quantity),
    /// Speed, mm/s.
    SpeedMmPerS(f64),
    /// Status of the channel with the same sub-index.
    Status(InputStatus),
    /// The node marks the value as none (overload, sensor fault).
    NoValue,
    /// An object whose meaning the node did not report.
    Raw,
}

/// One object of a received TPDO.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The object; its sub-index is the channel in profile arrays.
    pub key: ObjectKey,
    /// The bits as sent, for the recording.
    pub raw: RawBits,
    /// Their meaning.
    pub value: Value,
}

/// A TPDO of this node whose data does not fit its mapping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("TPDO {number} of node {} cannot be decoded", node.get())]
pub struct DecodeError {
    /// The node.
    pub node: NodeId,
    /// The TPDO.
    pub number: u16,
    /// What is wrong.
    pub source: PdoError,
}

/// Everything read from a node at start.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeDescription {
    /// The node.
    pub node: NodeId,
    /// 1000h.
    pub device_type: u32,
    /// 1018h.
    pub identity: Identity,
    /// 1008h, if the node has a name.
    pub name: Option<String>,
    /// TPDOs that are switched on, by number.
    pub tpdos: Vec<Tpdo>,
    /// Meaning of the mapped objects; an object that is missing here is given raw.
    pub scaling: BTreeMap<ObjectKey, Scaling>,
}

impl NodeDescription {
    /// The device profile.
    pub fn profile(&self) -> Profile {
        Profile::of(self.device_type)
    }

    /// The readings of a frame: `None` when it is no TPDO of this node.
    pub fn decode(&self, frame: &CanFrame) -> Option<Result<Vec<Reading>, DecodeError>> {
        let tpdo = self.tpdos.iter().find(|tpdo| tpdo.communication.can_id() == frame.id())?;
        if frame.is_remote() {
            return None;
        }
        let objects = tpdo.mapping.decode(frame.data());
        Some(match objects {
            Ok(objects) => Ok(objects.into_iter().map(|(key, raw)| self.reading(key, raw)).collect()),
            Err(source) => Err(DecodeError { node: self.node, number: tpdo.number, source }),
        })
    }

    fn reading(&self, key: ObjectKey, raw: RawBits) -> Reading {
        let value = match self.scaling.get(&key) {
            None => Value::Raw,
            Some(Scaling::Process { kind, unit, digits }) => kind
                .number(raw, *digits)
                .map_or(Value::NoValue, |number| Value::Quantity(unit.quantity(number))),
            Some(Scaling::Status) => Value::Status(InputStatus(raw.unsigned() as u8)),
            Some(Scaling::Position { kind, step_nm }) => {
                Value::Quantity(Quantity::LengthMm(cia406::position_mm(kind.counts(raw), *step_nm)))
            }
            Some(Scaling::Speed { step }) => {
                Value::SpeedMmPerS(cia406::speed_mm_per_s(EncoderValue::Speed.counts(raw), *step))
            }
        };
        Reading { key, raw, value }
    }

    /// Identifiers of the TPDOs that belong to the instant of a SYNC.
    pub fn synchronous_tpdos(&self) -> impl Iterator<Item = &Tpdo> {
        self.tpdos.iter().filter(|tpdo| tpdo.communication.transmission.is_synchronous())
    }
}

/// True for objects that [`Scaling::Status`] describes.
pub(super) fn is_status(key: ObjectKey) -> bool {
    key.index == STATUS_INDEX
}
