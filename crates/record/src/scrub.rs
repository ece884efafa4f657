//! Secrets out of recordings that were made before they were left out: everything is copied, the configuration without them.
//!
//! Only a copy that reads back message by message takes the place of the recording.

use crate::container::{MessageRecord, Record, walk};
use crate::damage::Damage;
use crate::error::RecordError;
use crate::finish::PARTIAL_ENDING;
use crate::journal::CONFIG_TEXT;
use crate::journal_file::{is_journal, sync_folder};
use crate::reader::read_header;
use crate::verify::{Written, verify};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, McapResult, WriteOptions, Writer};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use trunnion_core::secret::redacted;

/// What became of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Scrubbed {
    /// True when it held secrets, and was written again without.
    pub changed: bool,
    /// What of it could not be read; it is not in the copy.
    pub damage: Option<Damage>,
}

/// Leaves the secrets out of the configuration of a finished recording; one without secrets is not touched.
///
/// # Errors
/// A file that is no finished recording, or a copy that cannot be written or does not read back; the recording is then as it was.
pub fn scrub(path: &Path) -> Result<Scrubbed, RecordError> {
    if is_journal(path) {
        let reason = "it is still being recorded; the next start of the service finishes it".into();
        return Err(RecordError::NotARecording { path: path.into(), offset: 0, reason });
    }
    let header = read_header(path)?;
    if redacted(&header.config_text) == header.config_text {
        return Ok(Scrubbed { changed: false, damage: None });
    }
    let partial = PathBuf::from(format!("{}{PARTIAL_ENDING}", path.display()));
    let copied = copy(path, &partial, &format!("trunnion {}", header.software_version), redacted);
    let damage = match copied.and_then(|(written, damage)| verify(&partial, &written).map(|()| damage)) {
        Ok(damage) => damage,
        Err(error) => {
            if let Err(left) = std::fs::remove_file(&partial) {
                tracing::warn!("cannot remove {}: {left}", partial.display());
            }
            return Err(error);
        }
    };
    let permissions = std::fs::metadata(path).map_err(RecordError::io("look at", path))?.permissions();
    std::fs::set_permissions(&partial, permissions).map_err(RecordError::io("set the mode of", &partial))?;
    std::fs::rename(&partial, path).map_err(RecordError::io("rename", &partial))?;
    sync_folder(path).map_err(RecordError::io("sync the folder of", path))?;
    Ok(Scrubbed { changed: true, damage })
}

fn copy(
    path: &Path,
    partial: &Path,
    library: &str,
    change: fn(&str) -> String,
) -> Result<(Written, Option<Damage>), RecordError> {
    let source = File::open(path).map_err(RecordError::io("open", path))?;
    let bytes = source.metadata().map_err(RecordError::io("look at", path))?.len();
    let target = File::create(partial).map_err(RecordError::io("create", partial))?;
    let options =
        WriteOptions::new().compression(Some(Compression::Zstd)).compression_threads(0).library(library);
    let writer = options.create(BufWriter::new(target)).map_err(RecordError::write(partial))?;
    let mut copy = Copy {
        change,
        writer,
        schemas: HashMap::new(),
        channels: HashMap::new(),
        messages: 0,
        digest: DefaultHasher::new(),
    };
    let mut failed = None;
    let damage = walk(BufReader::new(source), bytes, &mut |record| {
        failed = copy.record(record).err();
        Ok(failed.is_none())
    })
    .map_err(RecordError::io("read", path))?;
    let finished = failed.map_or(Ok(()), Err).and_then(|()| copy.writer.finish());
    finished.map_err(RecordError::write(partial))?;
    let written = Written { messages: copy.messages, digest: copy.digest.finish() };
    let mut target = copy.writer.into_inner();
    target.flush().map_err(RecordError::io("write", partial))?;
    target.get_ref().sync_all().map_err(RecordError::io("sync", partial))?;
    Ok((written, damage))
}

/// The recording without secrets on its way to the disk.
struct Copy {
    /// What becomes of the configuration.
    change: fn(&str) -> String,
    writer: Writer<BufWriter<File>>,
    /// New number of each schema and channel.
    schemas: HashMap<u16, u16>,
    channels: HashMap<u16, u16>,
    messages: u64,
    digest: DefaultHasher,
}

impl Copy {
    fn record(&mut self, record: &Record<'_>) -> McapResult<()> {
        match record {
            Record::Schema { id, name, encoding, data } => {
                let new = self.writer.add_schema(name, encoding, data)?;
                self.schemas.insert(*id, new);
            }
            Record::Channel { id, schema_id, topic, encoding } => {
                let schema = self.schemas.get(schema_id).copied().unwrap_or(0);
                let new = self.writer.add_channel(schema, topic, encoding, &BTreeMap::new())?;
                self.channels.insert(*id, new);
            }
            Record::Metadata { name, pairs } => {
                let metadata =
                    pairs.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect();
                self.writer.write_metadata(&Metadata { name: (*name).into(), metadata })?;
            }
            Record::Attachment { name, media_type, log_time, data } => {
                let data = match *name {
                    CONFIG_TEXT => Cow::Owned((self.change)(&String::from_utf8_lossy(data)).into_bytes()),
                    _ => Cow::Borrowed(*data),
                };
                let (name, media_type) = ((*name).into(), (*media_type).into());
                self.writer.attach(&Attachment {
                    log_time: *log_time,
                    create_time: *log_time,
                    name,
                    media_type,
                    data,
                })?;
            }
            Record::Message(message) => self.message(message)?,
        }
        Ok(())
    }

    fn message(&mut self, message: &MessageRecord<'_>) -> McapResult<()> {
        let MessageRecord { sequence, log_time, publish_time, data, .. } = *message;
        let Some(&channel_id) = self.channels.get(&message.channel_id) else { return Ok(()) };
        self.writer
            .write_to_known_channel(&MessageHeader { channel_id, sequence, log_time, publish_time }, data)?;
        (log_time, publish_time, data).hash(&mut self.digest);
        self.messages += 1;
        if self.messages == 1 {
            // The header stays in a chunk of its own.
            self.writer.flush()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Item, Recorder, RunHeader, visit};
    use trunnion_core::{Event, HostTime};
    use trunnion_cycles::{Run, RunKind};
    use trunnion_machine::shipped;

    const SECRET: &str = "[mqtt]\nhost = \"broker\"\npassword = \"hunter2\"\n";

    fn old_recording(folder: &Path) -> PathBuf {
        let (machine, kind) = (shipped::machine("table-bc").unwrap(), RunKind::Static);
        let (setups, channels, points) = Default::default();
        let run = Run { name: "run".into(), machine, kind, setups, channels, points };
        let header = RunHeader { config_text: SECRET.into(), ..RunHeader::of_run(&run, "", "0.0.1", 0) };
        let mut recorder = Recorder::create(folder, "run", &header).unwrap();
        for i in 0..1000 {
            let event = Event { time_s: f64::from(i), kind: "pose".into(), text: format!("pose {i}") };
            recorder.append(Item::Event(event), HostTime(0));
        }
        let path = recorder.finish(HostTime(0)).unwrap().files.remove(0).path;
        assert!(!read_header(&path).unwrap().config_text.contains("hunter2"), "this version leaves it out");
        let old = folder.join("old.mcap");
        copy(&path, &old, "trunnion 0.0.1", |_| SECRET.into()).unwrap();
        old
    }

    fn events(path: &Path) -> Vec<String> {
        let mut events = Vec::new();
        visit(path, &mut |item| {
            if let Item::Event(event) = item {
                events.push(event.text.clone());
            }
            true
        })
        .unwrap();
        events
    }

    #[test]
    fn an_old_recording_loses_its_password_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let old = old_recording(folder.path());
        assert!(read_header(&old).unwrap().config_text.contains("hunter2"), "as versions before wrote it");
        let before = events(&old);
        assert_eq!(scrub(&old).unwrap(), Scrubbed { changed: true, damage: None });
        assert!(!String::from_utf8_lossy(&std::fs::read(&old).unwrap()).contains("hunter2"));
        assert!(read_header(&old).unwrap().config_text.contains("host = \"broker\""));
        assert_eq!((events(&old), before.len()), (before, 1000));
        assert_eq!(scrub(&old).unwrap(), Scrubbed { changed: false, damage: None });
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "no copy is left behind");
    }
}
