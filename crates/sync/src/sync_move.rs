//! Synchronisation moves: strokes of one linear axis that the axes and the probes both see.
//! p(t) = a + g·x(t − τ)                                                                     [docs/design/protocols.md §4.3]
//! p reading of a channel at its own time t, x position of the axis, g change of the reading by the motion, τ by how much the
//! readings come after the axes. At a velocity v and a noise σ every reading determines τ to σ/(g·v).
//! The least delay of each line of transport (`d_min`, clock) is in τ, and so is the delay inside probe and control.
//! Valid while nothing else moves: all other axes stand, the axis comes back to where it began, and it stands before and after.

mod mean;

pub use mean::{MeanDelay, mean_delays};

use crate::time_quality::{SyncMove, SyncMoveDelay};
use std::collections::VecDeque;
use trunnion_core::{AxisSample, AxisValues, Joint, ProbeSample};

/// Standing within these is standing: linear axes mm, rotary axes rad.
const STILL: (f64, f64) = (0.003, 20e-6);
/// A stroke is at least and at most so long, mm.
const STROKE_MM: (f64, f64) = (0.03, 1.5);
/// Standing before the first and after the last stroke, s.
const STAND_S: f64 = 0.4;
/// A synchronisation move is over within this time, s.
const LONGEST_S: f64 = 8.0;
/// Largest delay that is looked for, s.
const LARGEST_DELAY_S: f64 = 0.15;
/// Steps of the first look, s.
const COARSE_S: f64 = 1e-3;
/// A channel that moves less than this with the axis says nothing, mm/mm.
const LEAST_GAIN: f64 = 0.1;
/// Share of the reading's motion that the axis must explain.
const LEAST_SHARE: f64 = 0.9;
/// Probe samples kept: 10 s of four channels at 4 kHz.
const KEPT_PROBES: usize = 160_000;

/// Looks for synchronisation moves in samples that come in order of time, from a recording or live.
#[derive(Debug, Default)]
pub struct SyncMoveFinder {
    axes: VecDeque<AxisSample>,
    probes: VecDeque<ProbeSample>,
    state: State,
}

#[derive(Clone, Copy, Debug, Default)]
enum State {
    /// Something moves, or nothing is known yet.
    #[default]
    Moving,
    /// All axes stand at a place since a time.
    Standing { at: AxisValues<f64>, since_s: f64 },
    /// One linear axis strokes about the place it stood at.
    Stroking {
        at: AxisValues<f64>,
        began_s: f64,
        axis: Option<Joint>,
        farthest_mm: f64,
        back_since_s: Option<f64>,
    },
}

impl SyncMoveFinder {
    /// Takes a displacement.
    pub fn probe(&mut self, sample: &ProbeSample) {
        self.probes.push_back(*sample);
        if self.probes.len() > KEPT_PROBES {
            self.probes.pop_front();
        }
    }

    /// Takes axis positions; gives a synchronisation move when it is over.
    pub fn axes(&mut self, sample: &AxisSample) -> Option<SyncMove> {
        self.axes.push_back(*sample);
        let horizon_s = sample.time_s - LONGEST_S - 2.0;
        while self.axes.front().is_some_and(|old| old.time_s < horizon_s) {
            self.axes.pop_front();
        }
        while self.probes.front().is_some_and(|old| old.time_s < horizon_s - LARGEST_DELAY_S) {
            self.probes.pop_front();
        }
        let now_s = sample.time_s;
        let (next, over) = self.state.after(now_s, &sample.position);
        self.state = next;
        let (began_s, axis, stroke_mm) = over?;
        let seen = self.delays(axis, began_s - 0.5 * STAND_S, now_s - 0.5 * STAND_S);
        Some(SyncMove { time_s: began_s, axis, stroke_mm, seen })
    }

    fn delays(&self, axis: Joint, from_s: f64, to_s: f64) -> Vec<SyncMoveDelay> {
        let path: Vec<(f64, f64)> =
            self.axes.iter().map(|sample| (sample.time_s, sample.position[axis])).collect();
        let mut channels: Vec<u16> = self.probes.iter().map(|sample| sample.channel).collect();
        channels.sort_unstable();
        channels.dedup();
        let readings = |channel| -> Vec<(f64, f64)> {
            self.probes
                .iter()
                .filter(|sample| sample.channel == channel && sample.value_mm.is_finite())
                .map(|sample| (sample.time_s, sample.value_mm))
                .filter(|(time_s, _)| (from_s..to_s).contains(time_s))
                .collect()
        };
        channels.into_iter().filter_map(|channel| fit(channel, &readings(channel), &path)).collect()
    }
}

impl State {
    /// The state after a sample; with it begin, axis and stroke of a synchronisation move that is over.
    fn after(self, now_s: f64, position: &AxisValues<f64>) -> (Self, Option<(f64, Joint, f64)>) {
        let again = Self::Standing { at: *position, since_s: now_s };
        match self {
            Self::Moving => (again, None),
            Self::Standing { at, since_s } => match moved(&at, position) {
                Moved::None => (self, None),
                Moved::One(axis, _) if now_s - since_s >= STAND_S => {
                    let (axis, farthest_mm) = (Some(axis), 0.0);
                    (Self::Stroking { at, began_s: now_s, axis, farthest_mm, back_since_s: None }, None)
                }
                Moved::One(..) | Moved::Other => (again, None),
            },
            Self::Stroking { at, began_s, axis, farthest_mm, back_since_s } => {
                let late = now_s - began_s > LONGEST_S;
                match (moved(&at, position), axis) {
                    (Moved::None, Some(letter)) => {
                        let since_s = back_since_s.unwrap_or(now_s);
                        if now_s - since_s < STAND_S {
                            let back_since_s = Some(since_s);
                            return (Self::Stroking { at, began_s, axis, farthest_mm, back_since_s }, None);
                        }
                        let seen = farthest_mm >= STROKE_MM.0;
                        (Self::Standing { at, since_s }, seen.then_some((began_s, letter, farthest_mm)))
                    }
                    (Moved::One(letter, by_mm), Some(known))
                        if letter == known && !late && by_mm <= STROKE_MM.1 =>
                    {
                        let farthest_mm = farthest_mm.max(by_mm);
                        (Self::Stroking { at, began_s, axis, farthest_mm, back_since_s: None }, None)
                    }
                    _ => (again, None),
                }
            }
        }
    }
}

enum Moved {
    None,
    /// One linear axis, by so much, mm.
    One(Joint, f64),
    Other,
}

fn moved(from: &AxisValues<f64>, to: &AxisValues<f64>) -> Moved {
    let still = |letter: Joint| if letter.is_rotary() { STILL.1 } else { STILL.0 };
    let mut away = Joint::ALL.into_iter().filter(|&letter| (to[letter] - from[letter]).abs() > still(letter));
    match (away.next(), away.next()) {
        (None, _) => Moved::None,
        (Some(letter), None) if !letter.is_rotary() => Moved::One(letter, (to[letter] - from[letter]).abs()),
        _ => Moved::Other,
    }
}

/// Fits offset, gain and delay; `None` when the channel does not see the synchronisation move.
fn fit(channel: u16, readings: &[(f64, f64)], path: &[(f64, f64)]) -> Option<SyncMoveDelay> {
    if readings.len() < 30 || path.len() < 10 {
        return None;
    }
    // The same readings for every delay, or the sums could not be compared; behind its end the path stands.
    let first_s = path.first()?.0;
    let known = |(t, _): &&(f64, f64)| t - LARGEST_DELAY_S > first_s;
    let readings: Vec<(f64, f64)> = readings.iter().filter(known).copied().collect();
    let steps = (LARGEST_DELAY_S / COARSE_S) as i32;
    let squares = |delay_s: f64| line_fit(&readings, path, delay_s).map_or(f64::INFINITY, |line| line.square);
    let coarse = (-steps..=steps)
        .map(|k| f64::from(k) * COARSE_S)
        .map(|delay_s| (squares(delay_s), delay_s))
        .min_by(|a, b| a.0.total_cmp(&b.0))?
        .1;
    let delay_s = golden(coarse - COARSE_S, coarse + COARSE_S, &squares);
    let line = line_fit(&readings, path, delay_s)?;
    let n = readings.len() as f64;
    let variance = line.square / (n - 3.0);
    let explained = 1.0 - line.square / line.total;
    if line.gain.abs() < LEAST_GAIN || explained < LEAST_SHARE {
        return None;
    }
    // S(τ) ≈ S_min + ½ S'' (τ − τ_min)²: u² = 2 σ²/S''. The step spans several samples of the axes, or their corners would count.
    let h = 0.5 * COARSE_S.max(path_step_s(path));
    let curvature = (squares(delay_s + h) + squares(delay_s - h) - 2.0 * line.square) / (h * h);
    // Neighbouring residuals are alike where the axes are interpolated: fewer independent readings [AR(1)].
    let correlation = ((1.0 + line.correlation) / (1.0 - line.correlation)).max(1.0);
    let u_s = (2.0 * variance * correlation / curvature).sqrt();
    u_s.is_finite().then_some(SyncMoveDelay {
        channel,
        delay_s,
        u_s,
        gain: line.gain,
        rms_mm: variance.sqrt(),
    })
}

fn path_step_s(path: &[(f64, f64)]) -> f64 {
    (path[path.len() - 1].0 - path[0].0) / (path.len() - 1) as f64
}

struct LineFit {
    gain: f64,
    /// Sum of squares left, and about the mean before, mm².
    square: f64,
    total: f64,
    /// Correlation of neighbouring residuals.
    correlation: f64,
}

/// Least squares of p = a + g·x(t − τ).
fn line_fit(readings: &[(f64, f64)], path: &[(f64, f64)], delay_s: f64) -> Option<LineFit> {
    let mut at = 0;
    let pairs: Option<Vec<(f64, f64)>> = readings
        .iter()
        .map(|&(t, p)| {
            let t = t - delay_s;
            while at + 2 < path.len() && path[at + 1].0 < t {
                at += 1;
            }
            let ((t0, x0), (t1, x1)) = (path[at], path[at + 1]);
            // The axis stands where the path begins and ends.
            let s = ((t - t0) / (t1 - t0)).clamp(0.0, 1.0);
            Some((x0 + s * (x1 - x0), p))
        })
        .collect();
    let pairs = pairs?;
    let n = pairs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / n;
    let (mean_x, mean_p) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let (xx, xp, pp) = pairs.iter().fold((0.0, 0.0, 0.0), |(xx, xp, pp), (x, p)| {
        let (dx, dp) = (x - mean_x, p - mean_p);
        (xx + dx * dx, xp + dx * dp, pp + dp * dp)
    });
    if xx <= 0.0 || pp <= 0.0 {
        return None;
    }
    let gain = xp / xx;
    let left: Vec<f64> = pairs.iter().map(|(x, p)| p - mean_p - gain * (x - mean_x)).collect();
    let square: f64 = left.iter().map(|e| e * e).sum();
    let correlation =
        left.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / square.max(f64::MIN_POSITIVE);
    Some(LineFit { gain, square, total: pp, correlation: correlation.clamp(0.0, 0.99) })
}

/// The least of a function with one valley between a and b, to a millionth of their distance.
fn golden(mut a: f64, mut b: f64, value: &dyn Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut at_c, mut at_d) = (value(c), value(d));
    for _ in 0..30 {
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - ratio * (b - a);
            at_c = value(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + ratio * (b - a);
            at_d = value(d);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Three strokes of 0.2 mm there and back in 0.2 s each after `begin_s`, with soft ends.
    fn stroke_mm(t_s: f64, begin_s: f64) -> f64 {
        let phase = (t_s - begin_s) / 0.2;
        if !(0.0..6.0).contains(&phase) {
            return 0.0;
        }
        let s = phase.fract();
        let soft = s * s * (3.0 - 2.0 * s);
        0.2 * if (phase as i32) % 2 == 0 { soft } else { 1.0 - soft }
    }

    /// Synchronisation moves at 2 s and 12 s, C turning in between; axes at `rate_hz`, probes at 1 kHz and late by `late_s`.
    fn run(rate_hz: f64, late_s: [f64; 3], seed: u64) -> Vec<SyncMove> {
        let x_mm = |t: f64| 3.0 + stroke_mm(t, 2.0) + stroke_mm(t, 12.0);
        let c_rad = |t: f64| (t - 5.0).clamp(0.0, 5.0);
        let gains = [0.8, -0.4, -0.4];
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut finder, mut found, mut next_axes) = (SyncMoveFinder::default(), Vec::new(), 0.0);
        for k in 0..15_000_u32 {
            let t = f64::from(k) * 1e-3;
            while next_axes <= t {
                let mut position = AxisValues::default();
                (position[Joint::X], position[Joint::C]) = (x_mm(next_axes), c_rad(next_axes));
                found.extend(finder.axes(&AxisSample {
                    time_s: next_axes,
                    position,
                    ..AxisSample::default()
                }));
                next_axes += 1.0 / rate_hz;
            }
            for channel in 0..3_u16 {
                let (late_s, gain) = (late_s[usize::from(channel)], gains[usize::from(channel)]);
                let noise: f64 = StandardNormal.sample(&mut rng);
                let value_mm = gain * x_mm(t - late_s) + 0.3e-3 * noise;
                finder.probe(&ProbeSample { channel, time_s: t, value_mm, ..ProbeSample::default() });
            }
        }
        found
    }

    #[test]
    fn the_delay_of_every_channel_is_found_at_both_ends_to_what_its_uncertainty_says() {
        let late_s = [0.0007, -0.004, 0.0312];
        let (mut worst, mut largest_u) = (0.0f64, 0.0f64);
        for (seed, rate_hz) in [(1, 125.0), (2, 200.0), (3, 60.0), (4, 125.0)] {
            let sync_moves = run(rate_hz, late_s, seed);
            assert_eq!(sync_moves.len(), 2, "{sync_moves:?}");
            for sync_move in sync_moves {
                assert_eq!((sync_move.axis, sync_move.seen.len()), (Joint::X, 3));
                for seen in sync_move.seen {
                    let error_s = seen.delay_s - late_s[usize::from(seen.channel)];
                    worst = worst.max(error_s.abs() / seen.u_s);
                    largest_u = largest_u.max(seen.u_s);
                    assert!((seen.gain.abs() - [0.8, 0.4, 0.4][usize::from(seen.channel)]).abs() < 0.01);
                }
            }
        }
        // 24 delays; docs/design/protocols.md §4.3 speaks of 20 µs.
        assert!(worst < 4.0 && largest_u < 60e-6, "worst {worst} u, largest u {largest_u}");
    }

    #[test]
    fn a_cycle_without_strokes_has_no_sync_move() {
        let mut finder = SyncMoveFinder::default();
        for k in 0..4000_u32 {
            let t = f64::from(k) * 0.005;
            let mut position = AxisValues::default();
            // The machine goes from pose to pose, and once 0.2 mm further without coming back.
            position[Joint::X] = 10.0 * (t / 2.0).floor() + if t > 15.0 { 0.2 } else { 0.0 };
            position[Joint::C] = 0.1 * (t / 2.0).floor();
            let found = finder.axes(&AxisSample { time_s: t, position, ..AxisSample::default() });
            assert_eq!(found, None);
        }
    }
}
