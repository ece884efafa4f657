//! Device clock to host clock by the lower convex hull.
//! y = a·x + b + d, d ≥ d_min                                                             [docs/design/protocols.md §4.1]
//! x device ticks (unwrapped), y arrival on the host's monotonic clock, ns; a = a₀·(1 + drift); d the delay of one
//! arrival. The line is the edge of the lower hull above the mean of x: of all lines below every point the one with
//! the least sum of distances [Moon, Skelly, Towsley, "Estimation and removal of clock skew", INFOCOM 1999].
//! What remains is d_min, a constant that goes into the latency between controller and probes.
//! Valid while the drift is constant over the window, and the window holds some undelayed arrivals. Before
//! [`SLOPE_AFTER_NS`] the nominal tick is trusted; a drift beyond [`MAX_DRIFT`] is not believed.

mod line;
mod track;

pub use line::{ClockLine, MAX_DRIFT, SLOPE_AFTER_NS, Translation, WINDOW_S, refit};

pub use track::{ClockTrack, Jump};

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use trunnion_core::HostTime;

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
