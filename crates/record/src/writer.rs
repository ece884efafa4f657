//! The recorder: items in, a journal while the run lasts, a finished file at its end.
//!
//! Samples wait in a batch for at most [`BATCH_AGE`] or until the batch is full; everything else is written at once.
//! After a failed write the file is over: messages wait in a bounded ring while a new file is tried every
//! [`RETRY`], and what the ring cannot hold becomes a gap.

mod batches;
mod begin;
mod closed;
mod kept;
mod missing;
mod plots;
#[cfg(test)]
mod tests;

use crate::error::RecordError;
use crate::item::{Item, RunHeader};
use crate::journal::{Journal, wall_time};
use crate::journal_file::{OpenJournal, open_locked};
use crate::lost;
use crate::syncs;
use crate::wire;
use crate::wire::{Encoded, Topic};
use batches::Batches;
pub use closed::{Closed, Finished};
use kept::{KeptJournal, Missing};
use plots::Plots;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::Duration;
use trunnion_core::{AxisSample, Event, Gap, HostTime, ProbeSample, chain};

/// Longest time a sample waits for its batch to fill.
pub const BATCH_AGE: Duration = syncs::PERIOD;
/// Time between attempts to open a new file after a failure.
const RETRY: Duration = Duration::from_secs(1);
/// Of what is lost: the reason is that of the moment at which the gap is written.
const REASON_LATER: &str = "";
/// Messages kept while nothing can be written, bytes.
const RING_BYTES: usize = 8 << 20;

/// Writes one run. Blocking; asynchronous callers use [`crate::RecorderHandle`].
pub struct Recorder {
    dir: PathBuf,
    name: String,
    header: RunHeader,
    open: OpenJournal,
    journal: Option<Journal>,
    /// Those of the run so far; the last is the open one, where one is open.
    journals: Vec<KeptJournal>,
    /// One that was not at its place: lost, unless it is there again when the next one begins.
    missing: Option<Missing>,
    retry_at: HostTime,
    why_failed: String,
    /// The same as it happened, while nothing can be written.
    failure: Option<RecordError>,
    ring: VecDeque<(Encoded, u64)>,
    ring_bytes: usize,
    lost: Option<Gap>,
    lost_samples: u64,
    probes: Batches<u16, ProbeSample>,
    axes: Batches<(), AxisSample>,
    plots: Plots,
    points: u64,
    messages: u64,
    latest_s: f64,
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
            missing: None,
            retry_at: header.host_start,
            why_failed: String::new(),
            failure: None,
            ring: VecDeque::new(),
            ring_bytes: 0,
            lost: None,
            lost_samples: 0,
            probes: Batches::default(),
            axes: Batches::default(),
            plots: Plots::default(),
            points: 0,
            messages: 0,
            latest_s: 0.0,
        };
        if let Some(path) = recorder.taken(0) {
            return Err(RecordError::Exists { path });
        }
        recorder.journal = Some(recorder.start_journal(0)?);
        Ok(recorder)
    }

    /// Takes one item that arrived at `arrival`. Never fails: what cannot be written now is kept or counted
    /// as lost, [`Recorder::failing`] says so, and the recording holds a gap.
    pub fn append(&mut self, item: Item, arrival: HostTime) {
        match item {
            Item::Probe(sample) => {
                if self.plots.is_due(Topic::Plot(sample.channel), sample.time_s) {
                    self.write(wire::encode_plot(&sample), arrival);
                }
                if let Some(full) = self.probes.push(sample.channel, sample, arrival) {
                    self.write_probes(sample.channel, &full, arrival);
                }
            }
            Item::Axes(sample) => {
                if self.plots.is_due(Topic::PlotAxes, sample.time_s) {
                    self.write(wire::encode_plot_axes(&sample), arrival);
                }
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

    /// Writes every batch, however young.
    pub(crate) fn flush(&mut self, now: HostTime) {
        self.write_batches(|_| true, now);
    }

    /// Brings everything that was taken to the disk (0.1–40 ms): not from the thread that acquires. True when it is there.
    ///
    /// A journal that is not there any more is over, and what was in it is lost, with a gap in the next. One that the disk refuses is
    /// over too: Linux reports a failed write of its cache once and takes those pages as written afterwards (fsync(2)), so a later
    /// success says nothing of them.
    pub fn sync(&mut self, now: HostTime) -> bool {
        self.flush(now);
        match self.journal.as_ref().map(Journal::sync) {
            Some(Ok(())) => true,
            Some(Err(RecordError::Gone { path })) => {
                self.gone(path, now);
                false
            }
            Some(Err(error)) => {
                self.abandon();
                self.failed(error, now);
                false
            }
            None => false,
        }
    }

    /// Why nothing can be written at present; `None` while all is well.
    pub fn failing(&self) -> Option<&str> {
        self.journal.is_none().then_some(self.why_failed.as_str())
    }

    /// The same as it happened, once.
    pub(crate) fn take_failure(&mut self) -> Option<RecordError> {
        self.failure.take()
    }

    /// The journals written so far.
    pub(crate) fn journals(&self) -> impl Iterator<Item = &Path> {
        self.journals.iter().map(|journal| journal.path.as_path())
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
        self.flush(now);
        // One that is gone gets a file after it, which says so. One that the disk refuses is rewritten from what the system has of it.
        match self.journal.as_ref().map(Journal::sync) {
            Some(Err(RecordError::Gone { path })) => self.gone(path, now),
            Some(Err(error)) => power_cut_may_cost(&error),
            Some(Ok(())) | None => {}
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
        self.look_for_missing();
        self.settle_missing();
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
        self.write_or_keep(message, publish, arrival);
    }

    fn write_now(&mut self, message: Encoded, publish: u64, arrival: HostTime) -> Result<(), Encoded> {
        let Some(journal) = &mut self.journal else { return Err(message) };
        match journal.write(&self.header, &message, publish) {
            Ok(()) => {
                self.messages += 1;
                if let Some(kept) = self.journals.last_mut() {
                    kept.wrote(&message);
                }
                Ok(())
            }
            Err(error) => {
                let refused = RecordError::Write { path: journal.abandon(), source: error };
                // What was written before is whole, and nobody else brings it to the disk.
                let why = match journal.sync() {
                    Ok(()) => refused,
                    Err(gone @ RecordError::Gone { .. }) => {
                        self.abandon_missing();
                        gone
                    }
                    Err(error) => {
                        power_cut_may_cost(&error);
                        refused
                    }
                };
                self.abandon();
                self.failed(why, arrival);
                Err(message)
            }
        }
    }

    fn abandon(&mut self) {
        if let Some(mut journal) = self.journal.take() {
            journal.abandon();
        }
    }

    /// The journal is not at its place: another is begun at once.
    fn gone(&mut self, path: PathBuf, now: HostTime) {
        self.abandon_missing();
        self.failed(RecordError::Gone { path }, now);
        self.retry_at = now;
        self.try_new_file(now);
    }

    fn failed(&mut self, error: RecordError, now: HostTime) {
        let why = chain(&error);
        // It is tried again every second: reported once, and again when the reason is another.
        if self.failure.as_ref().is_none_or(|last| chain(last) != why) {
            tracing::error!("recording interrupted, kept in memory: {why}");
        }
        self.why_failed = why;
        self.failure = Some(error);
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
        self.lost_samples += message.samples;
        lost::add(
            &mut self.lost,
            (message.time_s, message.until_s),
            message.samples + message.missing,
            REASON_LATER,
        );
    }

    fn try_new_file(&mut self, now: HostTime) {
        if now < self.retry_at {
            return;
        }
        self.look_for_missing();
        match self.start_further_journal() {
            Ok(journal) => self.journal = Some(journal),
            Err(error) => return self.failed(error, now),
        }
        self.settle_missing();
        tracing::info!("recording goes on in a new file");
        self.failure = None;
        let text = format!("a new file was begun after: {}", self.why_failed);
        let resumed = Event { time_s: self.latest_s, kind: "recording-resumed".into(), text };
        let publish = wall_time(&self.header, now.seconds_since(self.header.host_start));
        let waiting = std::mem::take(&mut self.ring);
        self.ring_bytes = 0;
        // Of the recorder itself: nothing is lost with it.
        let resumed = Encoded { samples: 0, ..wire::encode_event(&resumed) };
        self.write_or_keep(resumed, publish, now);
        self.write_lost(publish, now);
        for (message, publish) in waiting {
            self.write_or_keep(message, publish, now);
        }
    }

    /// What was lost so far stays counted until the file has it.
    fn write_lost(&mut self, publish: u64, now: HostTime) {
        let Some(gap) = self.lost.take() else { return };
        let gap = Gap { reason: self.why_failed.clone(), ..gap };
        if self.write_now(wire::encode_gap(&gap), publish, now).is_err() {
            self.lost = Some(gap);
        }
    }

    fn write_or_keep(&mut self, message: Encoded, publish: u64, now: HostTime) {
        if let Err(message) = self.write_now(message, publish, now) {
            self.keep(message, publish);
        }
    }
}

/// The data are in the file; whether they are on the disk is not known.
fn power_cut_may_cost(error: &RecordError) {
    tracing::warn!("a power cut may cost its last samples: {}", chain(error));
}
