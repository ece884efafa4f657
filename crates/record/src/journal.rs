//! The journal: an unchunked MCAP file, one system call a message.
//!
//! Unchunked because an open chunk is lost with its process; flushed after every message because what the
//! kernel has, a kill cannot take. The file is locked while it is written, so that recovery leaves it alone.

use crate::error::RecordError;
use crate::item::RunHeader;
use crate::schema::FILE_DESCRIPTOR_SET;
use crate::wire::{Encoded, Topic, encode_header};
use mcap::records::MessageHeader;
use mcap::{Attachment, WriteOptions, Writer};
use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use trunnion_core::secret::redacted;

/// Names of the attachments.
pub const MACHINE_TEXT: &str = "machine.toml";
pub const CYCLE_TEXT: &str = "cycle.toml";
/// Metadata record that says the messages are in order of `log_time`.
pub const FINISHED_METADATA: &str = "trunnion:finished";
pub const CONFIG_TEXT: &str = "config.toml";
/// Name of the metadata record.
pub const RUN_METADATA: &str = "trunnion:run";

/// Larger than any message we write, so that each is one system call.
const BUFFER_BYTES: usize = 64 * 1024;

/// What a journal is written to.
pub trait JournalFile: Write + Seek + Send {}
impl<F: Write + Seek + Send> JournalFile for F {}

/// A file to write to and a second way to it, which brings what was written to the disk.
pub type Opened = (Box<dyn JournalFile>, Box<dyn Fn() -> io::Result<()> + Send>);

/// How journals are opened; tests put a full disk here.
pub type OpenJournal = Box<dyn FnMut(&Path) -> io::Result<Opened> + Send>;

/// Creates a new file that is there after a power cut, and locks it. Bringing it to the disk also looks whether it is still there: `NotFound` when it is not.
pub fn open_locked(path: &Path) -> io::Result<Opened> {
    let file = create_ready(path, |file| file.try_lock().map_err(io::Error::from).and(sync_folder(path)))?;
    let (same, path) = (file.try_clone()?, path.to_owned());
    let (is_unknown, cannot_sync) = (Cell::new(false), Cell::new(false));
    Ok((
        Box::new(file),
        Box::new(move || {
            match same.sync_data() {
                Err(why) if never_syncs(&why) => {
                    if !cannot_sync.replace(true) {
                        let path = path.display();
                        tracing::warn!(
                            "{path} cannot be synced, a power cut may cost more than 0.1 s: {why}"
                        );
                    }
                }
                synced => synced?,
            }
            let found = in_place(&same, &path);
            let unknown = found.as_ref().err().filter(|why| why.kind() != io::ErrorKind::NotFound);
            let Some(why) = unknown else {
                is_unknown.set(false);
                return found;
            };
            // What was written is on the disk all the same.
            if !is_unknown.replace(true) {
                tracing::warn!("cannot look whether {} is still there: {why}", path.display());
            }
            Ok(())
        }),
    ))
}

/// True of a file system that has no sync (fsync(2)): another file would be refused as well, so recording goes on in this one.
fn never_syncs(why: &io::Error) -> bool {
    matches!(why.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported)
}

/// Creates a new file; one that cannot be made ready goes again, or its name would be taken at every further attempt.
fn create_ready(path: &Path, make_ready: impl FnOnce(&File) -> io::Result<()>) -> io::Result<File> {
    let file = File::options().write(true).create_new(true).open(path)?;
    if let Err(why) = make_ready(&file) {
        if let Err(left) = std::fs::remove_file(path) {
            tracing::warn!("cannot remove {}: {left}", path.display());
        }
        return Err(why);
    }
    Ok(file)
}

/// Brings the name of a file to the disk.
pub fn sync_folder(file: &Path) -> io::Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match File::open(folder)?.sync_all() {
        // Several file systems on the network have none for folders.
        Err(why) if never_syncs(&why) => Ok(()),
        synced => synced,
    }
}

/// A file that was removed, or whose folder was, takes what is written to it without a word. Only a file without a name that is
/// not the one at its place counts: file systems on the network count names and number files as they like.
fn in_place(file: &File, path: &Path) -> io::Result<()> {
    let (ours, there) = (file.metadata()?, std::fs::metadata(path)?);
    let is_another = ours.nlink() == 0 && ours.ino() != there.ino();
    if is_another { Err(io::ErrorKind::NotFound.into()) } else { Ok(()) }
}

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
        (self.sync)().map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => RecordError::Gone { path: self.path.clone() },
            _ => RecordError::Io { what: "sync", path: self.path.clone(), source },
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_made_ready_leaves_its_name_free() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.mcap.active");
        let refused = create_ready(&path, |_| Err(io::ErrorKind::StorageFull.into())).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::StorageFull);
        assert!(!path.exists());
        assert!(open_locked(&path).is_ok());
    }

    #[test]
    fn what_has_no_sync_is_told_from_a_disk_that_refuses() {
        let (socket, _other) = std::os::unix::net::UnixStream::pair().unwrap();
        let without = File::from(std::os::fd::OwnedFd::from(socket));
        assert!(never_syncs(&without.sync_data().unwrap_err()));
        assert!(!never_syncs(&io::ErrorKind::StorageFull.into()));
        assert!(!never_syncs(&io::Error::from_raw_os_error(5)), "an error of the disk");
    }

    #[test]
    fn a_journal_that_cannot_be_looked_for_is_on_the_disk_and_one_that_is_not_there_is_gone() {
        let place = tempfile::tempdir().unwrap();
        let (folder, other) = (place.path().join("runs"), place.path().join("elsewhere"));
        std::fs::create_dir(&folder).unwrap();
        let (_file, sync) = open_locked(&folder.join("r.mcap.active")).unwrap();
        sync().unwrap();
        std::fs::rename(&folder, &other).unwrap();
        assert_eq!(sync().unwrap_err().kind(), io::ErrorKind::NotFound);
        std::os::unix::fs::symlink(&folder, &folder).unwrap();
        sync().unwrap();
    }
}
