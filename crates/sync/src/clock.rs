//! Device clock to host clock by the lower convex hull.
//! y = a·x + b + d, d ≥ d_min                                                             [docs/design/protocols.md §4.1]
//! x device ticks (unwrapped), y arrival on the host's monotonic clock, ns; a = a₀·(1 + drift); d the delay of one
//! arrival. The line is the edge of the lower hull above the mean of x: of all lines below every point the one with
//! the least sum of distances [Moon, Skelly, Towsley, "Estimation and removal of clock skew", INFOCOM 1999].
//! What remains is d_min, a constant that goes into the latency between controller and probes.
//! Valid while the drift is constant over the window, and the window holds some undelayed arrivals. Before
//! [`SLOPE_AFTER_NS`] the nominal tick is trusted; a drift beyond [`MAX_DRIFT`] is not believed.

mod track;

pub use track::{ClockTrack, Jump};

use trunnion_core::HostTime;

/// Drifts beyond this are jitter, not quartz.
pub const MAX_DRIFT: f64 = 500e-6;
/// Span after which the drift is estimated, ns.
pub const SLOPE_AFTER_NS: f64 = 10e9;
/// Default window, s. It looks back at least half of it: 1 kHz against a 16 ms timer beats in 33 s at 30 ppm, and the
/// slope needs three of them.
pub const WINDOW_S: f64 = 200.0;

/// A fitted line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Translation {
    origin_ticks: u64,
    origin: HostTime,
    tick_ns: f64,
    /// Drift of the device clock's tick against its nominal length; 0 while unknown.
    pub drift: f64,
    offset_ns: f64,
}

impl Translation {
    /// Host time of a device tick.
    pub fn to_host(&self, ticks: u64) -> HostTime {
        let elapsed_ns = ticks_between(self.origin_ticks, ticks) * self.tick_ns;
        let ns = elapsed_ns + self.drift * elapsed_ns + self.offset_ns;
        HostTime(self.origin.0 + ns.round() as i64)
    }
}

/// The running estimate of one device clock, over a sliding window.
///
/// Two hulls are kept: one of the block being filled, one of that block with the block before it. The window so
/// slides by whole blocks and each point costs amortised O(1).
#[derive(Clone, Debug)]
pub struct ClockLine {
    tick_ns: f64,
    block_ns: f64,
    first: Option<(u64, HostTime)>,
    block: Hull,
    window: Hull,
}

impl ClockLine {
    /// For a clock with ticks of nominally `tick_s`; the line looks back between half of `window_s` and all of it.
    pub fn new(tick_s: f64, window_s: f64) -> Self {
        let (block, window) = (Hull::default(), Hull::default());
        Self { tick_ns: tick_s * 1e9, block_ns: window_s * 0.5e9, first: None, block, window }
    }

    /// Takes an arrival; one whose ticks go back is not looked at.
    pub fn push(&mut self, ticks: u64, arrival: HostTime) {
        let (origin_ticks, origin) = *self.first.get_or_insert((ticks, arrival));
        let x = ticks_between(origin_ticks, ticks) * self.tick_ns;
        let excess = (arrival.0 - origin.0) as f64 - x;
        if self.window.points.last().is_some_and(|last| x < last.x) {
            return;
        }
        if self.block.points.first().is_some_and(|first| x - first.x > self.block_ns) {
            self.window = std::mem::take(&mut self.block);
        }
        self.block.push(Point { x, excess });
        self.window.push(Point { x, excess });
    }

    /// How long after `line` the least delayed arrival of the window came, ns; `None` before the first arrival.
    pub fn least_lateness_ns(&self, line: &Translation) -> Option<f64> {
        let (origin_ticks, origin) = self.first?;
        let late = |point: &Point| {
            let ticks = origin_ticks.wrapping_add_signed((point.x / self.tick_ns).round() as i64);
            point.x + point.excess + (origin.0 - line.to_host(ticks).0) as f64
        };
        self.window.points.iter().map(late).reduce(f64::min)
    }

    /// The line now; `None` before the first arrival.
    pub fn translation(&self) -> Option<Translation> {
        let (origin_ticks, origin) = self.first?;
        let (drift, offset_ns) = self.window.line()?;
        Some(Translation { origin_ticks, origin, tick_ns: self.tick_ns, drift, offset_ns })
    }

    /// Host time of a device tick by the line as it stands; `None` before the first arrival.
    pub fn to_host(&self, ticks: u64) -> Option<HostTime> {
        Some(self.translation()?.to_host(ticks))
    }
}

/// The line over a whole run, (ticks, arrival) in order of ticks; `None` when empty.
pub fn refit(tick_s: f64, arrivals: impl IntoIterator<Item = (u64, HostTime)>) -> Option<Translation> {
    let mut line = ClockLine::new(tick_s, f64::INFINITY);
    for (ticks, arrival) in arrivals {
        line.push(ticks, arrival);
    }
    line.translation()
}

/// Ticks from `origin` to `ticks`, exact below 2⁵³.
fn ticks_between(origin: u64, ticks: u64) -> f64 {
    ticks.wrapping_sub(origin).cast_signed() as f64
}

/// `excess` is arrival minus nominal device time, ns: small numbers keep their digits.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    x: f64,
    excess: f64,
}

/// Lower convex hull of points that come in order of x (monotonic chain).
#[derive(Clone, Debug, Default)]
struct Hull {
    points: Vec<Point>,
    sum_x: f64,
    count: f64,
}

impl Hull {
    fn push(&mut self, new: Point) {
        self.sum_x += new.x;
        self.count += 1.0;
        if let Some(last) = self.points.last().filter(|last| last.x >= new.x) {
            if last.excess <= new.excess {
                return; // same tick, later arrival
            }
            self.points.pop();
        }
        while let [.., before, last] = self.points[..] {
            let turn = (last.x - before.x) * (new.excess - before.excess)
                - (last.excess - before.excess) * (new.x - before.x);
            if turn > 0.0 {
                break;
            }
            self.points.pop();
        }
        self.points.push(new);
    }

    /// Slope and intercept of the line.
    fn line(&self) -> Option<(f64, f64)> {
        let (first, last) = (self.points.first()?, self.points.last()?);
        let mean_x = self.sum_x / self.count;
        let right =
            self.points.partition_point(|point| point.x < mean_x).clamp(1, self.points.len().max(2) - 1);
        if last.x - first.x >= SLOPE_AFTER_NS
            && let Some(end) = self.points.get(right)
        {
            let start = self.points[right - 1];
            let slope = (end.excess - start.excess) / (end.x - start.x);
            if slope.abs() <= MAX_DRIFT {
                return Some((slope, start.excess - slope * start.x));
            }
        }
        // The lowest line of nominal slope.
        Some((0.0, self.points.iter().map(|point| point.excess).fold(f64::INFINITY, f64::min)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A device that measures every `period_s` with a clock off by `drift`, read through a timer of `timer_s`.
    struct Link {
        tick_s: f64,
        period_s: f64,
        drift: f64,
        timer_s: f64,
        noise_s: f64,
    }

    /// (ticks, true host time in s, arrival).
    fn simulate(link: &Link, seconds: f64, seed: u64) -> Vec<(u64, f64, HostTime)> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let ticks_per_period = link.period_s / link.tick_s;
        let true_period = link.period_s * (1.0 + link.drift);
        (0..(seconds / link.period_s) as u64)
            .map(|n| {
                let truth = 5.0 + n as f64 * true_period;
                let ready = truth - link.noise_s * (1.0 - rng.random::<f64>()).ln();
                let arrival = (ready / link.timer_s).ceil() * link.timer_s;
                (
                    (n as f64 * ticks_per_period).round() as u64 + 77_000,
                    truth,
                    HostTime((arrival * 1e9) as i64),
                )
            })
            .collect()
    }

    /// Root mean square of the error about its mean (the mean is d_min), s.
    fn rms(errors: &[f64]) -> f64 {
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt()
    }

    const USB: Link = Link { tick_s: 1e-5, period_s: 1e-3, drift: 30e-6, timer_s: 0.016, noise_s: 50e-6 };

    #[test]
    fn a_whole_run_behind_a_16_ms_timer_is_timed_to_tens_of_microseconds() {
        for seed in 0..4 {
            let run = simulate(&USB, 120.0, seed);
            let fit = refit(USB.tick_s, run.iter().map(|&(ticks, _, arrival)| (ticks, arrival))).unwrap();
            let fitted: Vec<f64> =
                run.iter().map(|&(ticks, truth, _)| fit.to_host(ticks).0 as f64 * 1e-9 - truth).collect();
            let raw: Vec<f64> = run.iter().map(|&(_, truth, y)| y.0 as f64 * 1e-9 - truth).collect();
            // docs/design/protocols.md §4.1: 4.6 ms by arrival, 17 µs by the hull.
            assert!(rms(&raw) > 4e-3, "{}", rms(&raw));
            assert!(rms(&fitted) < 50e-6, "{}", rms(&fitted));
            assert!((fit.drift - 30e-6).abs() < 2e-6, "{}", fit.drift);
        }
    }

    #[test]
    fn online_the_line_settles_after_three_beats_and_follows_a_sliding_window() {
        let run = simulate(&USB, 320.0, 9);
        let mut line = ClockLine::new(USB.tick_s, WINDOW_S);
        let mut errors = Vec::new();
        for &(ticks, truth, arrival) in &run {
            line.push(ticks, arrival);
            if truth > 110.0 {
                errors.push(line.to_host(ticks).unwrap().0 as f64 * 1e-9 - truth);
            }
        }
        assert!(rms(&errors) < 50e-6, "{}", rms(&errors));
        assert!(line.window.points.len() < 1000);
    }

    #[test]
    fn a_fast_link_is_timed_to_microseconds() {
        let uart = Link { timer_s: 1e-4, noise_s: 20e-6, ..USB };
        let run = simulate(&uart, 60.0, 3);
        let fit = refit(uart.tick_s, run.iter().map(|&(ticks, _, arrival)| (ticks, arrival))).unwrap();
        let errors: Vec<f64> =
            run.iter().map(|&(ticks, truth, _)| fit.to_host(ticks).0 as f64 * 1e-9 - truth).collect();
        assert!(rms(&errors) < 3e-6, "{}", rms(&errors));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn no_arrival_lies_before_the_time_of_its_reading(
            drift_ppm in -100.0..100.0f64, timer_ms in 0.1..16.0f64, seed in any::<u64>(), seconds in 0.1..40.0f64,
        ) {
            let link = Link { drift: drift_ppm * 1e-6, timer_s: timer_ms * 1e-3, ..USB };
            let run = simulate(&link, seconds, seed);
            let fit = refit(link.tick_s, run.iter().map(|&(ticks, _, arrival)| (ticks, arrival))).unwrap();
            for (ticks, _, arrival) in run {
                prop_assert!(fit.to_host(ticks).0 <= arrival.0 + 1);
            }
        }
    }
}
