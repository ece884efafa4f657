//! A recording for 3D viewers: an MCAP file with the message schemas that Foxglove and others draw by themselves.
//!
//! The schemas are Foxglove's own (`schema/foxglove`, MIT); lengths are in m there, angles in rad. What is drawn is handed in; nothing is
//! computed here.

#[expect(missing_docs, reason = "the schemas in `schema/foxglove` document the messages")]
pub mod messages {
    //! The messages, generated from `schema/foxglove`; `tests/all/schema.rs` writes and compares them.
    include!("../schema/foxglove.rs");
}

use crate::error::RecordError;
use crate::item::RunHeader;
use crate::journal::wall_time;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use prost::Message;
pub use prost_types::Timestamp;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Follows the version of the program in the header of such a file, and of no recording.
const LIBRARY_END: &str = " for viewers";

/// Whether a file that begins so was written here.
pub fn begins(beginning: &[u8]) -> bool {
    beginning.windows(LIBRARY_END.len()).any(|window| window == LIBRARY_END.as_bytes())
}

const DESCRIPTORS: &[u8] = include_bytes!("../schema/foxglove.fds");

/// A topic, and the message that it carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Channel {
    /// Name of the topic.
    pub topic: &'static str,
    /// Name of its message.
    pub schema: &'static str,
}

/// Writes such a file. Messages come in any order; viewers sort by the index.
pub struct FoxgloveWriter {
    path: PathBuf,
    header: RunHeader,
    writer: Writer<BufWriter<File>>,
    channels: HashMap<Channel, (u16, u32)>,
}

impl FoxgloveWriter {
    /// Begins the file of the run with this header; one that exists is replaced.
    ///
    /// # Errors
    /// A file that cannot be created.
    pub fn create(path: &Path, header: &RunHeader, software_version: &str) -> Result<Self, RecordError> {
        let file = File::create(path).map_err(RecordError::io("create", path))?;
        let options = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            .compression_threads(0)
            .library(format!("trunnion {software_version}{LIBRARY_END}"));
        let writer = options.create(BufWriter::new(file)).map_err(RecordError::write(path))?;
        Ok(Self { path: path.into(), header: header.clone(), writer, channels: HashMap::new() })
    }

    /// A moment of the run as messages hold it.
    pub fn moment(&self, time_s: f64) -> Timestamp {
        let at_ns = wall_time(&self.header, time_s);
        let (seconds, nanos) = (at_ns / 1_000_000_000, at_ns % 1_000_000_000);
        // Both fit: 2^64 ns are 584 years.
        Timestamp { seconds: seconds as i64, nanos: nanos as i32 }
    }

    /// Writes a message of this moment of the run.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(
        &mut self,
        channel: Channel,
        time_s: f64,
        message: &impl Message,
    ) -> Result<(), RecordError> {
        let at_ns = wall_time(&self.header, time_s);
        self.put(channel, at_ns, &message.encode_to_vec()).map_err(RecordError::write(&self.path))
    }

    fn put(&mut self, channel: Channel, at_ns: u64, payload: &[u8]) -> mcap::McapResult<()> {
        if !self.channels.contains_key(&channel) {
            let schema = self.writer.add_schema(channel.schema, "protobuf", DESCRIPTORS)?;
            let id = self.writer.add_channel(schema, channel.topic, "protobuf", &BTreeMap::new())?;
            self.channels.insert(channel, (id, 0));
        }
        let Some((channel_id, sequence)) = self.channels.get_mut(&channel) else { return Ok(()) };
        let head = MessageHeader {
            channel_id: *channel_id,
            sequence: *sequence,
            log_time: at_ns,
            publish_time: at_ns,
        };
        *sequence = sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&head, payload)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> Result<(), RecordError> {
        self.writer.finish().map_err(RecordError::write(&self.path))?;
        let mut file = self.writer.into_inner();
        file.flush().map_err(RecordError::io("write", &self.path))?;
        file.get_ref().sync_all().map_err(RecordError::io("sync", &self.path))
    }
}

/// A length in m, mm given.
pub fn metres(mm: f64) -> f64 {
    mm * 1e-3
}

/// A place in m, mm given.
pub fn vector(mm: &Vector3<f64>) -> messages::Vector3 {
    messages::Vector3 { x: metres(mm.x), y: metres(mm.y), z: metres(mm.z) }
}

/// A rotation.
pub fn quaternion(rotation: &UnitQuaternion<f64>) -> messages::Quaternion {
    messages::Quaternion { x: rotation.i, y: rotation.j, z: rotation.k, w: rotation.w }
}

/// A pose, mm given.
pub fn pose(at_mm: &Point3<f64>, rotation: &UnitQuaternion<f64>) -> messages::Pose {
    messages::Pose { position: Some(vector(&at_mm.coords)), orientation: Some(quaternion(rotation)) }
}

/// One frame against the one that carries it.
pub fn transform(
    moment: Timestamp,
    (carrier, carried): (&str, &str),
    carrier_from_carried: &Isometry3<f64>,
) -> messages::FrameTransform {
    messages::FrameTransform {
        timestamp: Some(moment),
        parent_frame_id: carrier.into(),
        child_frame_id: carried.into(),
        translation: Some(vector(&carrier_from_carried.translation.vector)),
        rotation: Some(quaternion(&carrier_from_carried.rotation)),
    }
}
