//! The journal: an unchunked MCAP file, one system call a message.
//!
//! Unchunked because an open chunk is lost with its process; flushed after every message because what the
//! kernel has, a kill cannot take. The file is locked while it is written, so that recovery leaves it alone.

use crate::error::RecordError;
use crate::item::RunHeader;
use crate::journal_file::{JournalFile, Opened, is_not_there};
use crate::schema::FILE_DESCRIPTOR_SET;
use crate::wire::{Encoded, Topic, encode_header};
use mcap::records::MessageHeader;
use mcap::{Attachment, WriteOptions, Writer};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::io::{self, BufWriter, Write as _};
use std::path::PathBuf;
use trunnion_core::secret::redacted;

/// Names of the attachments.
pub const MACHINE_TEXT: &str = "machine.toml";
pub const CYCLE_TEXT: &str = "cycle.toml";
pub const CONFIG_TEXT: &str = "config.toml";
/// Metadata record that says the messages are in order of `log_time`.
pub const FINISHED_METADATA: &str = "trunnion:finished";
/// Name of the metadata record.
pub const RUN_METADATA: &str = "trunnion:run";

/// Larger than any message we write, so that each is one system call.
const BUFFER_BYTES: usize = 64 * 1024;

/// An open journal.
pub struct Journal {
    path: PathBuf,
    writer: Option<Writer<BufWriter<Box<dyn JournalFile>>>>,
    channels: HashMap<Topic, (u16, u32)>,
    sync: Box<dyn Fn() -> io::Result<()> + Send>,
}

impl Journal {
    /// Writes everything that must be known before the first sample.
    pub fn start(path: PathBuf, (file, sync): Opened, header: &RunHeader) -> Result<Self, RecordError> {
        let options = WriteOptions::new()
            .use_chunks(false)
            .compression(None)
            .profile("")
            .library(format!("trunnion {}", header.software_version));
        let writer = options
            .create(BufWriter::with_capacity(BUFFER_BYTES, file))
            .map_err(RecordError::write(&path))?;
        let mut journal = Self { path, writer: Some(writer), channels: HashMap::new(), sync };
        match journal.write_start(header) {
            Ok(()) => Ok(journal),
            Err(source) => {
                let path = journal.path.clone();
                journal.abandon();
                Err(RecordError::Write { path, source })
            }
        }
    }

    fn write_start(&mut self, header: &RunHeader) -> mcap::McapResult<()> {
        let start = wall_time(header, 0.0);
        let pairs = [
            ("name", header.name.clone()),
            ("machine", header.machine_name.clone()),
            ("software_version", header.software_version.clone()),
            ("wall_start_ns", header.wall_start_ns.to_string()),
        ];
        let metadata = pairs.into_iter().map(|(key, value)| (key.to_string(), value)).collect();
        let writer = self.open()?;
        writer.write_metadata(&mcap::records::Metadata { name: RUN_METADATA.into(), metadata })?;
        for (name, text) in [
            (MACHINE_TEXT, header.machine_text.as_str()),
            (CYCLE_TEXT, header.cycle_text.as_str()),
            (CONFIG_TEXT, &redacted(&header.config_text)),
        ] {
            if !text.is_empty() {
                writer.attach(&Attachment {
                    log_time: start,
                    create_time: start,
                    name: name.into(),
                    media_type: "application/toml".into(),
                    data: Cow::Borrowed(text.as_bytes()),
                })?;
            }
        }
        self.write(header, &encode_header(header), start)
    }

    /// Writes one message and hands it to the kernel.
    pub fn write(
        &mut self,
        header: &RunHeader,
        message: &Encoded,
        publish_time: u64,
    ) -> mcap::McapResult<()> {
        let (channel_id, sequence) = self.channel(header, message.topic)?;
        let head =
            MessageHeader { channel_id, sequence, log_time: wall_time(header, message.time_s), publish_time };
        let writer = self.open()?;
        writer.write_to_known_channel(&head, &message.payload)?;
        writer.flush()
    }

    fn channel(&mut self, header: &RunHeader, topic: Topic) -> mcap::McapResult<(u16, u32)> {
        if let Some((id, sequence)) = self.channels.get_mut(&topic) {
            *sequence = sequence.wrapping_add(1);
            return Ok((*id, *sequence));
        }
        let writer = self.open()?;
        let schema = writer.add_schema(topic.schema(), "protobuf", FILE_DESCRIPTOR_SET)?;
        let id = writer.add_channel(schema, &topic.name(header), "protobuf", &BTreeMap::new())?;
        self.channels.insert(topic, (id, 0));
        Ok((id, 0))
    }

    fn open(&mut self) -> mcap::McapResult<&mut Writer<BufWriter<Box<dyn JournalFile>>>> {
        self.writer.as_mut().ok_or(mcap::McapError::AttemptedWriteAfterFailure)
    }

    /// Writes the end record and closes; the file stays a journal until it is rewritten.
    pub fn close(mut self) -> Result<PathBuf, RecordError> {
        let path = self.path.clone();
        let writer = self.open().map_err(RecordError::write(&path))?;
        let ended = writer.finish().map(|_| ());
        let flushed = match self.writer.take() {
            Some(writer) if ended.is_ok() => writer.into_inner().flush(),
            _ => Ok(()),
        };
        self.abandon();
        ended.map_err(RecordError::write(&path))?;
        flushed.map_err(RecordError::io("write", &path))?;
        (self.sync)().map_err(RecordError::io("sync", &path))?;
        Ok(path)
    }

    /// Brings everything written to the disk.
    ///
    /// # Errors
    /// `Gone` when the file is not there any more, else what the disk says.
    pub fn sync(&self) -> Result<(), RecordError> {
        (self.sync)().map_err(|source| match is_not_there(&source) {
            true => RecordError::Gone { path: self.path.clone() },
            false => RecordError::Io { what: "sync", path: self.path.clone(), source },
        })
    }

    /// Closes without writing another byte: after a failed write the file is over.
    pub fn abandon(&mut self) -> PathBuf {
        if let Some(writer) = self.writer.take() {
            drop(writer.into_inner().into_parts());
        }
        self.path.clone()
    }
}

/// Run time on the wall clock, ns since 1970; before 1970 counts as 1970.
pub fn wall_time(header: &RunHeader, time_s: f64) -> u64 {
    let run_ns = (time_s * 1e9).round() as i64;
    u64::try_from(header.wall_start_ns.saturating_add(run_ns)).unwrap_or(0)
}
