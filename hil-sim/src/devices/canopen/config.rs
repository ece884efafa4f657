//! What is on the bus.

use super::super::clock::DeviceClock;
use super::super::faults::ReplyFault;
use trunnion_protocol::canopen::NodeId;

/// What a node measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NodeKind {
    /// A linear encoder that shows the length of the ball bar, CiA 406.
    BallBar {
        /// Measuring step, nm.
        step_nm: u32,
        /// What the encoder shows at bar reading 0, mm; counts are not negative.
        zero_mm: f64,
    },
    /// A probe of ±1 mm, CiA 404, its value as I32 in mm.
    Probe {
        /// Which of the three readings it sees, 0..=2.
        channel: usize,
        /// Decimal digits of the value.
        digits: u8,
    },
    /// A thermometer, CiA 404, its value as I16 in °C.
    Thermometer {
        /// Decimal digits of the value.
        digits: u8,
    },
}

/// One node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeConfig {
    /// Its number.
    pub id: NodeId,
    /// What it measures.
    pub kind: NodeKind,
    /// Serial number, 1018h:04.
    pub serial: u32,
    /// Producer heartbeat time, ms; 0 for none.
    pub heartbeat_ms: u16,
    /// Event timer of TPDO 1, ms; 0 switches TPDO 1 off, so that only SYNC asks for values.
    pub event_timer_ms: u16,
    /// Its clock, which runs heartbeat and event timer.
    pub clock: DeviceClock,
}

/// What an adapter makes of the command to listen without a word on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Listening {
    /// It obeys.
    #[default]
    Obeyed,
    /// It answers that it cannot.
    Refused,
    /// It does not answer.
    Ignored,
}

/// An adapter and the nodes on its bus.
#[derive(Debug, Clone, PartialEq)]
pub struct BusConfig {
    /// The nodes; each number once.
    pub nodes: Vec<NodeConfig>,
    /// Clock of the adapter, which stamps frames in ms modulo 60 000.
    pub adapter_clock: DeviceClock,
    /// What the adapter makes of `L`, by which it would only listen.
    pub listening: Listening,
    /// What happens to the SDO answer of a number, counted from 0 over all nodes.
    pub sdo_fault: Option<(u64, SdoFault)>,
    /// What happens to the frame of this kind and number, counted from 0 over all nodes.
    pub frame_fault: Option<(FrameKind, u64, ReplyFault)>,
}

/// Frames other than those of SDO.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameKind {
    /// Commands of the host (NMT).
    Command,
    /// Heartbeats and boot-up messages.
    Heartbeat,
    /// TPDOs.
    Values,
}

/// What happens to an SDO answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SdoFault {
    /// On its way.
    Reply(ReplyFault),
    /// Its node loses its supply for a moment and begins again, instead of answering.
    BootUp,
}
