//! Reading a recording: finished, still a journal, or damaged.

use crate::container::{Record, walk};
use crate::damage::Damage;
use crate::error::RecordError;
use crate::item::{Item, RunHeader, Temperature};
use crate::journal::{CONFIG_TEXT, CYCLE_TEXT, FINISHED_METADATA, MACHINE_TEXT};
use crate::near::with_nearest;
use crate::wire::{Decoded, POINT_SCHEMA, SAMPLE_SCHEMAS, decode};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use trunnion_core::{AxisSample, Event, Gap, Point, ProbeSample};
use trunnion_cycles::Run;
use trunnion_machine::Machine;

/// Everything a recording holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// What was known before the first sample.
    pub header: RunHeader,
    /// The run: machine, setups, points.
    pub run: Run,
    /// Probe samples; those of one channel in order of time.
    pub probe_samples: Vec<ProbeSample>,
    /// Axis positions in order of time.
    pub axis_samples: Vec<AxisSample>,
    /// Temperatures in order of time.
    pub temperatures: Vec<Temperature>,
    /// Events in order of time.
    pub events: Vec<Event>,
    /// Gaps in order of their beginnings.
    pub gaps: Vec<Gap>,
    /// What could not be read; `None` when the file is whole.
    pub damage: Option<Damage>,
}

/// Reads a whole recording into memory. The machine is the one in the recording; `machine_by_name` is asked when
/// there is none.
///
/// # Errors
/// When the file cannot be opened, has no header, or its machine is unknown. Damage is not an error.
pub fn read_run(
    path: &Path,
    machine_by_name: &dyn Fn(&str) -> Option<Machine>,
) -> Result<Recording, RecordError> {
    read_run_from(path, open(path)?, machine_by_name)
}

/// As [`read_run`], from the bytes of a file that would stand at `path`.
///
/// # Errors
/// As [`read_run`].
pub fn read_run_of_bytes(
    path: &Path,
    bytes: &[u8],
    machine_by_name: &dyn Fn(&str) -> Option<Machine>,
) -> Result<Recording, RecordError> {
    read_run_from(path, (bytes, bytes.len() as u64), machine_by_name)
}

fn read_run_from(
    path: &Path,
    source: Source<impl Read>,
    machine_by_name: &dyn Fn(&str) -> Option<Machine>,
) -> Result<Recording, RecordError> {
    let (mut probe_samples, mut axis_samples, mut temperatures) = (Vec::new(), Vec::new(), Vec::new());
    let (mut events, mut gaps) = (Vec::new(), Vec::new());
    let mut points: Vec<(u64, Point)> = Vec::new();
    let (header, damage) = visit_source(path, source, &|_| true, &mut |index, item| {
        match item {
            Item::Probe(sample) => probe_samples.push(sample),
            Item::Axes(sample) => axis_samples.push(sample),
            Item::Point(point) => points.push((index, point)),
            Item::Temperature(reading) => temperatures.push(reading),
            Item::Event(event) => events.push(event),
            Item::Gap(gap) => gaps.push(gap),
        }
        true
    })?;
    points.sort_by_key(|(index, _)| *index);
    let start = RunStart { machine: machine_of(path, &header, machine_by_name)?, header };
    let run = start.run(points.into_iter().map(|(_, point)| point).collect());
    Ok(Recording {
        header: start.header,
        run,
        probe_samples,
        axis_samples,
        temperatures,
        events,
        gaps,
        damage,
    })
}

/// What is known of a recording before its first point.
#[derive(Clone, Debug, PartialEq)]
pub struct RunStart {
    /// What was known before the first sample.
    pub header: RunHeader,
    /// The machine it was measured on.
    pub machine: Machine,
}

impl RunStart {
    /// From a header and its machine, which `machine_by_name` is asked for when the recording holds none.
    ///
    /// # Errors
    /// When the machine is unknown.
    pub fn new(
        path: &Path,
        header: RunHeader,
        machine_by_name: &dyn Fn(&str) -> Option<Machine>,
    ) -> Result<Self, RecordError> {
        Ok(Self { machine: machine_of(path, &header, machine_by_name)?, header })
    }

    /// The run with these points.
    pub fn run(&self, points: Vec<Point>) -> Run {
        Run {
            name: self.header.name.clone(),
            machine: self.machine.clone(),
            kind: self.header.kind,
            setups: self.header.setups.clone(),
            channels: self.header.temperature_channels.clone(),
            points,
        }
    }
}

/// Receives what is known of the recording, the place of a point in the order of the run, and the point.
pub type OnPoint<'v> = &'v mut dyn FnMut(&RunStart, u64, Point);

/// Hands every point to `on_point` in the order of the file: by time when finished, as taken in a journal. Everything else is passed
/// over; one chunk is in memory. A point before the header or of a machine nobody knows is never handed out.
///
/// # Errors
/// When the file cannot be opened, has no header, or its machine is unknown. Damage is not an error.
pub fn visit_points(
    path: &Path,
    machine_by_name: &dyn Fn(&str) -> Option<Machine>,
    on_point: OnPoint<'_>,
) -> Result<(RunStart, Option<Damage>), RecordError> {
    let mut start: Option<RunStart> = None;
    let mut refused = None;
    let (header, damage) = walk_items(
        path,
        open(path)?,
        &|schema| schema == POINT_SCHEMA,
        &mut |texts, header, _, _, decoded| {
            if start.is_none() {
                let header = header_with(header.clone(), texts);
                match machine_of(path, &header, machine_by_name) {
                    Ok(machine) => start = Some(RunStart { header, machine }),
                    Err(error) => {
                        refused = Some(error);
                        return false;
                    }
                }
            }
            if let (Some(start), Decoded::Item { index, item: Item::Point(point) }) = (&start, decoded) {
                on_point(start, index, point);
            }
            true
        },
    )?;
    match (refused, start) {
        (Some(error), _) => Err(error),
        (None, Some(start)) => Ok((start, damage)),
        (None, None) => {
            Ok((RunStart { machine: machine_of(path, &header, machine_by_name)?, header }, damage))
        }
    }
}

fn machine_of(
    path: &Path,
    header: &RunHeader,
    machine_by_name: &dyn Fn(&str) -> Option<Machine>,
) -> Result<Machine, RecordError> {
    match header.machine() {
        Some(machine) => machine.map_err(RecordError::Machine),
        None => machine_by_name(&header.machine_name).ok_or_else(|| RecordError::UnknownMachine {
            path: path.into(),
            name: header.machine_name.clone(),
        }),
    }
}

/// Hands every item to `on_item` in order of acquisition time (samples written together count with their first) until that says
/// false. A finished recording streams, one chunk in memory; a journal is sorted in memory first.
///
/// # Errors
/// When the file cannot be opened or has no header. Damage is not an error.
pub fn visit(
    path: &Path,
    on_item: &mut dyn FnMut(Item) -> bool,
) -> Result<(RunHeader, Option<Damage>), RecordError> {
    visit_indexed(path, &|_| true, &mut |_, item| on_item(item))
}

/// What was known before the first sample.
///
/// # Errors
/// When the file cannot be opened or has no header.
pub fn read_header(path: &Path) -> Result<RunHeader, RecordError> {
    // Texts and header come before everything else.
    Ok(visit(path, &mut |_| false)?.0)
}

/// As [`visit`], but hands over only what devices delivered: samples, temperatures and gaps. Points are passed over unread.
///
/// # Errors
/// As [`visit`].
pub fn visit_samples(
    path: &Path,
    on_item: &mut dyn FnMut(Item) -> bool,
) -> Result<(RunHeader, Option<Damage>), RecordError> {
    visit_indexed(path, &|schema| SAMPLE_SCHEMAS.contains(&schema), &mut |_, item| on_item(item))
}

fn visit_indexed(
    path: &Path,
    wanted: &dyn Fn(&str) -> bool,
    on_item: &mut dyn FnMut(u64, Item) -> bool,
) -> Result<(RunHeader, Option<Damage>), RecordError> {
    visit_source(path, open(path)?, wanted, on_item)
}

/// A recording, and how many bytes it has.
type Source<R> = (R, u64);

fn open(path: &Path) -> Result<Source<BufReader<File>>, RecordError> {
    let file =
        File::open(path).map_err(|source| RecordError::io("open", path)(with_nearest(path, source)))?;
    let bytes = file.metadata().map_err(RecordError::io("look at", path))?.len();
    Ok((BufReader::with_capacity(1 << 16, file), bytes))
}

fn visit_source(
    path: &Path,
    source: Source<impl Read>,
    wanted: &dyn Fn(&str) -> bool,
    on_item: &mut dyn FnMut(u64, Item) -> bool,
) -> Result<(RunHeader, Option<Damage>), RecordError> {
    let mut waiting: Vec<(u64, Decoded)> = Vec::new();
    let (header, damage) = walk_items(path, source, wanted, &mut |_, _, sorted, log_time, decoded| {
        if sorted {
            return decoded.hand_over(on_item);
        }
        waiting.push((log_time, decoded));
        true
    })?;
    waiting.sort_by_key(|(log_time, _)| *log_time);
    for (_, decoded) in waiting {
        if !decoded.hand_over(on_item) {
            break;
        }
    }
    Ok((header, damage))
}

impl Decoded {
    /// Hands over its items one by one, until `on_item` says false; then it is false too.
    fn hand_over(self, on_item: &mut dyn FnMut(u64, Item) -> bool) -> bool {
        match self {
            Self::Probes(samples) => samples.into_iter().all(|sample| on_item(0, Item::Probe(sample))),
            Self::Axes(samples) => samples.into_iter().all(|sample| on_item(0, Item::Axes(sample))),
            Self::Item { index, item } => on_item(index, item),
            Self::Header(_) | Self::Skipped => true,
        }
    }
}

type Texts = HashMap<String, String>;

/// Texts and header read so far, whether the file is sorted, time, and what was read.
type OnDecoded<'v> = &'v mut dyn FnMut(&Texts, &RunHeader, bool, u64, Decoded) -> bool;

/// Hands the messages of the schemas that `wanted` names to `on_item` in the order of the file.
fn walk_items(
    path: &Path,
    (file, bytes): Source<impl Read>,
    wanted: &dyn Fn(&str) -> bool,
    on_decoded: OnDecoded<'_>,
) -> Result<(RunHeader, Option<Damage>), RecordError> {
    let (mut schemas, mut channels) = (HashMap::new(), HashMap::new());
    let mut texts = Texts::new();
    let (mut header, mut sorted) = (None, false);
    let damage = walk(file, bytes, &mut |record| {
        match record {
            Record::Schema { id, name, .. } => {
                schemas.insert(*id, (*name).to_string());
            }
            Record::Channel { id, schema_id, .. } => {
                channels.insert(*id, *schema_id);
            }
            Record::Metadata { name, .. } => sorted |= *name == FINISHED_METADATA,
            Record::Attachment { name, data, .. } => {
                let text =
                    std::str::from_utf8(data).map_err(|_| format!("the attachment {name} is not text"))?;
                texts.insert((*name).into(), text.into());
            }
            Record::Message(message) => {
                let schema = channels.get(&message.channel_id).and_then(|schema| schemas.get(schema));
                let schema = schema.ok_or("a message of a channel that is not declared")?;
                if header.is_some() && !wanted(schema) {
                    return Ok(true);
                }
                match decode(schema, message.data).map_err(|error| error.to_string())? {
                    Decoded::Header(found) => header = header.take().or(Some(found)),
                    Decoded::Skipped => {}
                    decoded => match &header {
                        Some(header) => {
                            return Ok(on_decoded(&texts, header, sorted, message.log_time, decoded));
                        }
                        None => return Err("a message before the header of the run".into()),
                    },
                }
            }
        }
        Ok(true)
    })
    .map_err(RecordError::io("read", path))?;
    let header: RunHeader = header.ok_or_else(|| RecordError::NotARecording {
        path: path.into(),
        offset: damage.as_ref().map_or(0, |damage| damage.offset),
        reason: damage.as_ref().map_or("it has no header".into(), |damage| damage.reason.clone()),
    })?;
    Ok((header_with(header, &texts), damage))
}

fn header_with(mut header: RunHeader, texts: &Texts) -> RunHeader {
    let text = |name: &str| texts.get(name).cloned().unwrap_or_default();
    header.machine_text = text(MACHINE_TEXT);
    header.cycle_text = text(CYCLE_TEXT);
    header.config_text = text(CONFIG_TEXT);
    header
}

/// The header, if this is its message.
pub fn decode_header(schema: &str, payload: &[u8]) -> Option<RunHeader> {
    match decode(schema, payload) {
        Ok(Decoded::Header(header)) => Some(header),
        _ => None,
    }
}
