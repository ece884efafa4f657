//! Whether a file holds what was written to it.

use crate::container::{MessageRecord, Record, walk};
use crate::damage::Damage;
use crate::error::RecordError;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::BufReader;
use std::path::Path;

/// What was written, to be found again.
#[derive(PartialEq)]
pub struct Written {
    pub messages: u64,
    pub digest: u64,
}

/// Reads a file back.
///
/// # Errors
/// When it is damaged, or holds something else.
pub fn verify(path: &Path, written: &Written) -> Result<(), RecordError> {
    let (messages, digest, damage) = digest(path, u64::MAX)?;
    let read = Written { messages, digest };
    let reason = match damage {
        Some(damage) => format!("at byte {}: {}", damage.offset, damage.reason),
        None if read != *written => format!("{messages} messages instead of {}", written.messages),
        None => return Ok(()),
    };
    Err(RecordError::Verify { path: path.into(), reason })
}

/// Messages of a finished file, the digest of the first `of_first`, and its damage.
pub fn digest(path: &Path, of_first: u64) -> Result<(u64, u64, Option<Damage>), RecordError> {
    let file = File::open(path).map_err(RecordError::io("open", path))?;
    let bytes = file.metadata().map_err(RecordError::io("look at", path))?.len();
    let (mut messages, mut digest) = (0, DefaultHasher::new());
    let damage = walk(BufReader::new(file), bytes, &mut |record| {
        if let Record::Message(MessageRecord { log_time, publish_time, data, .. }) = record {
            if messages < of_first {
                (*log_time, *publish_time, *data).hash(&mut digest);
            }
            messages += 1;
        }
        Ok(true)
    })
    .map_err(RecordError::io("read", path))?;
    Ok((messages, digest.finish(), damage))
}
