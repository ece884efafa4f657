//! A recording on its way into an analysis. The same for a live run, a replay and every command.
//!
//! The points of a run on the fly are formed again from its samples, which the clocks of the whole run and the synchronisation moves time
//! better than was possible while it went on. They become blocks while they are read, so that a long run needs no more memory
//! than a short one. Points at rest, and points without samples, are as recorded.

use crate::completeness::Planned;
use crate::gaps::Gaps;
use crate::timing::Timing;
use crate::{identity, timing};
use std::path::Path;
use std::sync::mpsc;
use trunnion_core::{Gap, Point};
use trunnion_cycles::{Run, RunKind};
use trunnion_engine::Nominal;
use trunnion_engine::plausibility::{PositionDigits, Rounded};
use trunnion_machine::{Machine, NamePlate};
use trunnion_record::{Damage, Item, RecordError, RunHeader, RunStart};
use trunnion_results as results;
use trunnion_sync::CycleEvent;
use trunnion_sync::blocks::{Limits, Reducer};
use trunnion_sync::forming::Forming;
use trunnion_sync::stations::Stations;
use trunnion_sync::time_quality::TimeQuality;
use trunnion_sync::{EndReason, SampleCounts};

pub use crate::reduced::Reduced;

/// A recording as read.
pub struct Recording {
    /// Its points, or blocks of them.
    pub run: Run,
    /// How many points became how few; `None` when every point is as recorded.
    pub reduction: Option<Reduced>,
    /// What its cycle asks for, and what became of it; `None` when it carries no cycle.
    pub planned: Option<Planned>,
    /// What is missing from it: the gaps in what was asked of the devices.
    pub gaps: Vec<Gap>,
    /// What is wrong with the file.
    pub damage: Option<Damage>,
    /// How well it is known in time; `None` without stamps.
    pub timing: Option<TimeQuality>,
    /// What became of its samples, where points were formed from them again.
    pub samples: Option<SampleCounts>,
    /// What the rounding of its positions hides.
    pub rounded: Option<Rounded>,
    /// What the machine file in it says of the one machine; nothing where it has none that this version reads.
    pub plate: NamePlate,
    /// That calibrations of its sensors had ended.
    pub calibration: Vec<results::Doubt>,
}

/// Points in one batch between the threads, and batches waiting.
const BATCH: usize = 256;
const QUEUE: usize = 16;

/// Reads a recording whose machine is shipped with it or found by name in `machine`. With `limits` a run of more
/// points than they allow is reduced. One thread unpacks the file, the other reduces; at most `QUEUE` batches wait between
/// them.
///
/// # Errors
/// A file that cannot be read or is no recording.
pub fn read(
    path: &Path,
    machine: &(dyn Fn(&str) -> Option<Machine> + Sync),
    limits: Option<Limits>,
) -> Result<Recording, RecordError> {
    read_next(path, machine, limits, None)
}

/// The same of a further file of a run; `before` is what those before it hold of its cycle.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_next(
    path: &Path,
    machine: &(dyn Fn(&str) -> Option<Machine> + Sync),
    limits: Option<Limits>,
    before: Option<Planned>,
) -> Result<Recording, RecordError> {
    let header = trunnion_record::read_header(path)?;
    let plan = crate::recorded::plan_of(&header);
    let (timing, gaps) = timing::read(path, plan.as_ref())?;
    let forming = plan
        .filter(|plan| plan.cycle.run_kind() == RunKind::OnTheFly)
        .and_then(|plan| Forming::new(&plan, header.temperature_channels.len()).ok());
    gather(path, header, machine, (limits, before), (forming, timing, gaps))
}

/// The same with the points formed again whatever the cycle, by what the header says now; `None` where it holds no cycle or
/// the recording no stamped samples.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_again(
    path: &Path,
    header: RunHeader,
    machine: &(dyn Fn(&str) -> Option<Machine> + Sync),
    limits: Option<Limits>,
) -> Result<Option<Recording>, RecordError> {
    let Some(plan) = crate::recorded::plan_of(&header) else { return Ok(None) };
    let (Some(timing), gaps) = timing::read(path, Some(&plan))? else { return Ok(None) };
    let Ok(mut forming) = Forming::new(&plan, header.temperature_channels.len()) else { return Ok(None) };
    // Standing still is not the end: what ended the run is over, and a program that waited went on.
    forming.set_held(true);
    gather(path, header, machine, (limits, None), (Some(forming), Some(timing), gaps)).map(Some)
}

/// Points of one thread that unpacks become those of a recording.
fn gather(
    path: &Path,
    header: RunHeader,
    machine: &(dyn Fn(&str) -> Option<Machine> + Sync),
    (limits, before): (Option<Limits>, Option<Planned>),
    (forming, timing, gaps): (Option<Forming>, Option<Timing>, Gaps),
) -> Result<Recording, RecordError> {
    let (send, batches) = mpsc::sync_channel::<Batch>(QUEUE);
    let of_header = header.machine().and_then(Result::ok).or_else(|| machine(&header.machine_name));
    let plate = NamePlate::parse("machine in the recording", &header.machine_text).unwrap_or_default();
    let calibration = identity::calibration_doubts(&header);
    let of_cycle = || of_header.and_then(|machine| Planned::of(&header, &machine));
    let planned = before.map(Planned::next_part).or_else(of_cycle);
    let mut points =
        Points { limits, start: None, kept: Vec::new(), reducing: None, planned, gaps, digits: None };
    let read = std::thread::scope(|scope| {
        let unpack = scope.spawn(|| match (forming, &timing) {
            (Some(forming), Some(timing)) => form_again(path, &header, machine, forming, timing, send),
            _ => unpack(path, machine, send).map(|(start, damage)| (start, damage, None)),
        });
        batches.into_iter().for_each(|batch| points.take(batch));
        unpack.join().expect("a panic of the reading thread ends the program")
    });
    let (start, damage, samples) = read?;
    let digits = points.digits.take();
    let (points, reduction, planned, gaps) = points.finish();
    let timing = timing.map(|timing| timing.quality(&gaps));
    let run = start.run(points);
    let rounded = digits.and_then(|digits| digits.finish(&run.name));
    Ok(Recording { run, reduction, planned, gaps, damage, timing, samples, rounded, plate, calibration })
}

/// Hands over the points that the samples give with the clocks of the whole run.
fn form_again(
    path: &Path,
    header: &RunHeader,
    machine: &(dyn Fn(&str) -> Option<Machine> + Sync),
    mut forming: Forming,
    timing: &Timing,
    send: mpsc::SyncSender<Batch>,
) -> Result<(RunStart, Option<Damage>, Option<SampleCounts>), RecordError> {
    let start = RunStart::new(path, header.clone(), machine)?;
    let mut batches = Batches::new(send);
    batches.start = Some(start.clone());
    let (mut index, mut samples) = (0, None);
    let mut hand_over = |formed: &mut Vec<CycleEvent>| {
        for event in formed.drain(..) {
            match event {
                CycleEvent::Point { point, .. } => {
                    batches.push(index, point);
                    index += 1;
                }
                CycleEvent::Samples { counts, .. } => samples = Some(counts),
                CycleEvent::UnknownDwell { .. } | CycleEvent::Ended { .. } => {}
            }
        }
    };
    let mut formed = Vec::new();
    let (_, damage) = trunnion_record::visit_samples(path, &mut |item| {
        match item {
            Item::Probe(sample) => forming.probe(&timing.probe(sample), &mut formed),
            Item::Axes(sample) => forming.axes(&timing.axes(sample), &mut formed),
            Item::Temperature(reading) => forming.temperature(reading.channel.into(), reading.value_degc),
            _ => {}
        }
        hand_over(&mut formed);
        true
    })?;
    forming.finish(EndReason::Stopped, &mut formed);
    hand_over(&mut formed);
    batches.finish();
    Ok((start, damage, samples))
}

/// Points on their way from the file; the first batch says what run they are of.
struct Batch {
    start: Option<RunStart>,
    points: Vec<(u64, Point)>,
}

/// Points gathered into batches, handed to the other thread when full.
struct Batches {
    send: mpsc::SyncSender<Batch>,
    start: Option<RunStart>,
    points: Vec<(u64, Point)>,
}

impl Batches {
    fn new(send: mpsc::SyncSender<Batch>) -> Self {
        Self { send, start: None, points: Vec::with_capacity(BATCH) }
    }

    fn push(&mut self, index: u64, point: Point) {
        self.points.push((index, point));
        if self.points.len() == BATCH {
            self.hand_over();
        }
    }

    fn hand_over(&mut self) {
        let points = std::mem::replace(&mut self.points, Vec::with_capacity(BATCH));
        let batch = Batch { start: self.start.take(), points };
        self.send.send(batch).expect("batches are taken until the end of the file");
    }

    fn finish(mut self) {
        self.hand_over();
    }
}

fn unpack(
    path: &Path,
    machine: &(dyn Fn(&str) -> Option<Machine> + Sync),
    send: mpsc::SyncSender<Batch>,
) -> Result<(RunStart, Option<Damage>), RecordError> {
    let mut batches = Batches::new(send);
    let mut first = true;
    let read = trunnion_record::visit_points(path, &|name| machine(name), &mut |start, index, point| {
        if std::mem::take(&mut first) {
            batches.start = Some(start.clone());
        }
        batches.push(index, point);
    })?;
    batches.finish();
    Ok(read)
}

/// Points of a run as they are read: kept, or reduced when they are many.
struct Points {
    limits: Option<Limits>,
    start: Option<RunStart>,
    kept: Vec<(u64, Point)>,
    reducing: Option<Reducing>,
    planned: Option<Planned>,
    gaps: Gaps,
    digits: Option<PositionDigits>,
}

enum Reducing {
    Blocks(Box<Reducer<Nominal>>),
    Stations(Box<Stations<Nominal>>),
}

impl Reducing {
    fn begin(start: &RunStart, limits: Limits) -> Self {
        let (machine, setups) = (&start.machine, &start.header.setups);
        match start.header.kind {
            RunKind::OnTheFly => Self::Blocks(Box::new(trunnion_engine::reducer(machine, setups, limits))),
            RunKind::Static => Self::Stations(Box::new(trunnion_engine::stations(machine, setups, limits))),
        }
    }

    fn push(&mut self, index: u64, point: Point) {
        match self {
            Self::Blocks(blocks) => blocks.push(index, point),
            Self::Stations(stations) => stations.push(index, point),
        }
    }

    fn finish(self) -> (Vec<Point>, Reduced) {
        match self {
            Self::Blocks(blocks) => {
                let mut reduction = blocks.finish();
                let reduced = Reduced::of_blocks(&reduction);
                (std::mem::take(&mut reduction.points), reduced)
            }
            Self::Stations(stations) => {
                let reduced = stations.finish();
                let of_stations = Reduced::of_stations(reduced.summary(), reduced.read - reduced.missing);
                (reduced.points, of_stations)
            }
        }
    }
}

impl Points {
    fn take(&mut self, batch: Batch) {
        if let Some(start) = batch.start {
            let header = &start.header;
            self.digits = Some(PositionDigits::new(&start.machine, &header.setups, header.kind));
            self.start = Some(start);
        }
        for (index, point) in batch.points {
            self.gaps.pose(&point);
            if let Some(digits) = &mut self.digits {
                digits.take(&point);
            }
            if let Some(planned) = &mut self.planned {
                planned.take(index, &point);
            }
            match &mut self.reducing {
                Some(reducing) => reducing.push(index, point),
                None => self.kept.push((index, point)),
            }
            let Some((start, limits)) = self.start.as_ref().zip(self.limits) else { continue };
            let most = match start.header.kind {
                RunKind::OnTheFly => limits.most_blocks,
                RunKind::Static => limits.most_stations,
            };
            if self.reducing.is_none() && self.kept.len() > most {
                let mut reducing = Reducing::begin(start, limits);
                self.kept.drain(..).for_each(|(index, point)| reducing.push(index, point));
                self.reducing = Some(reducing);
            }
        }
    }

    fn finish(mut self) -> (Vec<Point>, Option<Reduced>, Option<Planned>, Vec<Gap>) {
        let gaps = self.gaps.finish();
        if let Some(reducing) = self.reducing {
            let (points, reduced) = reducing.finish();
            return (points, Some(reduced), self.planned, gaps);
        }
        self.kept.sort_by_key(|(index, _)| *index);
        let points = self.kept.into_iter().map(|(_, point)| point).collect();
        (points, None, self.planned, gaps)
    }
}
