//! From journal to finished file: sorted by acquisition time, chunked, compressed, indexed, verified.
//!
//! The journal goes only when the finished file has been read back, renamed and synced, so a crash at any
//! moment leaves one of them whole. Runs found at the next start take the same way.

use crate::contents::{Contents, index};
use crate::damage::Damage;
use crate::error::RecordError;
use crate::item::RunHeader;
use crate::journal::{FINISHED_METADATA, wall_time};
use crate::journal_file::{is_journal, is_not_there, remove_unready, sync_folder};
use crate::schema::FILE_DESCRIPTOR_SET;
use crate::verify::{Written, digest, verify};
use crate::wire::{Encoded, Topic, encode_event, encode_gap};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use trunnion_core::{Event, Gap};

/// Ending while the finished file is being written.
pub const PARTIAL_ENDING: &str = ".partial";

/// A finished recording.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishedFile {
    /// Where it is.
    pub path: PathBuf,
    /// Messages in it.
    pub messages: u64,
    /// Its size.
    pub bytes: u64,
    /// What of the journal could not be read.
    pub damage: Option<Damage>,
}

/// A journal that a run left behind, and what became of it.
#[derive(Debug)]
pub struct Orphan {
    /// Where the finished recording was to be.
    pub recording: PathBuf,
    /// The finished file.
    pub finished: Result<FinishedFile, RecordError>,
}

/// Finishes every journal in `dir` that no running program holds; each gets an event `recovered` saying
/// so. A journal whose recording is there already is removed. One that cannot be finished stays, and does not hinder the others.
///
/// # Errors
/// Only when `dir` cannot be listed; a folder that does not exist holds no journals.
pub fn recover_orphans(dir: &Path) -> Result<Vec<Orphan>, RecordError> {
    if !dir.exists() {
        return Ok(Vec::new());
    }
    let entries = std::fs::read_dir(dir).map_err(RecordError::io("list", dir))?;
    let mut journals = Vec::new();
    for entry in entries {
        let path = entry.map_err(RecordError::io("list", dir))?.path();
        if is_journal(&path) {
            journals.push(path);
        }
    }
    journals.sort();
    let orphan = |journal: &PathBuf| {
        let finished = recover(journal).transpose()?;
        Some(Orphan { recording: journal.with_extension(""), finished })
    };
    Ok(journals.iter().filter_map(orphan).collect())
}

/// `None` when another program is writing it, or its finished file is at its place.
fn recover(journal: &Path) -> Result<Option<FinishedFile>, RecordError> {
    let lock = File::options().write(true).open(journal).map_err(RecordError::io("open", journal))?;
    if lock.try_lock().is_err() {
        return Ok(None);
    }
    if let Some(finished) = finished_before(journal)? {
        // Its run ended, and only the journal could not be removed: what is known of the run stays.
        remove_journal(journal, &finished, &sync_folder)?;
        tracing::info!("{} was finished already; its journal is removed", finished.display());
        return Ok(None);
    }
    let finished = rewrite_journal(journal, Ending::Recovered)?;
    remove_journal(journal, &finished.path, &sync_folder)?;
    Ok(Some(finished))
}

/// What the finished file says at its end.
#[derive(Clone, Copy)]
pub enum Ending<'a> {
    /// The run ended; what could not be written of it.
    Ended(Option<&'a Gap>),
    /// The program ended while it recorded.
    Recovered,
}

/// How the name of a file is brought to the disk.
pub type SyncFolder<'a> = dyn Fn(&Path) -> io::Result<()> + 'a;

/// Removes a journal whose finished file is at its place. May be called again where the disk refuses: a file that was verified stays
/// the recording.
pub fn remove_journal(
    journal: &Path,
    finished: &Path,
    sync_folder: &SyncFolder<'_>,
) -> Result<(), RecordError> {
    sync_folder(finished).map_err(RecordError::io("sync the folder of", finished))?;
    match std::fs::remove_file(journal) {
        Err(why) if !is_not_there(&why) => return Err(RecordError::io("remove", journal)(why)),
        _ => {}
    }
    if let Err(why) = sync_folder(finished) {
        // Nothing is missing then.
        tracing::warn!("a power cut may bring {} back, which is finished: {why}", journal.display());
    }
    Ok(())
}

/// Rewrites a closed or left-over journal, which stays until [`remove_journal`].
pub fn rewrite_journal(journal: &Path, ending: Ending<'_>) -> Result<FinishedFile, RecordError> {
    let indexed = index(journal)?;
    let free = free_path(&journal.with_extension(""), matches!(ending, Ending::Recovered))?;
    rewrite_to(&free, journal, indexed, ending)
}

/// Puts another file in the place of the finished one: what was lost has changed since it was written.
pub fn rewrite_again(
    journal: &Path,
    finished: &Path,
    ending: Ending<'_>,
) -> Result<FinishedFile, RecordError> {
    rewrite_to(finished, journal, index(journal)?, ending)
}

fn rewrite_to(
    place: &Path,
    journal: &Path,
    (header, contents): (RunHeader, Contents),
    ending: Ending<'_>,
) -> Result<FinishedFile, RecordError> {
    let partial = PathBuf::from(format!("{}{PARTIAL_ENDING}", place.display()));
    let rewritten = rewrite(journal, &header, &contents, ending, &partial);
    let written = match rewritten.and_then(|written| verify(&partial, &written).map(|()| written)) {
        Ok(written) => written,
        Err(error) => {
            remove_unready(&partial);
            return Err(error);
        }
    };
    let bytes = std::fs::metadata(&partial).map_err(RecordError::io("look at", &partial))?.len();
    std::fs::rename(&partial, place).map_err(RecordError::io("rename", &partial))?;
    Ok(FinishedFile { path: place.into(), messages: written.messages, bytes, damage: contents.untorn() })
}

/// The finished file of a journal that is there already: each of its messages in the same order, and what an end may say after them.
fn finished_before(journal: &Path) -> Result<Option<PathBuf>, RecordError> {
    let (_, contents) = index(journal)?;
    let finished = journal.with_extension("");
    let places = [recovered_path(&finished), finished].into_iter();
    let there: Vec<PathBuf> = places.filter(|path| path.is_file()).collect();
    if there.is_empty() {
        return Ok(None);
    }
    let known = contents.written(journal).map_err(RecordError::io("read", journal))?;
    for path in there {
        let (messages, digest, damage) = digest(&path, known.messages)?;
        if damage.is_none()
            && digest == known.digest
            && (known.messages..=known.messages + 1).contains(&messages)
        {
            return Ok(Some(path));
        }
    }
    Ok(None)
}

fn rewrite(
    journal: &Path,
    header: &RunHeader,
    contents: &Contents,
    ending: Ending<'_>,
    partial: &Path,
) -> Result<Written, RecordError> {
    let mut source = File::open(journal).map_err(RecordError::io("open", journal))?;
    let target = File::create(partial).map_err(RecordError::io("create", partial))?;
    let options = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        .library(format!("trunnion {}", header.software_version));
    let write_error = RecordError::write(partial);
    let write = || -> mcap::McapResult<(Written, BufWriter<File>)> {
        let mut writer = options.create(BufWriter::new(target))?;
        let order = BTreeMap::from([("order".to_string(), "log_time".to_string())]);
        writer.write_metadata(&Metadata { name: FINISHED_METADATA.into(), metadata: order })?;
        for metadata in &contents.metadata {
            writer.write_metadata(metadata)?;
        }
        for attachment in &contents.attachments {
            writer.attach(attachment)?;
        }
        let channels = declare(&mut writer, contents)?;
        let (mut messages, mut digest) = (0, DefaultHasher::new());
        let mut put = |writer: &mut Writer<_>, head: MessageHeader, payload: &[u8]| {
            (head.log_time, head.publish_time, payload).hash(&mut digest);
            messages += 1;
            writer.write_to_known_channel(&head, payload)
        };
        let mut payload = Vec::new();
        for (i, place) in contents.messages.iter().enumerate() {
            place.read(&mut source, &mut payload)?;
            let Some(&channel_id) = channels.get(&place.channel_id) else { continue };
            let (sequence, log_time, publish_time) = (place.sequence, place.log_time, place.publish_time);
            put(&mut writer, MessageHeader { channel_id, sequence, log_time, publish_time }, &payload)?;
            if i == 0 {
                // The header and the declarations in a small chunk of their own are hard to damage.
                writer.flush()?;
            }
        }
        if let Some((topic, message)) = last_words(header, contents, ending) {
            let schema = writer.add_schema(topic.schema(), "protobuf", FILE_DESCRIPTOR_SET)?;
            let channel_id = writer.add_channel(schema, &topic.name(header), "protobuf", &BTreeMap::new())?;
            let log_time = contents.last_time().max(wall_time(header, message.time_s));
            let head = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
            put(&mut writer, head, &message.payload)?;
        }
        writer.finish()?;
        Ok((Written { messages, digest: digest.finish() }, writer.into_inner()))
    };
    let (written, mut target) = write().map_err(write_error)?;
    target.flush().map_err(RecordError::io("write", partial))?;
    target.get_ref().sync_all().map_err(RecordError::io("sync", partial))?;
    Ok(written)
}

/// What is written after the last message of the journal.
fn last_words(header: &RunHeader, contents: &Contents, ending: Ending<'_>) -> Option<(Topic, Encoded)> {
    match ending {
        Ending::Ended(lost) => Some((Topic::Gap, encode_gap(lost?))),
        Ending::Recovered => {
            let text = "the program ended while recording; finished at the next start";
            let text = match &contents.damage {
                Some(damage) => format!("{text}. At byte {}: {}", damage.offset, damage.reason),
                None => text.into(),
            };
            let time_s = contents.last_time().saturating_sub(wall_time(header, 0.0)) as f64 * 1e-9;
            Some((Topic::Event, encode_event(&Event { time_s, kind: "recovered".into(), text })))
        }
    }
}

/// Declares the schemas and channels of the journal; gives the new id of each channel.
fn declare(writer: &mut Writer<BufWriter<File>>, contents: &Contents) -> mcap::McapResult<HashMap<u16, u16>> {
    let mut channels = HashMap::new();
    for (&id, (schema_id, topic, encoding)) in &contents.channels {
        let schema = match contents.schemas.get(schema_id) {
            Some((name, encoding, data)) => writer.add_schema(name, encoding, data)?,
            None => 0,
        };
        channels.insert(id, writer.add_channel(schema, topic, encoding, &BTreeMap::new())?);
    }
    Ok(channels)
}

fn recovered_path(finished: &Path) -> PathBuf {
    let stem = finished.file_stem().unwrap_or_default().to_string_lossy();
    finished.with_file_name(format!("{stem}-recovered.mcap"))
}

/// `finished` itself, or for a recovered journal `NAME-recovered.mcap` when it is taken.
fn free_path(finished: &Path, may_rename: bool) -> Result<PathBuf, RecordError> {
    if !finished.exists() {
        return Ok(finished.into());
    }
    let renamed = recovered_path(finished);
    if may_rename && !renamed.exists() {
        return Ok(renamed);
    }
    Err(RecordError::Exists { path: finished.into() })
}
