//! Addresses and values of the object dictionary.

use std::fmt;

/// Index and sub-index of an object; shown as in the manuals, `6130h:01`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ObjectKey {
    /// Index.
    pub index: u16,
    /// Sub-index; the channel in profile arrays.
    pub sub: u8,
}

impl ObjectKey {
    /// `index`h:`sub`.
    pub const fn new(index: u16, sub: u8) -> Self {
        Self { index, sub }
    }
}

impl fmt::Display for ObjectKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h:{:02X}", self.index, self.sub)
    }
}

/// Bits of a PDO or bytes of an SDO, 1 to 64 bits, least significant first, without a type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct RawBits {
    value: u64,
    bits: u8,
}

impl RawBits {
    /// The lower `bits` bits of `value`; `bits` beyond 64 are taken as 64.
    pub fn new(value: u64, bits: u8) -> Self {
        let bits = bits.min(64);
        Self { value: value & mask(bits), bits }
    }

    /// Little-endian bytes, at most eight.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut value = [0; 8];
        value.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(Self { value: u64::from_le_bytes(value), bits: 8 * bytes.len() as u8 })
    }

    /// Number of bits, 0..=64.
    pub fn bits(self) -> u8 {
        self.bits
    }

    /// As an unsigned number.
    pub fn unsigned(self) -> u64 {
        self.value
    }

    /// As a two's complement number of its own width.
    pub fn signed(self) -> i64 {
        match self.bits {
            0 => 0,
            bits => (self.value << (64 - bits)) as i64 >> (64 - bits),
        }
    }

    /// As REAL32, if it has 32 bits.
    pub fn real32(self) -> Option<f32> {
        (self.bits == 32).then(|| f32::from_bits(self.value as u32))
    }
}

/// `bits` ones, for 0..=64.
pub(super) fn mask(bits: u8) -> u64 {
    if bits >= 64 { u64::MAX } else { (1 << bits) - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raw_bits_keep_their_width() {
        assert_eq!(RawBits::new(0xFFF, 12).signed(), -1);
        assert_eq!(RawBits::new(0x7FF, 12).signed(), 0x7FF);
        assert_eq!(RawBits::new(u64::MAX, 64).signed(), -1);
        assert_eq!(RawBits::new(0x3F80_0000, 32).real32(), Some(1.0));
        assert_eq!(RawBits::from_bytes(&[0, 0, 0x80]).map(RawBits::signed), Some(-0x80_0000));
        assert_eq!(RawBits::from_bytes(&[0; 9]), None);
        assert_eq!(ObjectKey::new(0x6130, 1).to_string(), "6130h:01");
    }
}
