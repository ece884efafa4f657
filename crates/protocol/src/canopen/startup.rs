//! Reading a node before measuring: identity, the TPDOs that are switched on with their mapping, and for every
//! mapped object what its numbers mean (unit and digits, or step). Nothing is written; the node may be in any state
//! but stopped.
//!
//! The procedure is a function from what is known to what to read next (`next_read`), so that any answer,
//! including "does not exist", leads on.

use super::cia404::{self, ProcessValue, Unit};
use super::cia406::{self, EncoderValue};
use super::network::NodeId;
use super::node::{Identity, NodeDescription, Profile, Scaling, Tpdo, is_status};
use super::objects::ObjectKey;
use super::pdo::{PdoCommunication, PdoEntry, PdoError, PdoMapping, Transmission};
use super::sdo::{AbortCode, SdoError, SdoProgress, SdoTransfer};
use crate::can::CanFrame;
use std::collections::BTreeMap;
use thiserror::Error;

/// TPDOs asked for; measuring nodes have four or fewer.
const TPDOS: u16 = 8;
/// Objects a PDO can have at most (one bit each).
const MAX_ENTRIES: u8 = 64;

const DEVICE_TYPE: ObjectKey = ObjectKey::new(0x1000, 0);
const DEVICE_NAME: ObjectKey = ObjectKey::new(0x1008, 0);
const IDENTITY: u16 = 0x1018;

/// Answers so far.
type Known = BTreeMap<ObjectKey, Result<Vec<u8>, AbortCode>>;

/// Why a node could not be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum StartupError {
    /// A transfer failed.
    #[error("node {}: reading its description failed", node.get())]
    Transfer {
        /// The node.
        node: NodeId,
        /// What failed.
        source: SdoError,
    },
    /// An object every node of this kind must have.
    #[error("node {} has no usable {key} ({reason}); is it the right device?", node.get())]
    Missing {
        /// The node.
        node: NodeId,
        /// The object.
        key: ObjectKey,
        /// The node's answer, or a length that does not match.
        reason: AbortCode,
    },
    /// A mapping that cannot be.
    #[error("node {}: TPDO {number} has an impossible mapping", node.get())]
    Mapping {
        /// The node.
        node: NodeId,
        /// The TPDO.
        number: u16,
        /// What is wrong.
        source: PdoError,
    },
}

/// What a frame did to the procedure.
#[derive(Debug, Clone, PartialEq)]
pub enum StartupProgress {
    /// The frame is no SDO answer of this node.
    NotMine,
    /// Send this and wait for the next answer.
    Send(CanFrame),
    /// Everything is read.
    Done(Box<NodeDescription>),
    /// It failed; if there is a frame, send it.
    Failed {
        /// Why.
        error: StartupError,
        /// Abort for the node.
        abort: Option<CanFrame>,
    },
}

/// The procedure for one node.
#[derive(Debug, Clone)]
pub struct NodeStartup {
    node: NodeId,
    known: Known,
    transfer: SdoTransfer,
}

impl NodeStartup {
    /// Begins; send the frame.
    pub fn new(node: NodeId) -> (Self, CanFrame) {
        let (transfer, request) = SdoTransfer::upload(node, DEVICE_TYPE);
        (Self { node, known: Known::new(), transfer }, request)
    }

    /// The object being read, for messages about a timeout.
    pub fn reading(&self) -> ObjectKey {
        self.transfer.key()
    }

    /// Asks again when an answer stays out; send both frames. A transfer begins from its beginning: which of its segments was lost,
    /// nobody knows.
    pub fn ask_again(&mut self) -> [CanFrame; 2] {
        let (transfer, request) = SdoTransfer::upload(self.node, self.transfer.key());
        [std::mem::replace(&mut self.transfer, transfer).give_up(), request]
    }

    /// Ends the procedure when an answer stays out; send the frame.
    pub fn give_up(self) -> CanFrame {
        self.transfer.give_up()
    }

    /// Takes a frame from the bus.
    pub fn on_frame(&mut self, frame: &CanFrame) -> StartupProgress {
        let key = self.transfer.key();
        let answer = match self.transfer.on_frame(frame) {
            SdoProgress::NotMine => return StartupProgress::NotMine,
            SdoProgress::Send(frame) => return StartupProgress::Send(frame),
            SdoProgress::Done(data) => Ok(data),
            SdoProgress::Failed { error: SdoError::Aborted { code, .. }, .. } => Err(code),
            SdoProgress::Failed { error: source, abort } => {
                let error = StartupError::Transfer { node: self.node, source };
                return StartupProgress::Failed { error, abort };
            }
        };
        self.known.insert(key, answer);
        if let Some(next) = next_read(&self.known) {
            let (transfer, request) = SdoTransfer::upload(self.node, next);
            self.transfer = transfer;
            return StartupProgress::Send(request);
        }
        match describe(self.node, &self.known) {
            Ok(description) => StartupProgress::Done(Box::new(description)),
            Err(error) => StartupProgress::Failed { error, abort: None },
        }
    }
}

/// The first object worth reading that has no answer yet.
fn next_read(known: &Known) -> Option<ObjectKey> {
    let mut wanted = vec![DEVICE_TYPE, ObjectKey::new(IDENTITY, 0)];
    let identity_subs = number(known, ObjectKey::new(IDENTITY, 0)).unwrap_or(1).clamp(1, 4);
    wanted.extend((1..=identity_subs as u8).map(|sub| ObjectKey::new(IDENTITY, sub)));
    wanted.push(DEVICE_NAME);
    for pdo in 0..TPDOS {
        wanted.push(cob_id_key(pdo));
        if is_enabled(known, pdo) {
            wanted.extend([ObjectKey::new(0x1800 + pdo, 2), ObjectKey::new(0x1800 + pdo, 5)]);
            wanted.push(ObjectKey::new(0x1A00 + pdo, 0));
            wanted.extend(entry_keys(known, pdo));
        }
    }
    for key in mapped_objects(known) {
        wanted.extend(meaning_keys(known, key));
    }
    wanted.into_iter().find(|key| !known.contains_key(key))
}

/// The objects that say what the numbers of `key` mean.
fn meaning_keys(known: &Known, key: ObjectKey) -> Vec<ObjectKey> {
    let device_type = number(known, DEVICE_TYPE).unwrap_or(0);
    match Profile::of(device_type) {
        Profile::MeasuringDevice if ProcessValue::of(key.index).is_some() => {
            vec![cia404::unit_key(key.sub), cia404::digits_key(key.sub)]
        }
        Profile::Encoder if cia406::is_linear(device_type) => match EncoderValue::of(key.index) {
            Some(EncoderValue::Position | EncoderValue::SensorPosition) => {
                vec![cia406::POSITION_STEP, cia406::MEASURING_STEP]
            }
            Some(EncoderValue::Speed) => vec![cia406::SPEED_STEP],
            None => vec![],
        },
        _ => vec![],
    }
}

fn describe(node: NodeId, known: &Known) -> Result<NodeDescription, StartupError> {
    let need = |key: ObjectKey| {
        number(known, key).ok_or_else(|| {
            let reason = match known.get(&key) {
                Some(Err(code)) => *code,
                _ => AbortCode::LENGTH,
            };
            StartupError::Missing { node, key, reason }
        })
    };
    let identity = |sub| number(known, ObjectKey::new(IDENTITY, sub));
    let mut tpdos = Vec::new();
    for pdo in (0..TPDOS).filter(|&pdo| is_enabled(known, pdo)) {
        let communication = PdoCommunication {
            cob_id_raw: need(cob_id_key(pdo))?,
            transmission: Transmission::from_raw(need(ObjectKey::new(0x1800 + pdo, 2))? as u8),
            event_timer_ms: number(known, ObjectKey::new(0x1800 + pdo, 5)).unwrap_or(0) as u16,
        };
        need(ObjectKey::new(0x1A00 + pdo, 0))?;
        let entries: Result<Vec<_>, _> =
            entry_keys(known, pdo).map(|key| need(key).map(PdoEntry::from_raw)).collect();
        let number = pdo + 1;
        let mapping =
            PdoMapping::new(entries?).map_err(|source| StartupError::Mapping { node, number, source })?;
        tpdos.push(Tpdo { number, communication, mapping });
    }
    let scaling =
        mapped_objects(known).into_iter().filter_map(|key| Some((key, scaling(known, key)?))).collect();
    let name = known.get(&DEVICE_NAME).and_then(|answer| answer.as_ref().ok());
    Ok(NodeDescription {
        node,
        device_type: need(DEVICE_TYPE)?,
        identity: Identity {
            vendor: need(ObjectKey::new(IDENTITY, 1))?,
            product: identity(2),
            revision: identity(3),
            serial: identity(4),
        },
        name: name.map(|bytes| String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned()),
        tpdos,
        scaling,
    })
}

fn scaling(known: &Known, key: ObjectKey) -> Option<Scaling> {
    match Profile::of(number(known, DEVICE_TYPE)?) {
        Profile::MeasuringDevice if is_status(key) => Some(Scaling::Status),
        Profile::MeasuringDevice => Some(Scaling::Process {
            kind: ProcessValue::of(key.index)?,
            unit: Unit { raw: number(known, cia404::unit_key(key.sub))? },
            digits: number(known, cia404::digits_key(key.sub))? as u8,
        }),
        Profile::Encoder => match EncoderValue::of(key.index)? {
            EncoderValue::Speed => Some(Scaling::Speed { step: number(known, cia406::SPEED_STEP)? }),
            kind => {
                let step = number(known, cia406::POSITION_STEP).or(number(known, cia406::MEASURING_STEP));
                Some(Scaling::Position { kind, step_nm: step? })
            }
        },
        Profile::Other(_) => None,
    }
}

fn mapped_objects(known: &Known) -> Vec<ObjectKey> {
    let enabled = (0..TPDOS).filter(|&pdo| is_enabled(known, pdo));
    let entries = enabled.flat_map(|pdo| entry_keys(known, pdo));
    entries.filter_map(|key| number(known, key)).map(|raw| PdoEntry::from_raw(raw).key).collect()
}

fn cob_id_key(pdo: u16) -> ObjectKey {
    ObjectKey::new(0x1800 + pdo, 1)
}

fn is_enabled(known: &Known, pdo: u16) -> bool {
    number(known, cob_id_key(pdo)).is_some_and(|cob_id| cob_id & 0x8000_0000 == 0)
}

/// The mapping entries the node says are in use.
fn entry_keys(known: &Known, pdo: u16) -> impl Iterator<Item = ObjectKey> {
    let count = number(known, ObjectKey::new(0x1A00 + pdo, 0)).unwrap_or(0).min(u32::from(MAX_ENTRIES));
    (1..=count as u8).map(move |sub| ObjectKey::new(0x1A00 + pdo, sub))
}

/// An object read as an unsigned number of 1 to 4 bytes.
fn number(known: &Known, key: ObjectKey) -> Option<u32> {
    let bytes = known.get(&key)?.as_ref().ok()?;
    let mut number = [0; 4];
    number.get_mut(..bytes.len()).filter(|part| !part.is_empty())?.copy_from_slice(bytes);
    Some(u32::from_le_bytes(number))
}
