//! What a journal holds that is over.

use crate::container::{Record, walk};
use crate::damage::Damage;
use crate::error::RecordError;
use crate::item::RunHeader;
use crate::journal_file::is_not_there;
use crate::reader::decode_header;
use crate::verify::Written;
use mcap::Attachment;
use mcap::records::Metadata;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// A journal cut short by a crash ends with at most one unfinished message.
const LONGEST_TAIL: u64 = 64 * 1024;

/// What a journal holds; the messages stay in the file.
#[derive(Default)]
pub struct Contents {
    pub schemas: HashMap<u16, (String, String, Vec<u8>)>,
    pub channels: BTreeMap<u16, (u16, String, String)>,
    pub metadata: Vec<Metadata>,
    pub attachments: Vec<Attachment<'static>>,
    pub messages: Vec<Place>,
    /// First byte after the last readable message.
    pub end: u64,
    /// Size of the journal.
    pub bytes: u64,
    pub damage: Option<Damage>,
}

impl Contents {
    /// Time of the last message, ns since 1970.
    pub fn last_time(&self) -> u64 {
        self.messages.last().map_or(0, |place| place.log_time)
    }

    /// A message cut short at the end was never accepted; that a left-over journal has no end is no damage.
    pub fn untorn(self) -> Option<Damage> {
        let (end, bytes) = (self.end, self.bytes);
        self.damage.filter(|damage| damage.offset < end || bytes - damage.offset >= LONGEST_TAIL)
    }

    /// What a finished file of it holds before its last words.
    pub fn written(&self, journal: &Path) -> io::Result<Written> {
        let (mut source, mut digest) = (File::open(journal)?, DefaultHasher::new());
        let mut payload = Vec::new();
        for place in &self.messages {
            place.read(&mut source, &mut payload)?;
            (place.log_time, place.publish_time, payload.as_slice()).hash(&mut digest);
        }
        Ok(Written { messages: self.messages.len() as u64, digest: digest.finish() })
    }
}

/// One message of the journal.
pub struct Place {
    pub channel_id: u16,
    pub sequence: u32,
    pub log_time: u64,
    pub publish_time: u64,
    pub offset: u64,
    pub bytes: u32,
}

impl Place {
    pub fn read(&self, journal: &mut File, payload: &mut Vec<u8>) -> io::Result<()> {
        payload.resize(self.bytes as usize, 0);
        journal.seek(SeekFrom::Start(self.offset))?;
        journal.read_exact(payload)
    }
}

/// Reads it through.
pub fn index(journal: &Path) -> Result<(RunHeader, Contents), RecordError> {
    let file = File::open(journal).map_err(|source| match is_not_there(&source) {
        // Nobody brings it back.
        true => RecordError::Gone { path: journal.into() },
        false => RecordError::io("open", journal)(source),
    })?;
    let bytes = file.metadata().map_err(RecordError::io("look at", journal))?.len();
    let mut header = None;
    let mut contents = Contents { bytes, ..Contents::default() };
    let damage = walk(BufReader::new(file), bytes, &mut |record| {
        match record {
            Record::Schema { id, name, encoding, data } => {
                contents.schemas.insert(*id, ((*name).into(), (*encoding).into(), data.to_vec()));
            }
            Record::Channel { id, schema_id, topic, encoding } => {
                contents.channels.insert(*id, (*schema_id, (*topic).into(), (*encoding).into()));
            }
            Record::Metadata { name, pairs } => {
                let metadata =
                    pairs.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect();
                contents.metadata.push(Metadata { name: (*name).into(), metadata });
            }
            Record::Attachment { name, media_type, log_time, data } => {
                contents.attachments.push(Attachment {
                    log_time: *log_time,
                    create_time: *log_time,
                    name: (*name).into(),
                    media_type: (*media_type).into(),
                    data: Cow::Owned(data.to_vec()),
                })
            }
            Record::Message(message) => {
                contents.end = message.data_offset + message.data.len() as u64;
                let Some((schema_id, _, _)) = contents.channels.get(&message.channel_id) else {
                    return Err(format!(
                        "a message names channel {}, which is not declared",
                        message.channel_id
                    ));
                };
                if header.is_none() {
                    let schema = contents.schemas.get(schema_id).map(|(name, _, _)| name.as_str());
                    header = decode_header(schema.unwrap_or_default(), message.data);
                }
                contents.messages.push(Place {
                    channel_id: message.channel_id,
                    sequence: message.sequence,
                    log_time: message.log_time,
                    publish_time: message.publish_time,
                    offset: message.data_offset,
                    bytes: u32::try_from(message.data.len()).map_err(|_| "a message is too long")?,
                });
            }
        }
        Ok(true)
    });
    contents.damage = damage.map_err(RecordError::io("read", journal))?;
    let header = header.ok_or_else(|| {
        let damage = contents.damage.clone();
        RecordError::NotARecording {
            path: journal.into(),
            offset: damage.as_ref().map_or(0, |damage| damage.offset),
            reason: damage.map_or("it has no header".into(), |damage| damage.reason),
        }
    })?;
    // Stable: what has the same time keeps the order in which it was written. The header stays first.
    contents.messages[1..].sort_by_key(|place| place.log_time);
    Ok((header, contents))
}
