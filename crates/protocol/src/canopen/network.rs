//! Identifiers of the predefined connection set, NMT, SYNC, heartbeat, emergency (CiA 301 §7.2, §7.3).
//! 000 NMT, 080 SYNC, 080+id EMCY, 180/280/380/480+id TPDO1..4, 580+id SDO answer, 600+id SDO request,
//! 700+id heartbeat.

use crate::can::{CanFrame, CanId};
use thiserror::Error;

/// Node number, 1..=127.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(u8);

/// A node number outside 1..=127.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("CANopen node {0} is outside 1..=127")]
pub struct BadNodeId(pub u8);

impl NodeId {
    /// Checks the range 1..=127.
    pub fn new(id: u8) -> Result<Self, BadNodeId> {
        if (1..=127).contains(&id) { Ok(Self(id)) } else { Err(BadNodeId(id)) }
    }

    /// The number.
    pub fn get(self) -> u8 {
        self.0
    }
}

/// Identifiers of the predefined connection set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CobId {
    /// Network management, 000h.
    Nmt,
    /// SYNC, 080h.
    Sync,
    /// Emergency of a node.
    Emergency(NodeId),
    /// Transmit PDO 1..=4 of a node, as seen from the node.
    Tpdo(u8, NodeId),
    /// Receive PDO 1..=4 of a node.
    Rpdo(u8, NodeId),
    /// SDO answer, node to host.
    SdoAnswer(NodeId),
    /// SDO request, host to node.
    SdoRequest(NodeId),
    /// Heartbeat and boot-up.
    Heartbeat(NodeId),
}

impl CobId {
    /// The 11-bit identifier; PDO numbers beyond 4 have none of their own and are given that of PDO 4.
    pub fn can_id(self) -> CanId {
        let pdo = |number: u8| u16::from(number.clamp(1, 4) - 1) * 0x100;
        CanId::Standard(match self {
            CobId::Nmt => 0,
            CobId::Sync => 0x080,
            CobId::Emergency(node) => 0x080 + u16::from(node.0),
            CobId::Tpdo(number, node) => 0x180 + pdo(number) + u16::from(node.0),
            CobId::Rpdo(number, node) => 0x200 + pdo(number) + u16::from(node.0),
            CobId::SdoAnswer(node) => 0x580 + u16::from(node.0),
            CobId::SdoRequest(node) => 0x600 + u16::from(node.0),
            CobId::Heartbeat(node) => 0x700 + u16::from(node.0),
        })
    }

    /// The meaning of an identifier, unless it lies outside the predefined set. PDOs can be moved: for those ask
    /// the [`super::NodeDescription`].
    pub fn from_can_id(id: CanId) -> Option<Self> {
        let CanId::Standard(id) = id else { return None };
        let node = NodeId::new((id & 0x7F) as u8);
        Some(match (id & 0x780, node) {
            (0x000, Err(_)) => CobId::Nmt,
            (0x080, Err(_)) => CobId::Sync,
            (0x080, Ok(node)) => CobId::Emergency(node),
            (base @ (0x180 | 0x280 | 0x380 | 0x480), Ok(node)) => CobId::Tpdo((base >> 8) as u8, node),
            (base @ (0x200 | 0x300 | 0x400 | 0x500), Ok(node)) => CobId::Rpdo((base >> 8) as u8 - 1, node),
            (0x580, Ok(node)) => CobId::SdoAnswer(node),
            (0x600, Ok(node)) => CobId::SdoRequest(node),
            (0x700, Ok(node)) => CobId::Heartbeat(node),
            _ => return None,
        })
    }
}

/// Network management command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NmtCommand {
    /// 01h: operational.
    Start,
    /// 02h: stopped.
    Stop,
    /// 80h: pre-operational.
    EnterPreOperational,
    /// 81h: restart the node.
    ResetNode,
    /// 82h: restart its communication.
    ResetCommunication,
}

impl NmtCommand {
    /// The frame for one node, or for all.
    pub fn frame(self, node: Option<NodeId>) -> CanFrame {
        let command = match self {
            NmtCommand::Start => 0x01,
            NmtCommand::Stop => 0x02,
            NmtCommand::EnterPreOperational => 0x80,
            NmtCommand::ResetNode => 0x81,
            NmtCommand::ResetCommunication => 0x82,
        };
        frame(CobId::Nmt, &[command, node.map_or(0, NodeId::get)])
    }

    fn from_byte(byte: u8) -> Option<Self> {
        Some(match byte {
            0x01 => NmtCommand::Start,
            0x02 => NmtCommand::Stop,
            0x80 => NmtCommand::EnterPreOperational,
            0x81 => NmtCommand::ResetNode,
            0x82 => NmtCommand::ResetCommunication,
            _ => return None,
        })
    }
}

/// State reported by a heartbeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NmtState {
    /// 00h: just started; sent once.
    BootUp,
    /// 04h.
    Stopped,
    /// 05h: PDOs run.
    Operational,
    /// 7Fh: SDO only.
    PreOperational,
}

impl NmtState {
    /// The heartbeat (or boot-up) frame of a node.
    pub fn heartbeat(self, node: NodeId) -> CanFrame {
        let state = match self {
            NmtState::BootUp => 0x00,
            NmtState::Stopped => 0x04,
            NmtState::Operational => 0x05,
            NmtState::PreOperational => 0x7F,
        };
        frame(CobId::Heartbeat(node), &[state])
    }

    fn from_byte(byte: u8) -> Option<Self> {
        // Bit 7 toggles in node guarding answers, which share the identifier.
        Some(match byte & 0x7F {
            0x00 => NmtState::BootUp,
            0x04 => NmtState::Stopped,
            0x05 => NmtState::Operational,
            0x7F => NmtState::PreOperational,
            _ => return None,
        })
    }
}

/// Emergency object of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Emergency {
    /// Error code; 0000h: an error is over; 8100h.. communication; FF00h.. device specific.
    pub code: u16,
    /// Error register 1001h (bit 0 generic, 1 current, 2 voltage, 3 temperature, 4 communication, 5 profile,
    /// 7 manufacturer).
    pub register: u8,
    /// Manufacturer's bytes.
    pub detail: [u8; 5],
}

impl Emergency {
    /// The frame a node sends.
    pub fn frame(&self, node: NodeId) -> CanFrame {
        let mut bytes = [0; 8];
        bytes[..2].copy_from_slice(&self.code.to_le_bytes());
        bytes[2] = self.register;
        bytes[3..].copy_from_slice(&self.detail);
        frame(CobId::Emergency(node), &bytes)
    }
}

/// The SYNC frame; with a counter (1..=240) where 1019h asks for one.
pub fn sync_frame(counter: Option<u8>) -> CanFrame {
    match counter {
        None => frame(CobId::Sync, &[]),
        Some(counter) => frame(CobId::Sync, &[counter]),
    }
}

/// A frame of the predefined connection set with its meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Message {
    /// Network management for one node, or for all (`None`).
    Nmt(NmtCommand, Option<NodeId>),
    /// SYNC with its counter, if it has one.
    Sync(Option<u8>),
    /// Emergency.
    Emergency(NodeId, Emergency),
    /// Heartbeat or boot-up.
    Heartbeat(NodeId, NmtState),
    /// Transmit PDO on its predefined identifier; data in the frame.
    Tpdo(u8, NodeId),
    /// SDO answer; data in the frame.
    SdoAnswer(NodeId),
    /// SDO request; data in the frame.
    SdoRequest(NodeId),
}

impl Message {
    /// The meaning of a frame; `None` for remote requests, foreign identifiers and malformed contents.
    pub fn from_frame(frame: &CanFrame) -> Option<Self> {
        if frame.is_remote() {
            return None;
        }
        Some(match (CobId::from_can_id(frame.id())?, frame.data()) {
            (CobId::Nmt, &[command, node]) => {
                let target = if node == 0 { None } else { Some(NodeId::new(node).ok()?) };
                Message::Nmt(NmtCommand::from_byte(command)?, target)
            }
            (CobId::Sync, data) => Message::Sync(data.first().copied()),
            (CobId::Emergency(node), &[low, high, register, a, b, c, d, e]) => {
                let code = u16::from_le_bytes([low, high]);
                Message::Emergency(node, Emergency { code, register, detail: [a, b, c, d, e] })
            }
            (CobId::Heartbeat(node), &[state]) => Message::Heartbeat(node, NmtState::from_byte(state)?),
            (CobId::Tpdo(number, node), _) => Message::Tpdo(number, node),
            (CobId::SdoAnswer(node), _) => Message::SdoAnswer(node),
            (CobId::SdoRequest(node), _) => Message::SdoRequest(node),
            _ => return None,
        })
    }
}

pub(super) fn frame(cob_id: CobId, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(cob_id.can_id(), data)
        .expect("identifiers have 11 bits and the data at most 8 bytes")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(id: u8) -> NodeId {
        NodeId::new(id).unwrap()
    }

    #[test]
    fn every_predefined_identifier_comes_back() {
        for id in 1..=127 {
            let id = node(id);
            let of_node =
                [CobId::Emergency(id), CobId::SdoAnswer(id), CobId::SdoRequest(id), CobId::Heartbeat(id)];
            let pdos = (1..=4).flat_map(|n| [CobId::Tpdo(n, id), CobId::Rpdo(n, id)]);
            for cob_id in of_node.into_iter().chain(pdos).chain([CobId::Nmt, CobId::Sync]) {
                assert_eq!(CobId::from_can_id(cob_id.can_id()), Some(cob_id));
            }
        }
        assert_eq!(NodeId::new(128), Err(BadNodeId(128)));
        assert_eq!(CobId::Tpdo(2, node(4)).can_id(), CanId::Standard(0x284));
    }

    /// Bytes recorded between python canopen 2.4.1 nodes.
    #[test]
    fn network_frames_have_the_bytes_of_an_independent_stack() {
        let check = |frame: CanFrame, id: u16, data: &[u8], message: Message| {
            assert_eq!((frame.id(), frame.data()), (CanId::Standard(id), data));
            assert_eq!(Message::from_frame(&frame), Some(message));
        };
        check(NmtCommand::Start.frame(None), 0x000, &[1, 0], Message::Nmt(NmtCommand::Start, None));
        check(sync_frame(None), 0x080, &[], Message::Sync(None));
        check(
            NmtState::PreOperational.heartbeat(node(1)),
            0x701,
            &[0x7F],
            Message::Heartbeat(node(1), NmtState::PreOperational),
        );
        let emergency = Emergency { code: 0xFF01, register: 0x81, detail: [1, 0, 0, 0, 0] };
        let data = [0x01, 0xFF, 0x81, 1, 0, 0, 0, 0];
        check(emergency.frame(node(1)), 0x081, &data, Message::Emergency(node(1), emergency));
    }
}
