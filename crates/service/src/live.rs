//! One cycle, live: messages of the devices become run time, recorded items and points.
//!
//! Everything is recorded before it is interpreted. The points that come out are recorded too.

mod bar_length;
mod measured;
mod measurement;
mod tally;

use crate::latest::Latest;
use crate::operator::{Asked, Operator};
use crate::set_up::SetUp;
use measurement::Measurement;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use trunnion::join::UNDER_WAY;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceConfig, DeviceStatus};
use trunnion_core::{Clock, Event, HostTime};
use trunnion_record::{Item, RecordSender};
use trunnion_sync::{Bound, EndReason};

pub use measured::{Counted, Measured};
pub use trunnion_sync::cycle_bounds::Pattern;
pub use trunnion_sync::plan::{Plan, PlanError, check};
pub use trunnion_sync::{CycleBounds, Progress, TimeBase, Timed};

/// A cycle that has begun.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// When its beginning was seen.
    pub at: HostTime,
    /// By what.
    pub why: String,
    /// The program that the controller showed; empty when it showed none.
    pub program: String,
    /// Number of the signal that began it, where signals begin cycles.
    pub signal: Option<u32>,
    /// The program ran already when the controller was first asked.
    pub under_way: bool,
    /// Temperature channels that had reported a value by then; later ones take no part in the run.
    pub temperature_channels: Vec<String>,
    /// A person began it: the controller's program may follow.
    pub by_hand: bool,
}

/// What began a cycle that a person began.
const BY_HAND: &str = "begun by a person";

/// With no message of any device for so long the cycle ends.
const SILENCE: Duration = Duration::from_secs(60);

/// Receives how far a cycle is.
pub type OnProgress<'a> = &'a mut (dyn FnMut(Progress) + Send);

/// The devices of a running service, their clocks, and the rule by which cycles begin and end.
pub struct Live {
    acquisition: Acquisition,
    timebase: TimeBase,
    bounds: CycleBounds,
    latest: Latest,
    asked: Asked,
    set_up: Option<SetUp>,
    /// Temperature channels that have reported a value.
    temperature_channels: Vec<String>,
    /// A cycle that began while the one before it was being measured.
    next: Option<Start>,
    clock: Arc<dyn Clock>,
    cancel: CancellationToken,
}

impl Live {
    /// Starts a session for every device, on the current tokio runtime. Cancelling `cancel` stops them.
    pub fn start(
        devices: Vec<DeviceConfig>,
        bounds: CycleBounds,
        clock: Arc<dyn Clock>,
        cancel: CancellationToken,
    ) -> Self {
        let configured = devices.clone();
        let acquisition = trunnion_acquire::start(devices, clock.clone(), cancel.clone(), QUEUE_LENGTH);
        let latest = Latest::new(&configured, acquisition.states.clone(), clock.clone());
        let (timebase, temperature_channels) = (TimeBase::new(clock.now()), Vec::new());
        let (asked, set_up) = (Operator::default().asked(), None);
        Self {
            acquisition,
            timebase,
            bounds,
            latest,
            asked,
            set_up,
            temperature_channels,
            next: None,
            clock,
            cancel,
        }
    }

    /// Begins and ends cycles when this operator asks too.
    #[must_use]
    pub fn led_by(self, operator: &Operator) -> Self {
        Self { asked: operator.asked(), ..self }
    }

    /// Steps of setting up take what is read while no cycle is measured.
    #[must_use]
    pub fn setting_up(self, set_up: &SetUp) -> Self {
        Self { set_up: Some(set_up.clone()), ..self }
    }

    /// Status of each device, in the order of the configuration.
    pub fn states(&self) -> Vec<watch::Receiver<DeviceStatus>> {
        self.acquisition.states.clone()
    }

    /// The latest values, to be shown while this measures or waits.
    pub fn latest(&self) -> &Latest {
        &self.latest
    }

    /// The clocks of the host.
    pub fn clock(&self) -> &Arc<dyn Clock> {
        &self.clock
    }

    /// Stops all sessions and waits for them.
    pub async fn stop(self) {
        self.acquisition.stop().await;
    }

    /// Waits until a cycle begins; one that began while another was measured has begun. `None` when cancelled or when
    /// all devices are gone.
    pub async fn wait_for_start(&mut self) -> Option<Start> {
        self.asked.forget();
        loop {
            if let Some(start) = self.next.take() {
                return Some(start);
            }
            let waits = self.latest.waits();
            let message = tokio::select! {
                biased;
                () = self.cancel.cancelled() => return None,
                () = self.asked.begins() => {
                    let program = self.bounds.begun_otherwise();
                    let start = self.started(self.clock.now(), BY_HAND.into(), program, false);
                    return Some(Start { by_hand: true, ..start });
                }
                message = self.acquisition.messages.recv() => message?,
            };
            drop(waits);
            self.latest.take(&message);
            let timed = self.timebase.translate(&message);
            self.note_channel(timed.as_ref());
            if let (Some(set_up), Some(timed)) = (&self.set_up, &timed) {
                set_up.take(timed);
            }
            if let Some(Bound::Begins { at, why, program, signal, under_way }) =
                self.bounds.take(&message.reading)
            {
                self.next = Some(Start { signal, ..self.started(at, why, program, under_way) });
            }
        }
    }

    fn started(&self, at: HostTime, why: String, program: String, under_way: bool) -> Start {
        let temperature_channels = self.temperature_channels.clone();
        Start { at, why, program, signal: None, under_way, temperature_channels, by_hand: false }
    }

    fn note_channel(&mut self, timed: Option<&Timed>) {
        if let Some(Timed::Temperature { name, .. }) = timed
            && !self.temperature_channels.contains(name)
        {
            self.temperature_channels.push(name.clone());
        }
    }

    /// Measures one cycle until it ends. Run time zero is `start`.
    ///
    /// # Errors
    /// When the plan cannot be measured.
    pub async fn measure(
        &mut self,
        plan: &Plan,
        start: &Start,
        recorder: &RecordSender,
        progress: OnProgress<'_>,
    ) -> Result<Measured, PlanError> {
        self.timebase.begin_run(start.at);
        self.latest.set_recorder(recorder.clone());
        self.bounds = std::mem::take(&mut self.bounds).with_first_pose(plan.first_pose());
        let mut measurement = Measurement::new(plan, &start.temperature_channels, recorder)?;
        for doubt in self.latest.not_ready(&check(plan)?) {
            let doubt = Event { time_s: 0.0, kind: "warning".into(), text: doubt.to_string() };
            measurement.record(Item::Event(doubt), self.clock.now());
        }
        let begun = Event { time_s: 0.0, kind: "cycle-start".into(), text: start.why.clone() };
        measurement.record(Item::Event(begun), self.clock.now());
        if start.under_way {
            let text = "the program ran already when the service began to look".into();
            let under_way = Event { time_s: 0.0, kind: UNDER_WAY.into(), text };
            measurement.record(Item::Event(under_way), self.clock.now());
        }
        self.asked.forget();
        self.latest.set_doubt(None);
        let mut shown = None;
        while measurement.forming.ended().is_none() {
            let messages = &mut self.acquisition.messages;
            let waits = self.latest.waits();
            let message = tokio::select! {
                biased;
                () = self.cancel.cancelled() => None,
                () = self.asked.aborts() => {
                    measurement.aborted(self.clock.now());
                    break;
                }
                received = tokio::time::timeout(SILENCE, messages.recv()) => match received {
                    Ok(message) => message,
                    Err(_) => {
                        measurement.finish(EndReason::NoMotion, self.clock.now());
                        break;
                    }
                },
            };
            drop(waits);
            measurement.most_waiting = measurement.most_waiting.max(messages.len() + 1);
            let Some(message) = message else {
                measurement.finish(EndReason::Stopped, self.clock.now());
                break;
            };
            self.latest.take(&message);
            match self.bounds.take(&message.reading) {
                Some(Bound::Ends { at, why }) => {
                    measurement.end_seen(self.timebase.seconds(at), why, self.clock.now());
                }
                // The program that the person had in mind.
                Some(Bound::Begins { why, .. }) if start.by_hand && measurement.has_no_point() => {
                    measurement.program_seen(why, self.clock.now());
                }
                Some(Bound::Begins { at, why, program, signal, under_way }) => {
                    // What comes from here on is the next cycle's.
                    measurement.finish(EndReason::ControllerEnded, self.clock.now());
                    self.next = Some(Start { signal, ..self.started(at, why, program, under_way) });
                    break;
                }
                None => {}
            }
            measurement.forming.set_held(self.bounds.is_held());
            let timed = self.timebase.translate(&message);
            self.note_channel(timed.as_ref());
            measurement.tally.take(&message);
            measurement.take(timed, &mut self.timebase, self.clock.now());
            if let Some(doubt) = measurement.take_doubt() {
                self.latest.set_doubt(Some(doubt));
            }
            let now = measurement.forming.progress();
            let counted = Some((now.done, measurement.gaps().len()));
            if std::mem::replace(&mut shown, counted) != counted {
                self.latest.set_cycle(Some((plan.cycle.name.as_str(), now, measurement.gaps())));
                progress(now);
            }
        }
        self.latest.set_cycle(None);
        if self.next.is_none() {
            self.bounds.ended_otherwise();
        }
        measurement.record_open_gaps(self.clock.now());
        measurement.record_tally(self.clock.now());
        Ok(measurement.into_measured())
    }
}
