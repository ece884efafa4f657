//! Course of a temperature channel over a run, and how a structure follows it that lags behind.
//!
//! τ dθ/dt = T − θ, θ = T at the first point            [first-order system; ISO/TR 16015 calls θ the temperature of the structure]
//! T is taken piecewise linear between evenly spaced knots; for that the solution below is exact.
//! Limits: changes faster than duration/240 are smoothed; the structure is soaked at the first point.

use trunnion_core::State;

/// Temperatures at evenly spaced times.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    start_s: f64,
    step_s: f64,
    /// At start, start + step, …; never empty.
    knots_degc: Vec<f64>,
}

const STEPS: usize = 240;

/// `[run][channel]` from timed states; `run_of_setup` by `State::setup` (run 0 for setups it does not list).
pub(crate) fn histories<'a>(
    states: impl Iterator<Item = &'a State> + Clone,
    run_of_setup: &[usize],
    channels: usize,
) -> Vec<Vec<Option<History>>> {
    if channels == 0 {
        return Vec::new();
    }
    let run_of = |state: &State| run_of_setup.get(state.setup).copied().unwrap_or(0);
    let runs = run_of_setup.iter().max().map_or(1, |last| last + 1);
    (0..runs)
        .map(|run| {
            let of_run = states.clone().filter(move |state| run_of(state) == run);
            let course = |channel: usize| {
                let samples =
                    of_run.clone().filter_map(move |s| Some((s.time_s?, *s.temperature_degc.get(channel)?)));
                History::new(samples)
            };
            (0..channels).map(course).collect()
        })
        .collect()
}

impl History {
    /// `None` without samples (time s, temperature °C).
    fn new(samples: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Self> {
        let (start_s, end_s) = samples
            .clone()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (t, _)| (low.min(t), high.max(t)));
        if start_s > end_s {
            return None;
        }
        let step_s = ((end_s - start_s) / STEPS as f64).max(1e-9);
        let mut sums = vec![(0.0, 0u32); STEPS + 1];
        for (time_s, degc) in samples {
            let nearest = (((time_s - start_s) / step_s).round() as usize).min(STEPS);
            sums[nearest].0 += degc;
            sums[nearest].1 += 1;
        }
        let means: Vec<Option<f64>> =
            sums.iter().map(|&(sum, n)| (n > 0).then(|| sum / f64::from(n))).collect();
        Some(Self { start_s, step_s, knots_degc: filled(&means) })
    }

    /// θ at `time_s` for time constant `tau_s` > 0, °C.
    pub fn lagged(&self, time_s: f64, tau_s: f64) -> f64 {
        let elapsed_s = (time_s - self.start_s).max(0.0);
        let decay = (-self.step_s / tau_s).exp();
        let mut felt_degc = self.knots_degc[0];
        for (k, pair) in self.knots_degc.windows(2).enumerate() {
            let (from, to) = (pair[0], pair[1]);
            let slope = (to - from) / self.step_s;
            let left_s = elapsed_s - k as f64 * self.step_s;
            // On a ramp θ runs slope·τ behind; the difference to that dies out.
            let behind = felt_degc - from + slope * tau_s;
            if left_s <= self.step_s {
                return from + slope * (left_s - tau_s) + behind * (-left_s / tau_s).exp();
            }
            felt_degc = to - slope * tau_s + behind * decay;
        }
        felt_degc
    }
}

/// Holes filled along straight lines.
fn filled(means: &[Option<f64>]) -> Vec<f64> {
    let known: Vec<(usize, f64)> =
        means.iter().enumerate().filter_map(|(k, mean)| Some((k, (*mean)?))).collect();
    let mut after = 0;
    (0..means.len())
        .map(|k| {
            while after < known.len() && known[after].0 < k {
                after += 1;
            }
            match (after.checked_sub(1).and_then(|i| known.get(i)), known.get(after)) {
                (Some(&(k0, t0)), Some(&(k1, t1))) => t0 + (t1 - t0) * (k - k0) as f64 / (k1 - k0) as f64,
                (None, Some(&(_, t))) | (Some(&(_, t)), None) => t,
                (None, None) => 0.0,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_structure_at_its_corner_frequency_follows_71_percent_and_45_degrees_behind() {
        // First-order low-pass: gain 1/√2 and phase −45° at ωτ = 1 (−3 dB point of any text book).
        let (tau_s, duration_s) = (600.0, 60.0 * 600.0);
        let samples = (0..2000).map(|i| {
            let t = duration_s * f64::from(i) / 1999.0;
            (t, (t / tau_s).sin())
        });
        let history = History::new(samples).unwrap();
        for t in [20.3, 31.7, 44.9] {
            let felt = history.lagged(t * tau_s, tau_s);
            let expected = std::f64::consts::FRAC_1_SQRT_2 * (t - std::f64::consts::FRAC_PI_4).sin();
            assert!((felt - expected).abs() < 4e-3, "{t} {felt} {expected}");
        }
    }

    #[test]
    fn a_step_is_felt_to_63_percent_after_one_time_constant_and_holes_are_bridged() {
        // 1 − 1/e = 0.6321.
        let history = History::new([(0.0, 20.0), (1.0, 21.0), (240.0, 21.0)].into_iter()).unwrap();
        assert!((history.lagged(60.5, 60.0) - 20.6321).abs() < 1e-3, "{}", history.lagged(60.5, 60.0));
        let ramp = History::new([(0.0, 20.0), (240.0, 44.0)].into_iter()).unwrap();
        // A ramp of 0.1 K/s is felt 0.1·τ late once the start has died out.
        assert!((ramp.lagged(200.0, 10.0) - (20.0 + 20.0 - 1.0)).abs() < 1e-6);
        assert!(History::new(std::iter::empty()).is_none());
    }
}
