//! The recorder: items in, a journal while the run lasts, a finished file at its end.
//!
//! Samples wait in a batch for at most [`BATCH_AGE`] or until the batch is full; everything else is written at once.
//! After a failed write the file is over: messages wait in a bounded ring while a new file is tried every
//! [`RETRY`], and what the ring cannot hold becomes a gap.

mod batches;
mod closed;
#[cfg(test)]
mod tests;

use crate::error::RecordError;
use crate::item::{Item, RunHeader};
use crate::journal::{JOURNAL_ENDING, Journal, OpenJournal, open_locked, wall_time};
use crate::syncs;
use crate::wire;
use crate::wire::{Encoded, Topic};
use batches::Batches;
pub use closed::{Closed, Finished};
use std::collections::{HashMap, VecDeque};
use std::path::{Path, PathBuf};
use std::time::Duration;
use trunnion_core::{AxisSample, Event, Gap, HostTime, ProbeSample, chain};

/// Longest time a sample waits for its batch to fill.
const BATCH_AGE: Duration = syncs::PERIOD;
/// Shortest time between two samples for viewers, s.
const PLOT_STEP_S: f64 = 0.01;
/// Time between attempts to open a new file after a failure.
const RETRY: Duration = Duration::from_secs(1);
/// Messages kept while nothing can be written, bytes.
const RING_BYTES: usize = 8 << 20;

/// Writes one run. Blocking; asynchronous callers use [`crate::RecorderHandle`].
pub struct Recorder {
    dir: PathBuf,
    name: String,
    header: RunHeader,
    open: OpenJournal,
    journal: Option<Journal>,
    journals: Vec<PathBuf>,
    retry_at: HostTime,
    why_failed: String,
    /// The failure that was logged last.
    reported: Option<String>,
    ring: VecDeque<(Encoded, u64)>,
    ring_bytes: usize,
    lost: Option<Gap>,
    lost_samples: u64,
    probes: Batches<u16, ProbeSample>,
    axes: Batches<(), AxisSample>,
    plotted_s: HashMap<Topic, f64>,
    points: u64,
    messages: u64,
    latest_s: f64,
    /// What is in the open journal.
    written: Written,
}

/// Samples of a journal.
#[derive(Clone, Copy, Default)]
struct Written {
    samples: u64,
    /// Time of the first message with samples.
    from_s: Option<f64>,
}

impl Recorder {
    /// Starts `dir/name.mcap.active`; `dir` is created if need be.
    ///
    /// # Errors
    /// When a recording of this name exists or the journal cannot be started.
    pub fn create(dir: &Path, name: &str, header: &RunHeader) -> Result<Self, RecordError> {
        Self::create_with(dir, name, header, Box::new(open_locked))
    }

    pub(crate) fn create_with(
        dir: &Path,
        name: &str,
        header: &RunHeader,
        open: OpenJournal,
    ) -> Result<Self, RecordError> {
        let mut recorder = Self {
            dir: dir.into(),
            name: name.into(),
            header: header.clone(),
            open,
            journal: None,
            journals: Vec::new(),
            retry_at: header.host_start,
            why_failed: String::new(),
            reported: None,
            ring: VecDeque::new(),
            ring_bytes: 0,
            lost: None,
            lost_samples: 0,
            probes: Batches::default(),
            axes: Batches::default(),
            plotted_s: HashMap::new(),
            points: 0,
            messages: 0,
            latest_s: 0.0,
            written: Written::default(),
        };
        recorder.journal = Some(recorder.start_journal()?);
        Ok(recorder)
    }

    /// Takes one item that arrived at `arrival`. Never fails: what cannot be written now is kept or counted
    /// as lost, [`Recorder::failing`] says so, and the recording holds a gap.
    pub fn append(&mut self, item: Item, arrival: HostTime) {
        match item {
            Item::Probe(sample) => {
                self.plot_probe(&sample, arrival);
                if let Some(full) = self.probes.push(sample.channel, sample, arrival) {
                    self.write_probes(sample.channel, &full, arrival);
                }
            }
            Item::Axes(sample) => {
                self.plot_axes(&sample, arrival);
                if let Some(full) = self.axes.push((), sample, arrival) {
                    self.write_axes(&full, arrival);
                }
            }
            Item::Point(point) => {
                self.points += 1;
                self.write(wire::encode_point(self.points - 1, &point), arrival);
            }
            Item::Temperature(reading) => self.write(wire::encode_temperature(&reading), arrival),
            Item::Event(event) => self.write(wire::encode_event(&event), arrival),
            Item::Gap(gap) => self.write(wire::encode_gap(&gap), arrival),
        }
        self.flush_aged(arrival);
    }

    /// Writes batches older than 40 ms. Call when nothing arrives for a while.
    pub fn flush_aged(&mut self, now: HostTime) {
        self.write_batches(|arrival| now - arrival >= BATCH_AGE, now);
    }

    /// Brings everything that was taken to the disk (0.1–40 ms): not from the thread that acquires. A journal that is not there any
    /// more is over, and what was in it is lost, with a gap in the next.
    ///
    /// # Errors
    /// When the disk refuses; recording goes on.
    pub fn sync(&mut self, now: HostTime) -> Result<(), RecordError> {
        self.write_batches(|_| true, now);
        match self.journal.as_ref().map_or(Ok(()), Journal::sync) {
            Err(error @ RecordError::Gone { .. }) => {
                self.gone(error, now);
                Ok(())
            }
            other => other,
        }
    }

    /// Why nothing can be written at present; `None` while all is well.
    pub fn failing(&self) -> Option<&str> {
        self.journal.is_none().then_some(self.why_failed.as_str())
    }

    /// The journals written so far.
    pub(crate) fn journals(&self) -> &[PathBuf] {
        &self.journals
    }

    /// Messages written so far.
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// Samples lost so far because they could not be written.
    pub fn lost_samples(&self) -> u64 {
        self.lost_samples
    }

    /// Ends the run: writes what waits, rewrites the journal into `NAME.mcap`, verifies it.
    ///
    /// # Errors
    /// When a file cannot be written or does not read back; its journal is then kept for recovery.
    pub fn finish(self, now: HostTime) -> Result<Finished, RecordError> {
        self.close(now).finish()
    }

    /// While nothing can be written: tries again, if it is time to.
    pub fn try_again(&mut self, now: HostTime) {
        if self.journal.is_none() {
            self.try_new_file(now);
        }
    }

    /// Ends the journals. What cannot be written even now is lost, and counted in a gap of the finished file.
    pub(crate) fn close(mut self, now: HostTime) -> Closed {
        if let Err(error) = self.sync(now) {
            tracing::warn!("{}", chain(&error));
        }
        self.retry_at = now;
        self.try_again(now);
        if let Some(journal) = self.journal.take()
            && let Err(error) = journal.close()
        {
            // What was written is in the file; only its end is missing, which nothing needs.
            tracing::warn!("{}", chain(&error));
        }
        while let Some((message, _)) = self.ring.pop_front() {
            self.lose(&message);
        }
        let lost = self.lost.map(|gap| Gap { reason: self.why_failed, ..gap });
        Closed::new(self.journals, lost, self.lost_samples)
    }

    fn write_batches(&mut self, which: impl Fn(HostTime) -> bool, now: HostTime) {
        for (channel, batch) in self.probes.take(&which) {
            self.write_probes(channel, &batch, now);
        }
        for ((), batch) in self.axes.take(&which) {
            self.write_axes(&batch, now);
        }
    }

    fn write_probes(&mut self, channel: u16, batch: &[ProbeSample], arrival: HostTime) {
        for part in batch.chunk_by(|a, b| wire::same_clock(&a.stamp, &b.stamp)) {
            self.write(wire::encode_probes(channel, part), arrival);
        }
    }

    fn write_axes(&mut self, batch: &[AxisSample], arrival: HostTime) {
        for part in batch.chunk_by(|a, b| wire::same_clock(&a.stamp, &b.stamp)) {
            self.write(wire::encode_axes(part), arrival);
        }
    }

    fn write(&mut self, message: Encoded, arrival: HostTime) {
        self.latest_s = self.latest_s.max(message.time_s);
        let publish = wall_time(&self.header, arrival.seconds_since(self.header.host_start));
        if self.journal.is_none() {
            self.try_new_file(arrival);
        }
        if let Err(message) = self.write_now(message, publish, arrival) {
            self.keep(message, publish);
        }
    }

    fn write_now(&mut self, message: Encoded, publish: u64, arrival: HostTime) -> Result<(), Encoded> {
        let Some(journal) = &mut self.journal else { return Err(message) };
        match journal.write(&self.header, &message, publish) {
            Ok(()) => {
                self.messages += 1;
                if message.samples > 0 {
                    self.written.samples += message.samples;
                    self.written.from_s.get_or_insert(message.time_s);
                }
                Ok(())
            }
            Err(error) => {
                let path = journal.abandon();
                self.journal = None;
                self.failed(RecordError::Write { path, source: error }, arrival);
                Err(message)
            }
        }
    }

    /// The journal was removed: begins another at once.
    fn gone(&mut self, error: RecordError, now: HostTime) {
        if let Some(mut journal) = self.journal.take() {
            journal.abandon();
        }
        self.journals.pop();
        let Written { samples, from_s } = self.written;
        self.count_lost(from_s.unwrap_or(self.latest_s), self.latest_s, samples);
        self.failed(error, now);
        self.retry_at = now;
        self.try_new_file(now);
    }

    fn failed(&mut self, error: RecordError, now: HostTime) {
        let why = chain(&error);
        // It is tried again every second: reported once, and again when the reason is another.
        if self.reported.as_ref() != Some(&why) {
            tracing::error!("recording interrupted, kept in memory: {why}");
            self.reported = Some(why.clone());
        }
        self.why_failed = why;
        self.retry_at = now + RETRY;
    }

    /// Keeps a message in the ring; the oldest make room and are counted.
    fn keep(&mut self, message: Encoded, publish: u64) {
        self.ring_bytes += message.payload.len();
        self.ring.push_back((message, publish));
        while self.ring_bytes > RING_BYTES {
            let Some((oldest, _)) = self.ring.pop_front() else { return };
            self.ring_bytes -= oldest.payload.len();
            self.lose(&oldest);
        }
    }

    fn lose(&mut self, message: &Encoded) {
        self.count_lost(message.time_s, message.time_s, message.samples);
    }

    fn count_lost(&mut self, from_s: f64, to_s: f64, samples: u64) {
        self.lost_samples += samples;
        let gap = self.lost.get_or_insert_with(|| Gap {
            source: "recorder".into(),
            from_s,
            to_s,
            lost_samples: Some(0),
            reason: String::new(),
        });
        gap.to_s = gap.to_s.max(to_s);
        gap.lost_samples = gap.lost_samples.map(|lost| lost + samples);
    }

    fn try_new_file(&mut self, now: HostTime) {
        if now < self.retry_at {
            return;
        }
        match self.start_journal() {
            Ok(journal) => self.journal = Some(journal),
            Err(error) => return self.failed(error, now),
        }
        tracing::info!("recording goes on in a new file");
        self.reported = None;
        let text = format!("a new file was begun after: {}", self.why_failed);
        let resumed = Event { time_s: self.latest_s, kind: "recording-resumed".into(), text };
        let lost =
            self.lost.take().map(|gap| wire::encode_gap(&Gap { reason: self.why_failed.clone(), ..gap }));
        let publish = wall_time(&self.header, now.seconds_since(self.header.host_start));
        let waiting = std::mem::take(&mut self.ring);
        self.ring_bytes = 0;
        let first = [Some(wire::encode_event(&resumed)), lost].into_iter().flatten();
        for (message, publish) in first.map(|message| (message, publish)).chain(waiting) {
            if let Err(message) = self.write_now(message, publish, now) {
                self.keep(message, publish);
            }
        }
    }

    /// Starts the journal `NAME.mcap.active`, then `NAME-2.mcap.active` and so on.
    fn start_journal(&mut self) -> Result<Journal, RecordError> {
        std::fs::create_dir_all(&self.dir).map_err(RecordError::io("create the folder", &self.dir))?;
        let name = match self.journals.len() {
            0 => self.name.clone(),
            n => format!("{}-{}", self.name, n + 1),
        };
        let finished = self.dir.join(format!("{name}.mcap"));
        let path = self.dir.join(format!("{name}.mcap{JOURNAL_ENDING}"));
        if let Some(path) = [&finished, &path].into_iter().find(|path| path.exists()) {
            return Err(RecordError::Exists { path: path.clone() });
        }
        let file = (self.open)(&path).map_err(RecordError::io("create", &path))?;
        match Journal::start(path.clone(), file, &self.header) {
            Ok(journal) => {
                self.journals.push(path);
                self.written = Written::default();
                Ok(journal)
            }
            Err(error) => {
                // A journal without its header is worth nothing, and its name must stay free.
                std::fs::remove_file(&path).map_err(RecordError::io("remove", &path))?;
                Err(error)
            }
        }
    }

    fn plot_probe(&mut self, sample: &ProbeSample, arrival: HostTime) {
        if self.due(Topic::Plot(sample.channel), sample.time_s) {
            self.write(wire::encode_plot(sample), arrival);
        }
    }

    fn plot_axes(&mut self, sample: &AxisSample, arrival: HostTime) {
        if self.due(Topic::PlotAxes, sample.time_s) {
            self.write(wire::encode_plot_axes(sample), arrival);
        }
    }

    fn due(&mut self, topic: Topic, time_s: f64) -> bool {
        let last = self.plotted_s.entry(topic).or_insert(f64::NEG_INFINITY);
        let due = time_s - *last >= PLOT_STEP_S;
        if due {
            *last = time_s;
        }
        due
    }
}
