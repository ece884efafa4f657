//! What both sides say: frames, abort codes, errors.

use crate::canopen::objects::ObjectKey;
use std::fmt;
use thiserror::Error;

/// Longest object taken or given, bytes; bounds the memory a broken partner can claim.
pub const MAX_OBJECT_BYTES: usize = 64 * 1024;

/// SDO abort code (CiA 301 table 22); shown with its text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct AbortCode(pub u32);

impl AbortCode {
    /// Toggle bit not alternated.
    pub const TOGGLE: Self = Self(0x0503_0000);
    /// SDO protocol timed out.
    pub const TIMEOUT: Self = Self(0x0504_0000);
    /// Command specifier not valid or unknown.
    pub const COMMAND: Self = Self(0x0504_0001);
    /// Out of memory.
    pub const MEMORY: Self = Self(0x0504_0005);
    /// Attempt to write a read-only object.
    pub const READ_ONLY: Self = Self(0x0601_0002);
    /// Object does not exist.
    pub const NO_OBJECT: Self = Self(0x0602_0000);
    /// Length of the parameter does not match.
    pub const LENGTH: Self = Self(0x0607_0010);
    /// Sub-index does not exist.
    pub const NO_SUB_INDEX: Self = Self(0x0609_0011);
    pub(super) fn text(self) -> &'static str {
        match self.0 {
            0x0503_0000 => "toggle bit not alternated",
            0x0504_0000 => "SDO protocol timed out",
            0x0504_0001 => "command specifier not valid or unknown",
            0x0504_0002 => "invalid block size",
            0x0504_0003 => "invalid sequence number",
            0x0504_0004 => "CRC error",
            0x0504_0005 => "out of memory",
            0x0601_0000 => "unsupported access to an object",
            0x0601_0001 => "attempt to read a write-only object",
            0x0601_0002 => "attempt to write a read-only object",
            0x0602_0000 => "object does not exist",
            0x0604_0041 => "object cannot be mapped to a PDO",
            0x0604_0042 => "mapped objects would exceed the PDO length",
            0x0604_0043 => "general parameter incompatibility",
            0x0604_0047 => "general internal incompatibility in the device",
            0x0606_0000 => "access failed because of a hardware error",
            0x0607_0010 => "length of the parameter does not match",
            0x0607_0012 => "parameter too long",
            0x0607_0013 => "parameter too short",
            0x0609_0011 => "sub-index does not exist",
            0x0609_0030 => "value not valid",
            0x0609_0031 => "value too high",
            0x0609_0032 => "value too low",
            0x0609_0036 => "maximum value is less than minimum value",
            0x060A_0023 => "resource not available",
            0x0800_0000 => "general error",
            0x0800_0020 => "data cannot be transferred or stored",
            0x0800_0021 => "data cannot be transferred because of local control",
            0x0800_0022 => "data cannot be transferred in the present device state",
            0x0800_0023 => "no object dictionary present",
            0x0800_0024 => "no data available",
            _ => "unknown abort code",
        }
    }
}

impl fmt::Display for AbortCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({:08X}h)", self.text(), self.0)
    }
}

/// Why a transfer failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum SdoError {
    /// The node aborted.
    #[error("node refused {key}: {code}")]
    Aborted {
        /// The object.
        key: ObjectKey,
        /// The node's reason.
        code: AbortCode,
    },
    /// The answer does not belong to the request.
    #[error("node gave the answer {command:02X}h of {length} bytes, out of place while transferring {key}")]
    OutOfPlace {
        /// The object.
        key: ObjectKey,
        /// First byte of the answer, 0 if it had none.
        command: u8,
        /// Bytes of the answer; 8 is right.
        length: usize,
    },
    /// The bytes received are not as many as announced.
    #[error("node announced {announced} bytes of {key} and sent {got}")]
    Length {
        /// The object.
        key: ObjectKey,
        /// Bytes announced.
        announced: usize,
        /// Bytes received.
        got: usize,
    },
    /// More bytes than this program takes.
    #[error("{0} is longer than {MAX_OBJECT_BYTES} bytes")]
    TooLong(ObjectKey),
}

/// Command, object and data of an initiate or abort frame.
pub(super) fn object_frame(command: u8, key: ObjectKey, data: [u8; 4]) -> [u8; 8] {
    let [low, high] = key.index.to_le_bytes();
    [command, low, high, key.sub, data[0], data[1], data[2], data[3]]
}

pub(super) fn key_of(bytes: &[u8; 8]) -> ObjectKey {
    ObjectKey::new(u16::from_le_bytes([bytes[1], bytes[2]]), bytes[3])
}

pub(super) fn number_of(bytes: &[u8; 8]) -> u32 {
    u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]])
}

pub(super) fn abort_frame(key: ObjectKey, code: AbortCode) -> [u8; 8] {
    object_frame(ABORT, key, code.0.to_le_bytes())
}

/// A segment of up to seven bytes; `command` holds the toggle bit.
pub(super) fn segment_frame(toggle: bool, chunk: &[u8], last: bool) -> [u8; 8] {
    let unused = (7 - chunk.len()) as u8;
    let mut bytes = [0; 8];
    bytes[0] = toggle_bit(toggle) | unused << 1 | u8::from(last);
    bytes[1..=chunk.len()].copy_from_slice(chunk);
    bytes
}

/// Data and "last" flag of a segment.
pub(super) fn segment_of(bytes: &[u8; 8]) -> (&[u8], bool) {
    let unused = usize::from(bytes[0] >> 1 & 0b111);
    (&bytes[1..8 - unused], bytes[0] & 1 == 1)
}

pub(super) fn toggle_bit(toggle: bool) -> u8 {
    u8::from(toggle) << 4
}

pub(super) fn toggle_of(command: u8) -> bool {
    command & 0x10 != 0
}

pub(super) const ABORT: u8 = 0x80;

pub(super) const EXPEDITED: u8 = 0x02;

pub(super) const SIZE_GIVEN: u8 = 0x01;
