//! The lower envelope of arrivals.

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
    pub(super) origin_ticks: u64,
    pub(super) origin: HostTime,
    pub(super) tick_ns: f64,
    /// Drift of the device clock's tick against its nominal length; 0 while unknown.
    pub drift: f64,
    pub(super) offset_ns: f64,
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
    pub(super) tick_ns: f64,
    pub(super) block_ns: f64,
    pub(super) first: Option<(u64, HostTime)>,
    pub(super) block: Hull,
    pub(super) window: Hull,
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
    pub fn least_latency_ns(&self, line: &Translation) -> Option<f64> {
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
pub(super) fn ticks_between(origin: u64, ticks: u64) -> f64 {
    ticks.wrapping_sub(origin).cast_signed() as f64
}

/// `excess` is arrival minus nominal device time, ns: small numbers keep their digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) excess: f64,
}

/// Lower convex hull of points that come in order of x (monotonic chain).
#[derive(Clone, Debug, Default)]
pub(super) struct Hull {
    pub(super) points: Vec<Point>,
    pub(super) sum_x: f64,
    pub(super) count: f64,
}

impl Hull {
    pub(super) fn push(&mut self, new: Point) {
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
    pub(super) fn line(&self) -> Option<(f64, f64)> {
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
