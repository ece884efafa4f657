//! MCAP record framing, read with limits (<https://mcap.dev/spec>).
//!
//! The reader of the `mcap` crate trusts lengths; this one trusts nothing: every length is held against the
//! file and against [`LARGEST`] before anything is allocated, checksums are compared, and whatever is wrong
//! is noted with its offset. A bad chunk is skipped: its checksum covers all of it, so that no part can be trusted. A bad length ends
//! the walk; of a chunk that is cut by the end of the file, what unpacks is read.

mod chunk;
mod cursor;
mod times;

use crate::damage::Damage;
use chunk::{ChunkHead, unpack};
use crc32fast::Hasher;
use cursor::Cursor;
use mcap::records::op;
use std::io::{self, Read};
use times::Times;

/// Largest record and largest unpacked chunk, bytes.
pub const LARGEST: u64 = 64 << 20;
/// Unpacked bytes of one recording: 36 hours of three probes at 4 kHz with their stamps. A file that repeats itself packs a thousandfold, so
/// that the length of the file bounds neither the time nor the memory that reading takes.
const MOST_UNPACKED: u64 = 16 << 30;
/// Opcode and length.
const FRAME_BYTES: u64 = 9;

/// A record as it lies in the file.
pub enum Record<'a> {
    Schema { id: u16, name: &'a str, encoding: &'a str, data: &'a [u8] },
    Channel { id: u16, schema_id: u16, topic: &'a str, encoding: &'a str },
    Message(MessageRecord<'a>),
    Metadata { name: &'a str, pairs: Vec<(&'a str, &'a str)> },
    Attachment { name: &'a str, media_type: &'a str, log_time: u64, data: &'a [u8] },
}

/// One message.
#[derive(Clone, Copy)]
pub struct MessageRecord<'a> {
    pub channel_id: u16,
    pub sequence: u32,
    pub log_time: u64,
    pub publish_time: u64,
    pub data: &'a [u8],
    /// Where `data` lies: in the file, or in its chunk.
    pub data_offset: u64,
}

/// Visits every readable record in file order and notes the damage. `visit` says why a record is wrong, or
/// `Ok(false)` to stop.
///
/// # Errors
/// Only when the operating system fails; damage is not an error.
pub fn walk(
    file: impl Read,
    file_bytes: u64,
    visit: &mut dyn FnMut(&Record<'_>) -> Result<bool, String>,
) -> io::Result<Option<Damage>> {
    walk_within(MOST_UNPACKED, file, file_bytes, visit)
}

fn walk_within(
    to_unpack: u64,
    file: impl Read,
    file_bytes: u64,
    visit: Visit<'_>,
) -> io::Result<Option<Damage>> {
    let mut walk = Walk {
        file,
        file_bytes,
        at: 0,
        to_unpack,
        crc: Hasher::new(),
        damage: None,
        skipped: 0,
        times: Times::default(),
    };
    walk.run(visit)?;
    let skipped = walk.skipped;
    Ok(walk.damage.map(|damage| match skipped {
        0 | 1 => damage,
        n => Damage { lost: format!("{}; {n} damaged places in all", damage.lost), ..damage },
    }))
}

struct Walk<R> {
    file: R,
    file_bytes: u64,
    at: u64,
    /// Bytes that may still come out of chunks.
    to_unpack: u64,
    crc: Hasher,
    damage: Option<Damage>,
    skipped: u64,
    times: Times,
}

type Visit<'v> = &'v mut dyn FnMut(&Record<'_>) -> Result<bool, String>;

impl<R: Read> Walk<R> {
    fn run(&mut self, visit: Visit<'_>) -> io::Result<()> {
        let mut magic = [0; 8];
        let magic_bytes = self.file_bytes.min(8) as usize;
        self.take(&mut magic[..magic_bytes])?;
        if magic != mcap::MAGIC {
            self.note(0, "the file does not begin like a recording".into(), "everything");
            return Ok(());
        }
        let mut body = Vec::new();
        loop {
            let offset = self.at;
            let left = self.file_bytes - offset;
            if left < FRAME_BYTES {
                let reason = format!("the file ends without its end record, {left} bytes after the last one");
                self.note(offset, reason, "what was to follow");
                return Ok(());
            }
            let crc_before = self.crc.clone();
            let mut frame = [0; FRAME_BYTES as usize];
            self.take(&mut frame)?;
            let opcode = frame[0];
            let bytes = u64::from_le_bytes(frame[1..].try_into().expect("eight bytes"));
            if opcode == 0 || bytes > LARGEST || bytes > left - FRAME_BYTES {
                let reason = format!("a record of kind {opcode} claims {bytes} bytes, {left} are left");
                let mut end = 0;
                if opcode == op::CHUNK {
                    body.resize((left - FRAME_BYTES).min(LARGEST) as usize, 0);
                    self.take(&mut body)?;
                    end = self.cut_chunk(&body, visit);
                }
                self.note(offset, reason, &self.times.lost_after(end));
                return Ok(());
            }
            body.resize(bytes as usize, 0);
            self.take(&mut body)?;
            if opcode == op::DATA_END {
                self.check_end(offset, &body, crc_before);
                return Ok(());
            }
            let data_at = offset + FRAME_BYTES;
            let went_on = match opcode {
                op::CHUNK => self.chunk(offset, &body, visit),
                _ => visit_record(opcode, &body, data_at, &mut self.times, visit),
            };
            match went_on {
                Ok(true) => {}
                Ok(false) => return Ok(()),
                Err(reason) => {
                    let span = ChunkHead::parse(&mut Cursor(&body)).ok().filter(|_| opcode == op::CHUNK);
                    let [from, to] =
                        span.as_ref().map_or([0; 2], |head| head.span).map(|time| self.times.of_run_s(time));
                    let lost = match span {
                        Some(_) => format!("{from:.1} to {to:.1} s of the run"),
                        None => "this record".into(),
                    };
                    self.note(offset, reason, &lost);
                }
            }
        }
    }

    /// Unpacks a chunk and visits its records.
    fn chunk(&mut self, offset: u64, body: &[u8], visit: Visit<'_>) -> Result<bool, String> {
        let mut cursor = Cursor(body);
        let ChunkHead { unpacked_bytes, crc, compression, packed_bytes, .. } = ChunkHead::parse(&mut cursor)?;
        let packed = cursor.bytes(usize::try_from(packed_bytes).unwrap_or(usize::MAX))?;
        if unpacked_bytes > LARGEST {
            return Err(format!("a chunk claims {unpacked_bytes} bytes, {LARGEST} are allowed"));
        }
        let Some(left) = self.to_unpack.checked_sub(unpacked_bytes) else {
            let reason = format!("the recording unpacks to more than {} GiB", MOST_UNPACKED >> 30);
            self.note(offset, reason, "everything from there on");
            return Ok(false);
        };
        self.to_unpack = left;
        let mut unpacked = Vec::new();
        unpack(compression, packed, unpacked_bytes, &mut unpacked)?;
        if unpacked.len() as u64 != unpacked_bytes || (crc != 0 && crc32fast::hash(&unpacked) != crc) {
            return Err("the checksum of a chunk differs".into());
        }
        let mut rest = Cursor(&unpacked);
        while !rest.0.is_empty() {
            let opcode = rest.bytes(1)?[0];
            let bytes = rest.u64()?;
            let at = (unpacked.len() - rest.0.len()) as u64;
            let record = rest.bytes(usize::try_from(bytes).unwrap_or(usize::MAX))?;
            match visit_record(opcode, record, at, &mut self.times, visit) {
                Ok(true) => {}
                Ok(false) => return Ok(false),
                Err(reason) => self.note(offset, reason, "a record of this chunk"),
            }
        }
        Ok(true)
    }

    /// Visits what is whole of a chunk that is cut, and gives the time of its last message, 0 where that is not known. What is there is
    /// what was written, so that it is right although no checksum can be compared. zstd unpacks blocks of 128 KiB [RFC 8878, 3.1.1.2].
    fn cut_chunk(&mut self, body: &[u8], visit: Visit<'_>) -> u64 {
        let mut cursor = Cursor(body);
        let Ok(head) = ChunkHead::parse(&mut cursor) else { return 0 };
        let mut unpacked = Vec::new();
        // It ends in the middle, which is known already.
        unpack(head.compression, cursor.0, head.unpacked_bytes.min(LARGEST), &mut unpacked).ok();
        let mut rest = Cursor(&unpacked);
        while let (Ok(opcode), Ok(bytes)) = (rest.bytes(1), rest.u64()) {
            let at = (unpacked.len() - rest.0.len()) as u64;
            let Ok(record) = rest.bytes(usize::try_from(bytes).unwrap_or(usize::MAX)) else { break };
            if visit_record(opcode[0], record, at, &mut self.times, visit) != Ok(true) {
                break;
            }
        }
        head.span[1]
    }

    /// Compares the checksum of all that came before, and looks for the end of the file.
    fn check_end(&mut self, offset: u64, body: &[u8], crc: Hasher) {
        match Cursor(body).u32() {
            Ok(expected) if expected != 0 && expected != crc.finalize() => {
                self.note(offset, "the checksum of the data differs".into(), "unknown: values may be wrong");
            }
            Ok(_) => {}
            Err(reason) => self.note(offset, reason, "the checksum"),
        }
        let mut tail = Vec::new();
        let left = (self.file_bytes - self.at).min(LARGEST);
        if self.file.by_ref().take(left).read_to_end(&mut tail).is_err() || !summary_is_whole(&tail) {
            self.note(self.at, "the index at the end is damaged".into(), "nothing but the index");
        }
    }

    fn take(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.file.read_exact(bytes)?;
        self.crc.update(bytes);
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn note(&mut self, offset: u64, reason: String, lost: &str) {
        self.skipped += 1;
        self.damage.get_or_insert_with(|| Damage { offset, reason, lost: lost.into() });
    }
}

/// Everything between the end of the data and the checksum in the footer, against that checksum.
fn summary_is_whole(tail: &[u8]) -> bool {
    let Some(records) = tail.strip_suffix(mcap::MAGIC) else { return false };
    let Some((covered, crc)) = records.split_last_chunk::<4>() else { return false };
    let crc = u32::from_le_bytes(*crc);
    crc == 0 || crc == crc32fast::hash(covered)
}

fn visit_record(
    opcode: u8,
    body: &[u8],
    at: u64,
    times: &mut Times,
    visit: Visit<'_>,
) -> Result<bool, String> {
    let mut cursor = Cursor(body);
    let record = match opcode {
        op::SCHEMA => {
            let (id, name, encoding) = (cursor.u16()?, cursor.string()?, cursor.string()?);
            let bytes = cursor.u32()? as usize;
            Record::Schema { id, name, encoding, data: cursor.bytes(bytes)? }
        }
        op::CHANNEL => {
            let (id, schema_id) = (cursor.u16()?, cursor.u16()?);
            Record::Channel { id, schema_id, topic: cursor.string()?, encoding: cursor.string()? }
        }
        op::MESSAGE => Record::Message(MessageRecord {
            channel_id: cursor.u16()?,
            sequence: cursor.u32()?,
            log_time: cursor.u64()?,
            publish_time: cursor.u64()?,
            data: cursor.0,
            data_offset: at + (body.len() - cursor.0.len()) as u64,
        }),
        op::METADATA => {
            let name = cursor.string()?;
            let bytes = cursor.u32()? as usize;
            let mut map = Cursor(cursor.bytes(bytes)?);
            let mut pairs = Vec::new();
            while !map.0.is_empty() {
                pairs.push((map.string()?, map.string()?));
            }
            Record::Metadata { name, pairs }
        }
        op::ATTACHMENT => {
            let log_time = cursor.u64()?;
            cursor.u64()?;
            let (name, media_type) = (cursor.string()?, cursor.string()?);
            let bytes = cursor.u64()?;
            let data = cursor.bytes(usize::try_from(bytes).unwrap_or(usize::MAX))?;
            let covered = body.len() - cursor.0.len();
            let crc = cursor.u32()?;
            if crc != 0 && crc != crc32fast::hash(&body[..covered]) {
                return Err(format!("the checksum of the attachment {name} differs"));
            }
            Record::Attachment { name, media_type, log_time, data }
        }
        _ => return Ok(true),
    };
    if let Record::Message(message) = &record {
        times.take(message.log_time);
    }
    visit(&record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Written by the `mcap` crate: a message of a kilobyte of zeros in each chunk.
    #[test]
    fn a_file_that_unpacks_without_end_is_read_as_far_as_it_may() {
        let mut file = io::Cursor::new(Vec::new());
        let mut writer = mcap::WriteOptions::new().chunk_size(Some(1000)).create(&mut file).unwrap();
        let channel = writer.add_channel(0, "t", "raw", &BTreeMap::new()).unwrap();
        for sequence in 0..10 {
            let header =
                mcap::records::MessageHeader { channel_id: channel, sequence, log_time: 0, publish_time: 0 };
            writer.write_to_known_channel(&header, &[0; 1000]).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        let bytes = file.into_inner();

        let read = |to_unpack| {
            let mut messages = 0;
            let damage = walk_within(to_unpack, &bytes[..], bytes.len() as u64, &mut |record| {
                messages += usize::from(matches!(record, Record::Message(_)));
                Ok(true)
            });
            (messages, damage.unwrap())
        };
        assert_eq!(read(MOST_UNPACKED), (10, None));
        let (messages, damage) = read(5 * 1100);
        assert!((3..=5).contains(&messages), "{messages}");
        let damage = damage.unwrap();
        assert!(damage.reason.contains("unpacks to more than"), "{damage:?}");
        assert_eq!(damage.lost, "everything from there on");
    }
}
