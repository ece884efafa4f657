//! The recorder on a thread of its own, for callers that must not wait.
//!
//! The queue is bounded. What does not fit is counted, and written as a gap when there is room again.

use crate::error::RecordError;
use crate::item::Item;
use crate::lost;
use crate::syncs::Syncs;
use crate::writer::{Finished, Recorder};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;
use trunnion_core::{Clock, Gap, HostTime, chain};

/// How often waiting batches are looked at when nothing arrives.
const IDLE: Duration = Duration::from_millis(20);
/// Time between attempts to finish a file that the disk refuses: rewriting reads the whole journal.
const AGAIN: Duration = Duration::from_secs(10);

/// How the recorder is doing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecorderStatus {
    /// Messages written.
    pub messages: u64,
    /// Samples lost: the queue or the disk was full.
    pub lost_samples: u64,
    /// Why nothing can be written at present.
    pub failing: Option<String>,
    /// Most items that ever waited in the queue.
    pub most_waiting: u64,
    /// Odd while the recorder works, even while it waits; one that stays odd for long hangs.
    pub turn: u64,
    /// Longest time for which samples were accepted and not on the disk: what a power cut would have cost at the worst moment.
    pub at_risk: Duration,
}

/// Sends items to the writing thread; clone one for each source.
#[derive(Clone)]
pub struct RecordSender {
    queue: SyncSender<Order>,
    shared: Arc<Mutex<Shared>>,
    waiting: Arc<Waiting>,
}

/// Fill of the queue, and the turns of the thread that empties it.
#[derive(Default)]
struct Waiting {
    now: AtomicU64,
    most: AtomicU64,
    /// Odd while the thread works.
    turn: AtomicU64,
    /// Notified when the end of the run no longer waits.
    given_up: Condvar,
}

impl Waiting {
    /// The thread goes on from waiting to working, or back.
    fn turn(&self) {
        self.turn.fetch_add(1, Ordering::Relaxed);
    }
}

/// The writing thread.
pub struct RecorderHandle {
    sender: RecordSender,
    thread: JoinHandle<Result<Finished, RecordError>>,
}

/// The queue is one piece of memory for the most orders that may wait, new for every run: with items of 650 bytes inside them it took
/// 21 MiB, and a service grew by them from run to run as the allocator kept the pieces.
enum Order {
    Record(Box<Item>, HostTime),
    /// For how long the end waits for a disk that refuses.
    Finish(Duration),
}

const _: () = assert!(size_of::<Order>() <= 32, "large parts of an order belong behind a pointer");

#[derive(Default)]
struct Shared {
    status: RecorderStatus,
    overflow: Option<Gap>,
    overflow_samples: u64,
    gives_up: bool,
}

impl RecordSender {
    /// Hands over one item that arrived at `arrival`; never waits. False when the queue was full and the
    /// item is lost (counted, and recorded as a gap) or the recorder has ended.
    pub fn try_send(&self, item: Item, arrival: HostTime) -> bool {
        // Counted before it is sent: the other end may be quicker than we.
        let waiting = self.waiting.now.fetch_add(1, Ordering::Relaxed) + 1;
        match self.queue.try_send(Order::Record(Box::new(item), arrival)) {
            Ok(()) => {
                self.waiting.most.fetch_max(waiting, Ordering::Relaxed);
                true
            }
            Err(TrySendError::Full(order) | TrySendError::Disconnected(order)) => {
                self.waiting.now.fetch_sub(1, Ordering::Relaxed);
                if let Order::Record(item, _) = order {
                    self.count_lost(&item);
                }
                false
            }
        }
    }

    /// How the recorder is doing.
    pub fn status(&self) -> RecorderStatus {
        let shared = lock(&self.shared);
        let mut status = shared.status.clone();
        status.lost_samples += shared.overflow_samples;
        status.most_waiting = self.waiting.most.load(Ordering::Relaxed);
        status.turn = self.waiting.turn.load(Ordering::Relaxed);
        status
    }

    /// The end of the run no longer waits for a disk that refuses.
    pub fn give_up(&self) {
        lock(&self.shared).gives_up = true;
        self.waiting.given_up.notify_all();
    }

    fn count_lost(&self, item: &Item) {
        let (from_s, to_s, samples) = extent(item);
        let mut shared = lock(&self.shared);
        shared.overflow_samples += samples;
        lost::add(&mut shared.overflow, (from_s, to_s), samples, "the queue to the recorder was full");
    }
}

impl RecorderHandle {
    /// Items that wait for the thread of a service: 2.7 s of three probes at 4 kHz.
    pub const QUEUE: usize = 32_768;

    /// Moves `recorder` to its own thread, with room for `capacity` items.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub fn spawn(recorder: Recorder, capacity: usize, clock: Arc<dyn Clock>) -> std::io::Result<Self> {
        let (queue, orders) = sync_channel(capacity);
        let shared = Arc::new(Mutex::new(Shared::default()));
        let waiting = Arc::new(Waiting::default());
        let sender = RecordSender { queue, shared: Arc::clone(&shared), waiting: Arc::clone(&waiting) };
        let thread = std::thread::Builder::new()
            .name("recorder".into())
            .spawn(move || record(recorder, &orders, &shared, &waiting, clock.as_ref()))?;
        Ok(Self { sender, thread })
    }

    /// A sender for one more source.
    pub fn sender(&self) -> RecordSender {
        self.sender.clone()
    }

    /// As [`RecordSender::try_send`].
    pub fn try_send(&self, item: Item, arrival: HostTime) -> bool {
        self.sender.try_send(item, arrival)
    }

    /// As [`RecordSender::status`].
    pub fn status(&self) -> RecorderStatus {
        self.sender.status()
    }

    /// Ends the run and waits for the finished file. Everything sent before is in it; whatever other senders
    /// send later is refused. Takes as long as rewriting does: call it where blocking is allowed.
    ///
    /// # Errors
    /// As [`Recorder::finish`].
    pub fn finish(self) -> Result<Finished, RecordError> {
        self.finish_within(Duration::ZERO)
    }

    /// The same where a disk that refuses is waited for so long, or until [`RecordSender::give_up`]: what is in memory survives.
    ///
    /// # Errors
    /// As [`Recorder::finish`].
    pub fn finish_within(self, at_most: Duration) -> Result<Finished, RecordError> {
        let Self { sender, thread } = self;
        // Refused only when the thread has ended by itself; joining then says why.
        if sender.queue.send(Order::Finish(at_most)).is_err() {
            tracing::error!("the recorder ended before the run");
        }
        thread.join().unwrap_or(Err(RecordError::Stopped))
    }
}

fn record(
    mut recorder: Recorder,
    orders: &Receiver<Order>,
    shared: &Mutex<Shared>,
    waiting: &Waiting,
    clock: &dyn Clock,
) -> Result<Finished, RecordError> {
    let mut syncs = Syncs::begin(clock.now());
    let at_most = loop {
        let order = orders.recv_timeout(IDLE);
        waiting.turn();
        match order {
            Ok(Order::Record(item, arrival)) => {
                waiting.now.fetch_sub(1, Ordering::Relaxed);
                recorder.append(*item, arrival);
            }
            Err(RecvTimeoutError::Timeout) => recorder.flush_aged(clock.now()),
            Ok(Order::Finish(at_most)) => break at_most,
            Err(RecvTimeoutError::Disconnected) => break Duration::ZERO,
        }
        write_overflow(&mut recorder, shared, clock);
        if syncs.is_due(clock.now()) {
            let began = clock.now();
            let is_on_disk = recorder.sync(began);
            syncs.done(began, clock.now(), is_on_disk);
            lock(shared).status.at_risk = syncs.at_risk();
        }
        waiting.turn();
    };
    // From here on nothing more comes in: rewriting takes as long as it takes, and nobody waits for its turn.
    waiting.turn();
    let asked = clock.now();
    let waits = || clock.now() - asked < at_most && !lock(shared).gives_up;
    write_overflow(&mut recorder, shared, clock);
    // Before the disk is waited for: the last samples are in a batch that is not full.
    recorder.flush(clock.now());
    while recorder.failing().is_some() && waits() {
        // Room on a disk cannot be awaited; it is tried again every `writer::RETRY`.
        std::thread::sleep(IDLE);
        recorder.try_again(clock.now());
        write_overflow(&mut recorder, shared, clock);
    }
    let mut closed = recorder.close(clock.now());
    let mut finished = loop {
        let why = match closed.finish() {
            Ok(finished) => break finished,
            Err(error) if error.may_pass() && waits() => chain(&error),
            Err(error) => return Err(error),
        };
        if lock(shared).status.failing.replace(why.clone()) != Some(why.clone()) {
            tracing::error!("the recording cannot be finished yet: {why}");
        }
        let left = at_most.saturating_sub(clock.now() - asked);
        let goes_on = |shared: &mut Shared| !shared.gives_up;
        // Whatever ends the wait, `waits` decides.
        drop(waiting.given_up.wait_timeout_while(lock(shared), AGAIN.min(left), goes_on));
    };
    let mut shared = lock(shared);
    shared.status.failing = None;
    finished.lost_samples += shared.overflow_samples;
    Ok(finished)
}

fn write_overflow(recorder: &mut Recorder, shared: &Mutex<Shared>, clock: &dyn Clock) {
    let overflow = {
        let mut shared = lock(shared);
        shared.status.messages = recorder.messages();
        shared.status.lost_samples = recorder.lost_samples();
        shared.status.failing = recorder.failing().map(Into::into);
        shared.overflow.take()
    };
    if let Some(gap) = overflow {
        recorder.append(Item::Gap(gap), clock.now());
    }
}

/// First time, last time and number of samples of an item.
fn extent(item: &Item) -> (f64, f64, u64) {
    let at = |time_s: f64| (time_s, time_s, 1);
    match item {
        Item::Probe(sample) => at(sample.time_s),
        Item::Axes(sample) => at(sample.time_s),
        Item::Point(point) => at(point.state.time_s.unwrap_or(0.0)),
        Item::Temperature(reading) => at(reading.time_s),
        Item::Event(event) => at(event.time_s),
        Item::Gap(gap) => (gap.from_s, gap.to_s, 1),
    }
}

/// A poisoned lock only means that a sender panicked between two counts.
fn lock(shared: &Mutex<Shared>) -> std::sync::MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
