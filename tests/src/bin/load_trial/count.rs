//! What a finished recording holds of each stream, against what the devices sent: probes by their own clocks, the others by count.

use crate::floor::{EDGE_S, Rates, Sent};
use anyhow::Context;
use std::path::Path;
use trunnion_core::{Gap, Stamp};
use trunnion_record::{BATCH_AGE, Item};

/// One stream of the recording.
#[derive(Clone, Debug)]
pub struct Stream {
    /// Its name.
    pub name: String,
    /// Its nominal rate, Hz.
    pub rate_hz: f64,
    /// Samples in the recording.
    pub recorded: u64,
    /// Samples from the first to the last by the device's clock; none where the device's own count says more.
    pub expected: Option<u64>,
    /// Samples at least a second from both ends of the cycle.
    pub inside: u64,
    /// Longest step between two samples, ms.
    pub longest_step_ms: f64,
    /// The device, as its gaps name it.
    device: &'static str,
    /// Samples that its gaps count as lost.
    lost: u64,
    /// Those among them in gaps a second and more from both ends of the cycle.
    lost_inside: u64,
    /// Its gaps in which nobody could count, s.
    uncounted: Vec<(f64, f64)>,
    /// Where samples are missing by the device's clock: time of the sample before and after, s, and how many.
    holes: Vec<(f64, f64, u64)>,
    /// Clock and time of the sample before, s.
    last: Option<(f64, f64)>,
    first: f64,
}

impl Stream {
    fn new(name: &str, device: &'static str, rate_hz: f64) -> Self {
        Self {
            name: name.into(),
            rate_hz,
            recorded: 0,
            expected: None,
            inside: 0,
            longest_step_ms: 0.0,
            device,
            lost: 0,
            lost_inside: 0,
            uncounted: Vec::new(),
            holes: Vec::new(),
            last: None,
            first: f64::NAN,
        }
    }

    /// `clock_s`: the device's clock where it has one.
    fn take(&mut self, clock_s: f64, time_s: f64, end_s: f64) {
        match self.last {
            Some((last, before_s)) => {
                self.longest_step_ms = self.longest_step_ms.max((clock_s - last) * 1e3);
                let steps = ((clock_s - last) * self.rate_hz).round() as u64;
                if steps > 1 {
                    self.holes.push((before_s, time_s, steps - 1));
                }
            }
            None => self.first = clock_s,
        }
        self.last = Some((clock_s, time_s));
        self.recorded += 1;
        self.inside += u64::from((EDGE_S..end_s).contains(&time_s));
    }

    /// Takes a gap that is of this stream.
    fn take_gap(&mut self, gap: &Gap, end_s: f64) -> bool {
        let is_its_own = gap.source.starts_with(self.device);
        if is_its_own {
            match gap.lost_samples {
                Some(lost) => {
                    self.lost += lost;
                    let is_inside = gap.from_s >= EDGE_S && gap.to_s <= end_s;
                    self.lost_inside += if is_inside { lost } else { 0 };
                }
                None => self.uncounted.push((gap.from_s, gap.to_s)),
            }
        }
        is_its_own
    }

    /// As many samples as the recording says are lost, at most. A gap in which nobody could count, as where the clock of the device was set, reports what its
    /// time holds, or what is missing there by the device's clock, whose time differs.
    pub fn reported_lost(&self) -> u64 {
        let of_gap = |&(from_s, to_s): &(f64, f64)| {
            let within =
                self.holes.iter().filter(|(before_s, after_s, _)| *before_s <= to_s && *after_s >= from_s);
            let by_time = ((to_s - from_s) * self.rate_hz).ceil() as u64;
            by_time.max(within.map(|(.., missing)| missing).sum())
        };
        self.lost + self.uncounted.iter().map(of_gap).sum::<u64>()
    }

    fn expect_by_clock(&mut self) {
        let span_s = self.last.map_or(self.first, |(clock_s, _)| clock_s) - self.first;
        self.expected = Some((span_s * self.rate_hz).round() as u64 + 1);
    }
}

/// A recording in numbers.
#[derive(Clone, Debug)]
pub struct Counts {
    /// Three probes, the encoder, the axes.
    pub streams: Vec<Stream>,
    /// Points made of them.
    pub points: u64,
    /// Gaps recorded, in words.
    pub gaps: Vec<String>,
    /// Samples they say are lost.
    pub lost: u64,
    /// Those among them that do not say how many.
    pub uncounted: u64,
    /// Those among them that are of no single stream.
    pub lost_of_any: u64,
    /// Time of the last sample of the axes, s.
    pub length_s: f64,
    /// Size of the file, MB.
    pub file_mb: f64,
}

/// A recording against what the devices sent.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Length of the program, s.
    pub seconds: f64,
    /// What is in the recording.
    pub counts: Counts,
    /// What encoder and controller sent during the program; `None` where nobody counted.
    pub sent: Option<Sent>,
}

impl Judged {
    /// Samples of a stream that must be there, and those that are.
    pub fn compared(&self, stream: &Stream) -> (u64, u64) {
        match (stream.expected, self.sent) {
            (Some(expected), _) => (expected, stream.recorded),
            // What was sent is counted from the start of the program to its end: a service that was late has seen less.
            (None, Some(sent)) if !self.is_late() => (sent.of(&stream.name), stream.inside),
            (None, _) => (stream.inside, stream.inside),
        }
    }

    /// True when the service began after the program.
    pub fn is_late(&self) -> bool {
        self.counts.length_s < self.seconds - EDGE_S
    }

    /// Samples that the recording says are lost and that are there: of streams that were compared, within what was compared.
    pub fn overcounted(&self) -> u64 {
        let of = |stream: &Stream| match (stream.expected, self.sent) {
            (Some(_), _) => stream.lost_inside,
            (None, Some(_)) if !self.is_late() => stream.lost_inside.saturating_sub(EDGE_SAMPLES),
            (None, _) => 0,
        };
        let missing = |stream: &Stream| {
            let (expected, recorded) = self.compared(stream);
            expected.saturating_sub(recorded)
        };
        self.counts.streams.iter().map(|stream| of(stream).saturating_sub(missing(stream))).sum()
    }

    /// Samples that are missing, and those of them that no gap reports.
    pub fn missing(&self) -> (u64, u64) {
        let streams = &self.counts.streams;
        let unreported_of_all = streams.iter().map(|stream| self.unreported(stream)).sum::<u64>();
        let missing = streams.iter().map(|stream| self.missing_of(stream)).sum();
        (missing, unreported_of_all.saturating_sub(self.counts.lost_of_any))
    }

    /// Each stream with missing samples that no gap of its own reports, in words.
    pub fn silent(&self) -> impl Iterator<Item = String> {
        self.counts.streams.iter().filter(|stream| self.unreported(stream) > 0).map(|stream| {
            let ((expected, recorded), unreported) = (self.compared(stream), self.unreported(stream));
            format!(
                "{}: {unreported} samples are missing without a gap: {expected} expected, {recorded} recorded, {} reported as lost ({} at the \
                 ends of the cycle), {} gaps do not say how many, longest step {:.2} ms",
                stream.name,
                stream.lost,
                stream.lost - stream.lost_inside,
                stream.uncounted.len(),
                stream.longest_step_ms,
            )
        })
    }

    fn missing_of(&self, stream: &Stream) -> u64 {
        let (expected, recorded) = self.compared(stream);
        // By the clock of the device the count is exact.
        let edge = if stream.expected.is_none() { EDGE_SAMPLES } else { 0 };
        expected.saturating_sub(recorded + edge)
    }

    fn unreported(&self, stream: &Stream) -> u64 {
        self.missing_of(stream).saturating_sub(stream.reported_lost())
    }
}

/// The clock of the run and that of the devices differ by some ms, which may move samples over the edges of a count.
const EDGE_SAMPLES: u64 = 2;

/// Time of the device's own clock, s.
fn seconds(stamp: &Stamp) -> f64 {
    stamp.ticks as f64 * stamp.tick_s
}

/// Reads the file once.
pub fn count(path: &Path, rates: Rates, duration_s: f64) -> anyhow::Result<Counts> {
    let probes = ["probe-1", "probe-2", "probe-3"];
    let mut streams: Vec<Stream> = probes.map(|name| Stream::new(name, name, rates.probe_hz)).into();
    streams.push(Stream::new("encoder", "encoder", rates.encoder_hz));
    streams.push(Stream::new("axes", "cnc", rates.axes_hz));
    let (mut points, mut gaps, mut length_s) = (0, Vec::new(), 0.0_f64);
    let (mut lost, mut uncounted, mut lost_of_any) = (0, 0, 0);
    let end_s = duration_s - EDGE_S;
    let read = trunnion_record::visit(path, &mut |item| {
        match item {
            Item::Probe(sample) => {
                let channel = usize::from(sample.channel);
                streams[channel].take(seconds(&sample.stamp), sample.time_s, end_s);
            }
            Item::Axes(sample) if sample.held => {}
            Item::Axes(sample) => {
                streams[4].take(seconds(&sample.stamp), sample.time_s, end_s);
                length_s = length_s.max(sample.time_s);
            }
            Item::Point(_) => points += 1,
            // What was missing before the cycle began is no loss of it. It ends with the first message, which waits for its batch.
            Item::Gap(gap) if gap.from_s < 0.0 && gap.to_s <= BATCH_AGE.as_secs_f64() => {}
            Item::Gap(gap) => {
                lost += gap.lost_samples.unwrap_or(0);
                uncounted += u64::from(gap.lost_samples.is_none());
                if streams.iter_mut().filter_map(|stream| stream.take_gap(&gap, end_s).then_some(())).count()
                    == 0
                {
                    lost_of_any += gap.lost_samples.unwrap_or(0);
                }
                let lost = gap
                    .lost_samples
                    .map_or("number not known".to_owned(), |samples| format!("{samples} samples missing"));
                gaps.push(format!(
                    "{} {:.3} s to {:.3} s, {lost}: {}",
                    gap.source, gap.from_s, gap.to_s, gap.reason
                ));
            }
            Item::Temperature(_) | Item::Event(_) => {}
        }
        true
    });
    let (_, damage) = read.with_context(|| format!("cannot read {}", path.display()))?;
    anyhow::ensure!(damage.is_none(), "the recording is damaged: {damage:?}");
    for probe in &mut streams[..3] {
        probe.expect_by_clock();
    }
    let file_mb = std::fs::metadata(path)?.len() as f64 / 1e6;
    Ok(Counts { streams, points, gaps, lost, uncounted, lost_of_any, length_s, file_mb })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(inside: u64, lost: u64) -> Stream {
        Stream { inside, lost, ..Stream::new("axes", "cnc", 200.0) }
    }

    fn judged(axes: Stream, sent: Sent) -> Judged {
        let counts = Counts {
            streams: vec![axes],
            points: 0,
            gaps: Vec::new(),
            lost: 0,
            uncounted: 0,
            lost_of_any: 0,
            length_s: 10.0,
            file_mb: 0.0,
        };
        Judged { seconds: 10.0, counts, sent: Some(sent) }
    }

    #[test]
    fn only_what_was_compared_can_be_counted_too_often() {
        let gap = |from_s, to_s| Gap {
            source: "cnc".into(),
            from_s,
            to_s,
            lost_samples: Some(60),
            reason: String::new(),
        };
        let with = |gap: Gap, sent: Option<Sent>, length_s: f64| {
            let mut axes = axes(1151, 0);
            assert!(axes.take_gap(&gap, 9.0));
            let judged = judged(axes, Sent { encoder: 0, axes: 1151 });
            let counts = Counts { length_s, ..judged.counts };
            let judged = Judged { sent, counts, ..judged };
            (judged.missing(), judged.overcounted())
        };
        let sent = Some(Sent { encoder: 0, axes: 1151 });
        assert_eq!(with(gap(4.0, 5.0), sent, 10.0), ((0, 0), 60 - EDGE_SAMPLES));
        assert_eq!(with(gap(0.5, 0.8), sent, 10.0), ((0, 0), 0), "in the first second");
        assert_eq!(with(gap(8.8, 9.2), sent, 10.0), ((0, 0), 0), "in the last second");
        assert_eq!(with(gap(4.0, 5.0), None, 10.0), ((0, 0), 0), "nobody counted");
        assert_eq!(with(gap(4.0, 5.0), sent, 8.0), ((0, 0), 0), "the service began late");
    }

    #[test]
    fn a_stream_that_has_a_clock_of_its_own_may_lack_no_sample() {
        let probe =
            Stream { recorded: 999, expected: Some(1000), ..Stream::new("probe-1", "probe-1", 1000.0) };
        assert_eq!(judged(probe, Sent { encoder: 0, axes: 0 }).missing(), (1, 1));
    }

    #[test]
    fn a_gap_without_a_number_reports_what_its_device_skipped_there() {
        let mut probe = Stream::new("probe-1", "probe-1", 1000.0);
        // The clock goes on by 2.001 s where the run's goes on by one.
        for (clock_s, time_s) in [(0.0, 0.0), (0.001, 0.001), (2.002, 1.001), (2.003, 1.002)] {
            probe.take(clock_s, time_s, 9.0);
        }
        probe.expect_by_clock();
        let gap = |from_s, to_s| Gap {
            source: "probe-1".into(),
            from_s,
            to_s,
            lost_samples: None,
            reason: String::new(),
        };
        let silent = |gap: Gap| {
            let mut probe = probe.clone();
            assert!(probe.take_gap(&gap, 9.0));
            judged(probe, Sent { encoder: 0, axes: 0 }).missing()
        };
        assert_eq!(silent(gap(0.001, 1.001)), (2000, 0));
        assert_eq!(silent(gap(1.5, 2.0)), (2000, 1500), "somewhere else");
    }

    #[test]
    fn a_controller_that_samples_less_loses_nothing_and_what_it_sent_must_be_there() {
        let sent = Sent { encoder: 0, axes: 1151 };
        assert_eq!(judged(axes(1150, 0), sent).missing(), (0, 0));
        assert_eq!(judged(axes(700, 0), sent).missing(), (449, 449));
        assert_eq!(judged(axes(700, 400), sent).missing(), (449, 49));
    }
}
