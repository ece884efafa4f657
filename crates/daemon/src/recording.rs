//! A recording on its way into an analysis: runs on the fly become blocks while they are read, so that a long one needs no
//! more memory than a short one. The same for a live run, a replay and every command.

use std::path::Path;
use std::sync::mpsc;
use trunnion_identify::Nominal;
use trunnion_machine::Machine;
use trunnion_measurement::blocks::{Limits, Reducer, Reduction};
use trunnion_measurement::{Point, Run, RunKind};
use trunnion_record::{Damage, RecordError, RunStart};

/// A recording as read.
pub struct Recording {
    /// Its points, or blocks of them.
    pub run: Run,
    /// How the blocks were made; `None` when every point is as recorded.
    pub reduction: Option<Reduction>,
    /// What is wrong with the file.
    pub damage: Option<Damage>,
}

/// Points in one batch between the threads, and batches waiting.
const BATCH: usize = 256;
const QUEUE: usize = 16;

/// Reads a recording whose machine is shipped with it or found by name in `machine`. With `limits` a run on the fly of more
/// points than its blocks is reduced. One thread unpacks the file, the other reduces; at most `QUEUE` batches wait between
/// them.
///
/// # Errors
/// A file that cannot be read or is no recording.
pub fn read(
    path: &Path,
    machine: &(dyn Fn(&str) -> Option<Machine> + Sync),
    limits: Option<Limits>,
) -> Result<Recording, RecordError> {
    let (send, batches) = mpsc::sync_channel::<Batch>(QUEUE);
    let mut points = Points { limits, kept: Vec::new(), reducer: None };
    let read = std::thread::scope(|scope| {
        let unpack = scope.spawn(move || unpack(path, machine, &send));
        batches.into_iter().for_each(|batch| points.take(batch));
        unpack.join().expect("a panic of the reading thread ends the program")
    });
    let (start, damage) = read?;
    let (points, reduction) = points.finish();
    Ok(Recording { run: start.run(points), reduction, damage })
}

/// Points on their way from the file; the first batch says what run they are of.
struct Batch {
    start: Option<RunStart>,
    points: Vec<(u64, Point)>,
}

fn unpack(
    path: &Path,
    machine: &(dyn Fn(&str) -> Option<Machine> + Sync),
    send: &mpsc::SyncSender<Batch>,
) -> Result<(RunStart, Option<Damage>), RecordError> {
    let mut batch = Batch { start: None, points: Vec::with_capacity(BATCH) };
    let mut first = true;
    let hand_over = |batch| send.send(batch).expect("batches are taken until the end of the file");
    let read = trunnion_record::visit_points(path, &|name| machine(name), &mut |start, index, point| {
        if std::mem::take(&mut first) {
            batch.start = Some(start.clone());
        }
        batch.points.push((index, point));
        if batch.points.len() == BATCH {
            let next = Batch { start: None, points: Vec::with_capacity(BATCH) };
            hand_over(std::mem::replace(&mut batch, next));
        }
    })?;
    hand_over(batch);
    Ok(read)
}

/// Points of a run as they are read: kept, or reduced to blocks when they are many and were taken on the fly.
struct Points {
    limits: Option<Limits>,
    kept: Vec<(u64, Point)>,
    reducer: Option<(RunStart, Option<Reducer<Nominal>>)>,
}

impl Points {
    fn take(&mut self, batch: Batch) {
        if let Some(start) = batch.start {
            self.reducer = Some((start, None));
        }
        for (index, point) in batch.points {
            match &mut self.reducer {
                Some((_, Some(reducer))) => reducer.push(index, point),
                _ => self.kept.push((index, point)),
            }
            if let (Some(limits), Some((start, empty @ None))) = (self.limits, &mut self.reducer)
                && start.header.kind == RunKind::OnTheFly
                && self.kept.len() > limits.most_blocks
            {
                let mut reducer = trunnion_identify::reducer(&start.machine, &start.header.setups, limits);
                self.kept.drain(..).for_each(|(index, point)| reducer.push(index, point));
                *empty = Some(reducer);
            }
        }
    }

    fn finish(mut self) -> (Vec<Point>, Option<Reduction>) {
        if let Some((_, Some(reducer))) = self.reducer {
            let mut reduction = reducer.finish();
            return (std::mem::take(&mut reduction.points), Some(reduction));
        }
        self.kept.sort_by_key(|(index, _)| *index);
        (self.kept.into_iter().map(|(_, point)| point).collect(), None)
    }
}
