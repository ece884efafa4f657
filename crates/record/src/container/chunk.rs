//! The head of a chunk, and what unpacks of it.

use super::cursor::Cursor;
use std::io::{self, Read};

/// Largest zstd window, as a power of two.
const LARGEST_WINDOW_LOG: u32 = 25;

/// What stands before the records of a chunk.
pub struct ChunkHead<'a> {
    /// Times of its first and last message.
    pub span: [u64; 2],
    pub unpacked_bytes: u64,
    pub crc: u32,
    pub compression: &'a str,
    pub packed_bytes: u64,
}

impl<'a> ChunkHead<'a> {
    pub fn parse(cursor: &mut Cursor<'a>) -> Result<Self, String> {
        Ok(Self {
            span: [cursor.u64()?, cursor.u64()?],
            unpacked_bytes: cursor.u64()?,
            crc: cursor.u32()?,
            compression: cursor.string()?,
            packed_bytes: cursor.u64()?,
        })
    }
}

/// Unpacks as far as it goes, one byte more than `bytes` at most; why it does not go to the end.
pub fn unpack(compression: &str, packed: &[u8], bytes: u64, unpacked: &mut Vec<u8>) -> Result<(), String> {
    let mut of_zstd = || -> io::Result<()> {
        let mut decoder = zstd::stream::read::Decoder::new(packed)?;
        decoder.window_log_max(LARGEST_WINDOW_LOG)?;
        decoder.take(bytes + 1).read_to_end(unpacked).map(|_| ())
    };
    match compression {
        "" => {
            unpacked.extend_from_slice(packed);
            Ok(())
        }
        "zstd" => of_zstd().map_err(|error| format!("a chunk does not unpack: {error}")),
        other => Err(format!("a chunk is packed with {other:?}; zstd is known")),
    }
}
