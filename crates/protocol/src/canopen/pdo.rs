//! TPDO communication (18xxh) and mapping (1Axxh) parameters, and the bit-exact decoder built from them.
//! A mapping entry is index (16 bits), sub-index (8), length in bits (8); entries follow each other without gaps,
//! least significant bit first (CiA 301 §7.5.2.36). Indices 0001h..001Fh are data types: padding.

use super::objects::{ObjectKey, RawBits, mask};
use crate::can::CanId;
use thiserror::Error;

/// One mapped object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PdoEntry {
    /// The object.
    pub key: ObjectKey,
    /// Its length in bits, 1..=64.
    pub bits: u8,
}

impl PdoEntry {
    /// From the number in 1Axxh.
    pub fn from_raw(raw: u32) -> Self {
        let [bits, sub, low, high] = raw.to_le_bytes();
        Self { key: ObjectKey::new(u16::from_le_bytes([low, high]), sub), bits }
    }

    /// The number in 1Axxh.
    pub fn to_raw(self) -> u32 {
        u32::from(self.key.index) << 16 | u32::from(self.key.sub) << 8 | u32::from(self.bits)
    }

    fn is_padding(&self) -> bool {
        self.key.index <= 0x1F
    }
}

/// Why a mapping or the data of a PDO cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PdoError {
    /// An entry of no bits or of more than a frame holds.
    #[error("object {0} is mapped with {1} bits; allowed are 1..=64")]
    EntryBits(ObjectKey, u8),
    /// All entries together exceed a frame.
    #[error("the mapping needs {0} bits; a frame holds 64")]
    TooLong(u32),
    /// The frame is shorter than the mapping.
    #[error(
        "a PDO of {got} bytes where the mapping needs {needed}; the node was configured again: read it again"
    )]
    ShortFrame {
        /// Bytes the mapping needs.
        needed: usize,
        /// Bytes received.
        got: usize,
    },
}

/// What the bits of a PDO are, in their order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PdoMapping {
    entries: Vec<PdoEntry>,
}

impl PdoMapping {
    /// Checks entries as read from 1Axxh.
    pub fn new(entries: Vec<PdoEntry>) -> Result<Self, PdoError> {
        if let Some(entry) = entries.iter().find(|entry| !(1..=64).contains(&entry.bits)) {
            return Err(PdoError::EntryBits(entry.key, entry.bits));
        }
        let bits: u32 = entries.iter().map(|entry| u32::from(entry.bits)).sum();
        if bits > 64 {
            return Err(PdoError::TooLong(bits));
        }
        Ok(Self { entries })
    }

    /// The entries, padding included.
    pub fn entries(&self) -> &[PdoEntry] {
        &self.entries
    }

    /// Bytes a frame needs to carry the mapping.
    pub fn frame_bytes(&self) -> usize {
        self.entries.iter().map(|entry| usize::from(entry.bits)).sum::<usize>().div_ceil(8)
    }

    /// The objects of a frame, padding left out. A longer frame is allowed, its rest ignored (CiA 301).
    pub fn decode(&self, data: &[u8]) -> Result<Vec<(ObjectKey, RawBits)>, PdoError> {
        let needed = self.frame_bytes();
        if data.len() < needed {
            return Err(PdoError::ShortFrame { needed, got: data.len() });
        }
        let mut bytes = [0; 8];
        bytes[..needed].copy_from_slice(&data[..needed]);
        let frame = u64::from_le_bytes(bytes);
        let mut at = 0;
        let mut objects = Vec::with_capacity(self.entries.len());
        for entry in &self.entries {
            if !entry.is_padding() {
                objects.push((entry.key, RawBits::new(frame >> at, entry.bits)));
            }
            at += u32::from(entry.bits);
        }
        Ok(objects)
    }

    /// The frame of a node; `value` gives each object's bits, padding is 0.
    pub fn encode(&self, mut value: impl FnMut(ObjectKey) -> u64) -> Vec<u8> {
        let mut frame = 0u64;
        let mut at = 0;
        for entry in &self.entries {
            if !entry.is_padding() {
                frame |= (value(entry.key) & mask(entry.bits)) << at;
            }
            at += u32::from(entry.bits);
        }
        frame.to_le_bytes()[..self.frame_bytes()].to_vec()
    }
}

/// When a node sends a TPDO, from sub-index 2 of 18xxh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Transmission {
    /// 0: after a SYNC, when the value has changed.
    SyncOnChange,
    /// 1..=240: after every n-th SYNC.
    EverySync(u8),
    /// 252, 253: when asked by a remote request.
    OnRequest,
    /// 254, 255: by event or event timer.
    Event,
    /// 241..=251: reserved.
    Reserved(u8),
}

impl Transmission {
    /// From the number in 18xxh:02.
    pub fn from_raw(raw: u8) -> Self {
        match raw {
            0 => Self::SyncOnChange,
            1..=240 => Self::EverySync(raw),
            252 | 253 => Self::OnRequest,
            254 | 255 => Self::Event,
            _ => Self::Reserved(raw),
        }
    }

    /// True when the value belongs to the instant of a SYNC.
    pub fn is_synchronous(self) -> bool {
        matches!(self, Self::SyncOnChange | Self::EverySync(_))
    }
}

/// 18xxh: identifier and timing of a TPDO.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PdoCommunication {
    /// Sub-index 1 as read: identifier, bit 29 extended, bit 31 switched off.
    pub cob_id_raw: u32,
    /// When it is sent.
    pub transmission: Transmission,
    /// Event timer, ms; 0 or absent: none.
    pub event_timer_ms: u16,
}

impl PdoCommunication {
    /// False when bit 31 says the PDO is switched off.
    pub fn is_enabled(&self) -> bool {
        self.cob_id_raw & 0x8000_0000 == 0
    }

    /// The identifier its frames have.
    pub fn can_id(&self) -> CanId {
        if self.cob_id_raw & 0x2000_0000 == 0 {
            CanId::Standard((self.cob_id_raw & 0x7FF) as u16)
        } else {
            CanId::Extended(self.cob_id_raw & 0x1FFF_FFFF)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The mapping of the reference probe: 9130h:01 of 32 bits and 6150h:01 of 8.
    #[test]
    fn a_probe_frame_is_a_value_and_a_status() {
        let mapping = PdoMapping::new([0x9130_0120, 0x6150_0108].map(PdoEntry::from_raw).to_vec()).unwrap();
        let objects = mapping.decode(&[0x9C, 0xFF, 0xFF, 0xFF, 0x01]).unwrap();
        assert_eq!(objects[0].0, ObjectKey::new(0x9130, 1));
        assert_eq!(objects[0].1.signed(), -100);
        assert_eq!((objects[1].0, objects[1].1.unsigned()), (ObjectKey::new(0x6150, 1), 1));
        assert_eq!(mapping.decode(&[0; 4]), Err(PdoError::ShortFrame { needed: 5, got: 4 }));
    }

    /// Bits written out by hand: 3 bits 101, padding 5, 12 bits ABCh, 1 bit, 24 bits −2.
    #[test]
    fn fields_that_start_inside_a_byte_are_exact() {
        let entries = [0x2000_0103, 0x0005_0005, 0x2000_020C, 0x2000_0301, 0x8130_0118];
        let mapping = PdoMapping::new(entries.map(PdoEntry::from_raw).to_vec()).unwrap();
        let bits = 0b101 | 0xABC << 8 | 1 << 20 | 0xFF_FFFEu64 << 21;
        let objects = mapping.decode(&bits.to_le_bytes()[..6]).unwrap();
        let keys: Vec<_> = objects.iter().map(|(key, _)| (key.index, key.sub)).collect();
        assert_eq!(keys, [(0x2000, 1), (0x2000, 2), (0x2000, 3), (0x8130, 1)]);
        let signed: Vec<_> = objects.iter().map(|(_, raw)| raw.signed()).collect();
        assert_eq!(signed, [-3, 0xABC - 0x1000, -1, -2]);
    }

    #[test]
    fn impossible_mappings_are_refused() {
        let entry = |bits| PdoEntry { key: ObjectKey::new(0x2000, 1), bits };
        assert_eq!(PdoMapping::new(vec![entry(0)]), Err(PdoError::EntryBits(ObjectKey::new(0x2000, 1), 0)));
        assert_eq!(PdoMapping::new(vec![entry(33), entry(32)]), Err(PdoError::TooLong(65)));
        assert_eq!(PdoMapping::new(vec![entry(32), entry(32)]).map(|m| m.frame_bytes()), Ok(8));
    }

    #[test]
    fn communication_parameters_say_whether_and_when() {
        let communication = |cob_id_raw| PdoCommunication {
            cob_id_raw,
            transmission: Transmission::from_raw(1),
            event_timer_ms: 0,
        };
        assert!(!communication(0x8000_0181).is_enabled());
        assert_eq!(communication(0x4000_0181).can_id(), CanId::Standard(0x181));
        assert_eq!(communication(0x2000_0181).can_id(), CanId::Extended(0x181));
        assert!(
            Transmission::from_raw(240).is_synchronous() && !Transmission::from_raw(254).is_synchronous()
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn any_mapping_gives_back_what_it_was_given(
            fields in prop::collection::vec((1u8..=16, any::<u64>()), 1..=4), longer in 0usize..3,
        ) {
            let key = |sub: usize| ObjectKey::new(0x2100, sub as u8);
            let entries = fields.iter().enumerate().map(|(sub, &(bits, _))| PdoEntry { key: key(sub), bits }).collect();
            let mapping = PdoMapping::new(entries).unwrap();
            let mut data = mapping.encode(|key| fields[usize::from(key.sub)].1);
            data.resize(data.len() + longer, 0xFF);
            let expected: Vec<_> =
                fields.iter().enumerate().map(|(sub, &(bits, value))| (key(sub), RawBits::new(value, bits))).collect();
            prop_assert_eq!(mapping.decode(&data), Ok(expected));
        }
    }
}
