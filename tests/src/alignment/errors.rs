//! Errors of every sample, four ways of timing it.

use super::world::{ClockWorld, MARGIN_S};
use std::collections::BTreeMap;
use trunnion_core::reading::Message;
use trunnion_core::{AxisSample, HostTime, Joint, ProbeSample, Stamp};
use trunnion_hil_sim::devices::DeviceClock;
use trunnion_sync::time_quality::SyncMove;
use trunnion_sync::{Retiming, RetimingFit, Stream, SyncMoveFinder, TimeBase, Timed, mean_delays};

/// Samples of the first seconds of a connection are not looked at: the line of a running cycle is older.
const SETTLED_S: f64 = MARGIN_S + 12.0;
/// A reading is younger than twice this when it is stamped, s; less than half a period of the sawtooth.
const USUAL_AGE_S: f64 = 0.01;

/// How the truth of a device's samples is known.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    /// It stamps its samples with this clock.
    Clock(DeviceClock),
    /// Its value shows when, above what it shows at no deflection.
    Reading {
        /// What it shows at no deflection, mm.
        zero_mm: f64,
    },
    /// The position of C shows when.
    AngleOfC,
}

/// Mean and spread (rms about it), s.
#[derive(Clone, Copy, Debug, Default)]
pub struct Error {
    /// Mean.
    pub mean_s: f64,
    /// Spread.
    pub rms_s: f64,
}

impl Error {
    /// Of these errors, s; those that are no number are left out.
    pub fn over(errors_s: impl Iterator<Item = f64>) -> Self {
        let errors_s: Vec<f64> = errors_s.filter(|error| error.is_finite()).collect();
        let n = errors_s.len().max(1) as f64;
        let mean_s = errors_s.iter().sum::<f64>() / n;
        Self { mean_s, rms_s: (errors_s.iter().map(|e| (e - mean_s).powi(2)).sum::<f64>() / n).sqrt() }
    }
}

/// One device.
#[derive(Clone, Debug, Default)]
pub struct StreamErrors {
    /// Samples looked at.
    pub samples: usize,
    /// Stamped on arrival.
    pub arrival: Error,
    /// By the line as it goes.
    pub online: Error,
    /// By the line of the whole run.
    pub whole: Error,
    /// By that line, the delay of the synchronisation moves taken out: what remains against the axes of the reference. `None` for
    /// controllers, and where no synchronisation move was seen.
    pub aligned: Option<Error>,
    /// The delay, and its standard uncertainty, s.
    pub delay_s: Option<(f64, f64)>,
}

/// A sample with its truth.
struct Sample {
    device: usize,
    stream: Stream,
    stamp: Stamp,
    truth_s: f64,
    online_s: f64,
}

/// What the messages of all devices hold.
struct Taken {
    samples: Vec<Sample>,
    probes: Vec<(usize, ProbeSample)>,
    /// Positions of the reference.
    axes: Vec<(usize, AxisSample)>,
    lines: BTreeMap<usize, Retiming>,
}

/// Errors of every device, in the order of `truths`; synchronisation moves are looked for in the axes of the device `reference`.
pub fn of(
    messages: &[Message],
    truths: &[Truth],
    reference: Option<usize>,
    seconds: f64,
) -> Vec<StreamErrors> {
    let taken = take(messages, truths, reference);
    let world = ClockWorld { length_s: seconds };
    let is_looked_at = |sample: &&Sample| {
        sample.truth_s > SETTLED_S
            && sample.truth_s < seconds - MARGIN_S - 1.0
            && world.shows_time(sample.truth_s)
    };
    let whole_s =
        |sample: &Sample| taken.time_s(sample.device, sample.stream, &sample.stamp) - sample.truth_s;
    let of_device = |device: usize| -> Vec<&Sample> {
        taken.samples.iter().filter(is_looked_at).filter(|sample| sample.device == device).collect()
    };
    let delays = mean_delays(&taken.sync_moves());
    let axes_late_s =
        reference.map_or(0.0, |device| Error::over(of_device(device).into_iter().map(whole_s)).mean_s);
    let errors = |device: usize| {
        let own = of_device(device);
        let delay = own.first().and_then(|sample| match sample.stream {
            Stream::Probe(channel) => delays.get(&channel),
            Stream::Axes => None,
        });
        StreamErrors {
            samples: own.len(),
            arrival: Error::over(own.iter().map(|sample| sample.stamp.arrival_s - sample.truth_s)),
            online: Error::over(own.iter().map(|sample| sample.online_s - sample.truth_s)),
            whole: Error::over(own.iter().map(|sample| whole_s(sample))),
            aligned: delay.map(|delay| {
                Error::over(own.iter().map(|sample| whole_s(sample) - delay.delay_s - axes_late_s))
            }),
            delay_s: delay.map(|delay| (delay.delay_s, delay.u_s)),
        }
    };
    (0..truths.len()).map(errors).collect()
}

fn take(messages: &[Message], truths: &[Truth], reference: Option<usize>) -> Taken {
    let mut base = TimeBase::new(HostTime(0));
    let mut fits: BTreeMap<usize, RetimingFit> = BTreeMap::new();
    let (mut samples, mut probes, mut axes) = (Vec::new(), Vec::new(), Vec::new());
    for message in messages {
        let device = usize::from(message.device);
        match base.translate(message) {
            Some(Timed::Probe(sample)) => {
                fits.entry(device).or_default().probe(&sample);
                probes.push((device, sample));
                if sample.value_mm.is_finite() {
                    samples.push(Sample {
                        device,
                        stream: Stream::Probe(sample.channel),
                        stamp: sample.stamp,
                        truth_s: truths[device].of_probe(&sample),
                        online_s: sample.time_s,
                    });
                }
            }
            Some(Timed::Axes(sample)) => {
                fits.entry(device).or_default().axes(&sample);
                if Some(device) == reference {
                    axes.push((device, sample));
                }
                if !sample.held {
                    samples.push(Sample {
                        device,
                        stream: Stream::Axes,
                        stamp: sample.stamp,
                        truth_s: ClockWorld::time_of_c(sample.position[Joint::C]),
                        online_s: sample.time_s,
                    });
                }
            }
            _ => {}
        }
    }
    let lines = fits.into_iter().map(|(device, fit)| (device, fit.finish().0)).collect();
    Taken { samples, probes, axes, lines }
}

impl Truth {
    fn of_probe(self, sample: &ProbeSample) -> f64 {
        let stamp = sample.stamp;
        match self {
            Self::Clock(clock) => clock.cell_s(stamp.ticks as f64 * stamp.tick_s),
            Self::Reading { zero_mm } => {
                ClockWorld::time_of_reading(sample.value_mm - zero_mm, stamp.arrival_s - USUAL_AGE_S)
            }
            Self::AngleOfC => f64::NAN,
        }
    }
}

impl Taken {
    /// Time of a stamp by the line of the whole run, s; not a number where nothing is known of its clock.
    fn time_s(&self, device: usize, stream: Stream, stamp: &Stamp) -> f64 {
        self.lines.get(&device).and_then(|lines| lines.time_s(stream, stamp)).unwrap_or(f64::NAN)
    }

    fn sync_moves(&self) -> Vec<SyncMove> {
        let retimed = |(device, sample): &(usize, ProbeSample)| ProbeSample {
            time_s: self.time_s(*device, Stream::Probe(sample.channel), &sample.stamp),
            ..*sample
        };
        let mut probes: Vec<ProbeSample> = self.probes.iter().map(retimed).collect();
        probes.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let mut finder = SyncMoveFinder::default();
        let mut next = probes.iter().peekable();
        let mut sync_moves = Vec::new();
        for (device, sample) in &self.axes {
            let time_s = self.time_s(*device, Stream::Axes, &sample.stamp);
            while let Some(probe) = next.next_if(|probe| probe.time_s <= time_s) {
                finder.probe(probe);
            }
            sync_moves.extend(finder.axes(&AxisSample { time_s, ..*sample }));
        }
        sync_moves
    }
}
