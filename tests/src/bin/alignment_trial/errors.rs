//! Errors of every sample, four ways of timing it.

use crate::floor::{BAR_ZERO_MM, DEVICES, PROBE_CLOCKS};
use crate::world::{ClockWorld, MARGIN_S};
use std::collections::BTreeMap;
use trunnion_acquire::{GestureFinder, Message, Stream, Survey, TimeBase, Timed};
use trunnion_hil_sim::devices::DeviceClock;
use trunnion_measurement::{AxisSample, ProbeSample, Stamp};
use trunnion_units::{AxisLetter, HostTime};

/// Samples of the first seconds of a connection are not looked at: the line of a running cycle is older.
const SETTLED_S: f64 = MARGIN_S + 12.0;

/// Mean and spread (rms about it), s.
#[derive(Clone, Copy, Debug, Default)]
pub struct Error {
    /// Mean.
    pub mean_s: f64,
    /// Spread.
    pub rms_s: f64,
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
    /// By that line, the delay of the gestures taken out: what remains against the axes of MTConnect. `None` for controllers.
    pub aligned: Option<Error>,
    /// The delay, and its standard uncertainty, s.
    pub delay_s: Option<(f64, f64)>,
}

/// A sample with its truth.
struct Sample {
    device: usize,
    stamp: Stamp,
    truth_s: f64,
    online_s: f64,
    channel: Option<u16>,
}

/// Errors of every device of the floor.
pub fn of(messages: &[Message], seconds: f64) -> Vec<StreamErrors> {
    let mut base = TimeBase::new(HostTime(0));
    let world = ClockWorld { length_s: seconds };
    let mut surveys: BTreeMap<usize, Survey> = BTreeMap::new();
    let mut samples = Vec::new();
    let (mut probes, mut axes): (Vec<ProbeSample>, Vec<AxisSample>) = Default::default();
    for message in messages {
        let device = usize::from(message.device);
        match base.translate(message) {
            Some(Timed::Probe(sample)) => {
                surveys.entry(device).or_default().probe(&sample);
                probes.push(sample);
                if sample.value_mm.is_finite() {
                    let truth_s = truth_of_probe(device, &sample);
                    let channel = Some(sample.channel);
                    samples.push(Sample {
                        device,
                        stamp: sample.stamp,
                        truth_s,
                        online_s: sample.time_s,
                        channel,
                    });
                }
            }
            Some(Timed::Axes(sample)) => {
                surveys.entry(device).or_default().axes(&sample);
                if DEVICES[device].0.contains("MTConnect") {
                    axes.push(sample);
                }
                if !sample.held {
                    let truth_s = ClockWorld::time_of_c(sample.position[AxisLetter::C]);
                    samples.push(Sample {
                        device,
                        stamp: sample.stamp,
                        truth_s,
                        online_s: sample.time_s,
                        channel: None,
                    });
                }
            }
            _ => {}
        }
    }
    let retimings: BTreeMap<usize, _> =
        surveys.into_iter().map(|(device, survey)| (device, survey.finish().0)).collect();
    let retimed = |device: usize, stream: Stream, stamp: &Stamp| {
        retimings[&device].time_s(stream, stamp).unwrap_or(f64::NAN)
    };
    let device_of =
        |channel: u16| samples.iter().find(|s| s.channel == Some(channel)).map_or(0, |s| s.device);
    let channels: BTreeMap<u16, usize> = (0..4).map(|channel| (channel, device_of(channel))).collect();
    for sample in &mut probes {
        sample.time_s = retimed(channels[&sample.channel], Stream::Probe(sample.channel), &sample.stamp);
    }
    let mtconnect = DEVICES.iter().position(|device| device.0.contains("MTConnect")).unwrap_or(0);
    for sample in &mut axes {
        sample.time_s = retimed(mtconnect, Stream::Axes, &sample.stamp);
    }
    let delays = delays(probes, &axes);
    let looked_at = |sample: &&Sample| {
        sample.truth_s > SETTLED_S
            && sample.truth_s < seconds - MARGIN_S - 1.0
            && world.tells_time(sample.truth_s)
    };
    let whole_s = |sample: &Sample| {
        let stream = sample.channel.map_or(Stream::Axes, Stream::Probe);
        retimed(sample.device, stream, &sample.stamp) - sample.truth_s
    };
    let axes_late_s =
        spread(samples.iter().filter(looked_at).filter(|sample| sample.device == mtconnect).map(whole_s))
            .mean_s;
    (0..DEVICES.len())
        .map(|device| {
            let own: Vec<&Sample> = samples.iter().filter(looked_at).filter(|s| s.device == device).collect();
            let delay_s =
                own.first().and_then(|s| s.channel).and_then(|channel| delays.get(&channel)).copied();
            StreamErrors {
                samples: own.len(),
                arrival: spread(own.iter().map(|s| s.stamp.arrival_s - s.truth_s)),
                online: spread(own.iter().map(|s| s.online_s - s.truth_s)),
                whole: spread(own.iter().map(|s| whole_s(s))),
                aligned: delay_s
                    .map(|(delay_s, _)| spread(own.iter().map(|s| whole_s(s) - delay_s - axes_late_s))),
                delay_s,
            }
        })
        .collect()
}

/// From the device's own clock where it has one, else from what it shows.
fn truth_of_probe(device: usize, sample: &ProbeSample) -> f64 {
    let stamp = sample.stamp;
    match PROBE_CLOCKS.get(device) {
        Some(&(offset_s, rate_ppm)) => {
            DeviceClock::steady(offset_s, rate_ppm).cell_s(stamp.ticks as f64 * stamp.tick_s)
        }
        None => {
            let zero_mm = if DEVICES[device].0.contains("CiA 406") { BAR_ZERO_MM } else { 0.0 };
            ClockWorld::time_of_reading(sample.value_mm - zero_mm, stamp.arrival_s - 0.01)
        }
    }
}

/// Delay of each channel against the axes from all gestures, with its uncertainty, s.
fn delays(mut probes: Vec<ProbeSample>, axes: &[AxisSample]) -> BTreeMap<u16, (f64, f64)> {
    probes.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    let mut finder = GestureFinder::default();
    let mut seen: BTreeMap<u16, Vec<(f64, f64)>> = BTreeMap::new();
    let mut next = probes.iter().peekable();
    for sample in axes {
        while let Some(probe) = next.next_if(|probe| probe.time_s <= sample.time_s) {
            finder.probe(probe);
        }
        for delay in finder.axes(sample).into_iter().flat_map(|gesture| gesture.seen) {
            seen.entry(delay.channel).or_default().push((delay.delay_s, delay.u_s));
        }
    }
    let combine = |(channel, all): (u16, Vec<(f64, f64)>)| {
        let weight: f64 = all.iter().map(|(_, u)| u.powi(-2)).sum();
        (channel, (all.iter().map(|(d, u)| d * u.powi(-2)).sum::<f64>() / weight, weight.powf(-0.5)))
    };
    seen.into_iter().map(combine).collect()
}

fn spread(errors_s: impl Iterator<Item = f64>) -> Error {
    let errors_s: Vec<f64> = errors_s.filter(|error| error.is_finite()).collect();
    let n = errors_s.len().max(1) as f64;
    let mean_s = errors_s.iter().sum::<f64>() / n;
    Error { mean_s, rms_s: (errors_s.iter().map(|e| (e - mean_s).powi(2)).sum::<f64>() / n).sqrt() }
}
