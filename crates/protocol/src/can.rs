//! Classical CAN 2.0 frames, shared by slcan, SocketCAN and CANopen.

use thiserror::Error;

/// Identifier of a CAN frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CanId {
    /// 11 bits, 0..=7FFh.
    Standard(u16),
    /// 29 bits, 0..=1FFF_FFFFh.
    Extended(u32),
}

impl CanId {
    /// The number on the bus, without the kind.
    pub fn raw(self) -> u32 {
        match self {
            CanId::Standard(id) => u32::from(id),
            CanId::Extended(id) => id,
        }
    }

    fn in_range(self) -> bool {
        match self {
            CanId::Standard(id) => id <= 0x7FF,
            CanId::Extended(id) => id <= 0x1FFF_FFFF,
        }
    }
}

/// Why bytes are not a CAN frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CanError {
    /// The identifier needs more bits than its kind has.
    #[error("CAN identifier {0:?} is out of range: standard up to 7FFh, extended up to 1FFFFFFFh")]
    Id(CanId),
    /// More than eight data bytes.
    #[error("a classical CAN frame carries at most 8 bytes, not {0}")]
    Length(usize),
}

/// One classical CAN frame: data (0 to 8 bytes) or remote request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CanFrame {
    id: CanId,
    remote: bool,
    length: u8,
    bytes: [u8; 8],
}

impl CanFrame {
    /// A data frame; `data` holds at most eight bytes.
    pub fn data_frame(id: CanId, data: &[u8]) -> Result<Self, CanError> {
        if !id.in_range() {
            return Err(CanError::Id(id));
        }
        let mut bytes = [0; 8];
        bytes.get_mut(..data.len()).ok_or(CanError::Length(data.len()))?.copy_from_slice(data);
        Ok(Self { id, remote: false, length: data.len() as u8, bytes })
    }

    /// A remote request for `length` bytes (at most eight).
    pub fn remote_request(id: CanId, length: usize) -> Result<Self, CanError> {
        if !id.in_range() {
            return Err(CanError::Id(id));
        }
        if length > 8 {
            return Err(CanError::Length(length));
        }
        Ok(Self { id, remote: true, length: length as u8, bytes: [0; 8] })
    }

    /// The frame's identifier.
    pub fn id(&self) -> CanId {
        self.id
    }

    /// True for a remote request, which carries no data.
    pub fn is_remote(&self) -> bool {
        self.remote
    }

    /// Data length code, 0..=8; for a remote request the number of bytes asked for.
    pub fn dlc(&self) -> usize {
        usize::from(self.length)
    }

    /// The data bytes; empty for a remote request.
    pub fn data(&self) -> &[u8] {
        if self.remote { &[] } else { &self.bytes[..usize::from(self.length)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_refuse_what_the_bus_cannot_carry() {
        assert_eq!(
            CanFrame::data_frame(CanId::Standard(0x800), &[]),
            Err(CanError::Id(CanId::Standard(0x800)))
        );
        assert_eq!(
            CanFrame::remote_request(CanId::Extended(1 << 29), 0),
            Err(CanError::Id(CanId::Extended(1 << 29)))
        );
        assert_eq!(CanFrame::data_frame(CanId::Standard(1), &[0; 9]), Err(CanError::Length(9)));
        assert_eq!(CanFrame::data_frame(CanId::Standard(1), &[7; 8]).unwrap().data(), &[7; 8]);
        assert!(CanFrame::remote_request(CanId::Standard(1), 8).unwrap().data().is_empty());
    }
}
