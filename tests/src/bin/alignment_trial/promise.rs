//! What the arithmetic alone promises: a probe on a clock of its own behind a timer, on a computer that does nothing else.
//! y = T·⌈(t + d)/T⌉, d exponential with mean d̄: a reading taken at t is ready d later, and fetched at the next tick of T.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trunnion_core::HostTime;
use trunnion_sync::clock::refit;
use trunnion_tests::alignment::Error;

/// Time between readings, s.
pub const PERIOD_S: f64 = 1e-3;
/// How much faster the probe's clock is.
pub const DRIFT: f64 = 30e-6;
/// Mean time from taken to ready, s.
pub const READY_S: f64 = 50e-6;
/// Length of a run, s.
pub const SECONDS: f64 = 120.0;
/// Runs, each with a phase of its own between probe and timer.
pub const SEEDS: u64 = 20;
const TICK_S: f64 = 1e-6;

/// Errors behind one timer: spreads (rms about the mean), s.
#[derive(Clone, Copy, Debug)]
pub struct Promise {
    /// Of the arrivals, over all runs.
    pub arrival_s: f64,
    /// Of the line of the whole run: least, middle and largest over the runs.
    pub line_s: [f64; 3],
}

/// All runs behind a timer of `timer_s`.
pub fn behind(timer_s: f64) -> Promise {
    let runs: Vec<(f64, f64)> = (0..SEEDS).map(|seed| run(timer_s, seed)).collect();
    let square = runs.iter().map(|(arrival_s, _)| arrival_s.powi(2)).sum::<f64>();
    let mut lines: Vec<f64> = runs.iter().map(|(_, line_s)| *line_s).collect();
    lines.sort_by(f64::total_cmp);
    Promise {
        arrival_s: (square / runs.len() as f64).sqrt(),
        line_s: [lines[0], lines[lines.len() / 2], lines[lines.len() - 1]],
    }
}

/// Spread of the arrivals and of the line's times about the truth, s.
fn run(timer_s: f64, seed: u64) -> (f64, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let begin_s = 1.0 + timer_s * rng.random::<f64>();
    let readings: Vec<(u64, f64, HostTime)> = (0..(SECONDS / PERIOD_S) as u64)
        .map(|n| {
            let device_s = n as f64 * PERIOD_S;
            let truth_s = begin_s + device_s / (1.0 + DRIFT);
            let ready_s = truth_s - READY_S * (1.0 - rng.random::<f64>()).ln();
            let arrival_s = (ready_s / timer_s).ceil() * timer_s;
            ((device_s / TICK_S).round() as u64, truth_s, HostTime((arrival_s * 1e9).round() as i64))
        })
        .collect();
    let line = refit(TICK_S, readings.iter().map(|&(ticks, _, arrival)| (ticks, arrival)));
    let error_s = |at: HostTime, truth_s: f64| at.0 as f64 * 1e-9 - truth_s;
    let by_line = readings
        .iter()
        .map(|&(ticks, truth_s, _)| line.map_or(f64::NAN, |line| error_s(line.to_host(ticks), truth_s)));
    (
        Error::over(readings.iter().map(|&(_, truth_s, arrival)| error_s(arrival, truth_s))).rms_s,
        Error::over(by_line).rms_s,
    )
}
