//! Parts of one cycle become one recording: what recorded it ended in between, and came back while the program still ran.
//!
//! The samples of every part are put on the time of the first, by the wall clock, and points are formed from them again: one zero
//! for each setup, each pose once. Between two parts every source has a gap. The parts stay as they are
//! [docs/decisions/0013-parts-of-one-cycle.md].

mod part;

use crate::Error;
use crate::recorded::plan_of;
use part::Part;
use std::path::{Path, PathBuf};
use trunnion_core::{AxisSample, Event, Gap, ProbeSample, Quality};
use trunnion_record::{Item, RunHeader, RunWriter};
use trunnion_results::{Joined, JoinedPart};
use trunnion_sync::forming::Forming;
use trunnion_sync::{CycleEvent, EndReason};

/// Kind of the event of a cycle whose program was running already when the recording began.
pub const UNDER_WAY: &str = "under-way";
/// Kind of the event at the beginning of every part but the first.
const JOINED: &str = "joined";
/// Readings that a cut may cost: the one under way in each of the two parts.
const LOST_AT_A_CUT: usize = 2;
/// Kinds of events that forming gives, for all parts together.
const FORMED: [&str; 2] = ["samples", "unknown-dwell"];

/// Writes the recording `output` of the parts of one cycle, in order of time.
///
/// # Errors
/// Fewer than two parts; parts of different cycles, machines or probes; parts that overlap, or that together hold fewer readings than
/// alone, which parts of one cycle do not; a file that cannot be read or written.
pub fn join(parts: &[PathBuf], output: &Path) -> Result<Joined, Error> {
    let parts: Vec<Part> = parts.iter().map(|path| Part::read(path)).collect::<Result<_, _>>()?;
    let [first, later @ ..] = &parts[..] else { return Err(not_one(output, "no part was given")) };
    if later.is_empty() {
        return Err(not_one(output, "one part is a recording already; give two or more"));
    }
    for (before, part) in parts.iter().zip(later) {
        part.follows(before, first).map_err(|why| not_one(&part.path, &why))?;
    }
    let not_written = Error::not_recorded(output);
    let mut writing = Writing::begin(&parts, output)?;
    parts.iter().enumerate().try_for_each(|(k, part)| writing.take(k, part, &parts))?;
    let Writing { writer, good, .. } = writing.end();
    let alone: usize = parts.iter().map(|part| part.good).sum();
    if good + LOST_AT_A_CUT * later.len() < alone {
        writer.discard().map_err(not_written)?;
        let why =
            format!("together they hold {good} readings, alone {alone}; the program began again in between");
        return Err(not_one(&parts[parts.len() - 1].path, &why));
    }
    writer.finish().map_err(not_written)?;
    let of_part = |part: &Part| JoinedPart {
        run: part.name(),
        from_s: part.begins_s() + part.shift_s(first),
        to_s: part.ends_s() + part.shift_s(first),
        read: part.good,
    };
    let parts = parts.iter().map(of_part).collect();
    Ok(Joined { run: output.display().to_string(), read: good, parts, ..Joined::default() })
}

fn not_one(path: &Path, why: &str) -> Error {
    Error::NotJoined { path: path.into(), why: why.into() }
}

/// The recording on its way.
struct Writing {
    writer: RunWriter,
    header: RunHeader,
    forming: Forming,
    formed: Vec<CycleEvent>,
    good: usize,
    /// Newest sample, s.
    now_s: f64,
}

impl Writing {
    fn begin(parts: &[Part], output: &Path) -> Result<Self, Error> {
        let first = &parts[0];
        let mut header = first.header.clone();
        header.name = output.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        for name in parts.iter().flat_map(|part| &part.header.temperature_channels) {
            if !header.temperature_channels.contains(name) {
                header.temperature_channels.push(name.clone());
            }
        }
        let plan = plan_of(&header).ok_or_else(|| not_one(&first.path, "it holds no cycle"))?;
        let mut forming = Forming::new(&plan, header.temperature_channels.len())
            .map_err(|why| not_one(&first.path, &why.to_string()))?;
        // A gap between two parts is not the end, however long.
        forming.set_held(true);
        let writer = RunWriter::create(output, &header).map_err(Error::not_recorded(output))?;
        Ok(Self { writer, header, forming, formed: Vec::new(), good: 0, now_s: 0.0 })
    }

    fn take(&mut self, k: usize, part: &Part, parts: &[Part]) -> Result<(), Error> {
        let is_last = k + 1 == parts.len();
        if let Some(before) = k.checked_sub(1).map(|before| &parts[before]) {
            let (gaps, event) = between(before, part, &parts[0]);
            self.write(Item::Event(event));
            gaps.into_iter().for_each(|gap| self.write(Item::Gap(gap)));
        }
        let epochs: u32 = parts[..k].iter().map(Part::epochs).sum();
        let shift_s = part.shift_s(&parts[0]);
        let channels: Vec<Option<u16>> = part.temperature_channels(&self.header);
        let read = trunnion_record::visit(&part.path, &mut |item| {
            if let Some(item) = part::shifted(item, shift_s, epochs, &channels) {
                self.item(item, is_last);
            }
            true
        });
        read.map(drop).map_err(Error::recording(&part.path))
    }

    fn item(&mut self, item: Item, is_last: bool) {
        match &item {
            Item::Probe(sample) => self.forming.probe(sample, &mut self.formed),
            Item::Axes(sample) => self.forming.axes(sample, &mut self.formed),
            Item::Temperature(reading) => {
                self.forming.temperature(reading.channel.into(), reading.value_degc)
            }
            Item::Point(_) => return,
            Item::Event(event) if FORMED.contains(&event.kind.as_str()) => return,
            Item::Event(event) if event.kind == "cycle-end" && !is_last => return,
            Item::Event(_) | Item::Gap(_) => {}
        }
        self.write(item);
        self.write_formed();
    }

    fn write_formed(&mut self) {
        for event in std::mem::take(&mut self.formed) {
            // The last part says itself why it ended.
            if matches!(event, CycleEvent::Ended { .. }) {
                continue;
            }
            let item = event.into_point().map_or_else(Item::Event, Item::Point);
            self.good += usize::from(matches!(&item, Item::Point(point) if point.quality == Quality::Good));
            self.write(item);
        }
    }

    fn write(&mut self, item: Item) {
        if let Item::Probe(ProbeSample { time_s, .. }) | Item::Axes(AxisSample { time_s, .. }) = &item {
            self.now_s = self.now_s.max(*time_s);
        }
        self.writer.item(item, self.now_s);
    }

    fn end(mut self) -> Self {
        self.forming.finish(EndReason::Stopped, &mut self.formed);
        self.write_formed();
        self
    }
}

/// What lies between two parts, in the time of the first.
fn between(before: &Part, part: &Part, first: &Part) -> (Vec<Gap>, Event) {
    let reason = format!("nothing was recorded between {} and {}", before.name(), part.name());
    let gap = |(source, to_s): (&String, &f64)| {
        let from_s = before.last_s.get(source).copied().unwrap_or_else(|| before.ends_s());
        Gap {
            source: source.clone(),
            from_s: from_s + before.shift_s(first),
            to_s: to_s + part.shift_s(first),
            lost_samples: None,
            reason: reason.clone(),
        }
    };
    let text = format!("{} goes on with {}", before.name(), part.name());
    let time_s = part.begins_s() + part.shift_s(first);
    (part.first_s.iter().map(gap).collect(), Event { time_s, kind: JOINED.into(), text })
}
