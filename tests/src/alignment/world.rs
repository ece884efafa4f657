//! A world that shows its time: what every device shows says when it was taken.
//!
//! First and last 5 s: a synchronisation move of X and standing. In between C turns at 3600°/min, X stands, and the probes see a
//! sawtooth of 20 mm/s, so that a value gives the time to some µs within a period.

use trunnion_core::{AxisValues, Joint};
use trunnion_hil_sim::devices::{CycleState, World};

/// C, rad/s: 3600°/min.
pub const OMEGA: f64 = std::f64::consts::TAU * 10.0 / 60.0;
/// Distance of the ball from the axis, mm.
pub const RADIUS_MM: f64 = 150.0;
/// Period of the sawtooth, s, and its height, mm.
const SAW_S: f64 = 0.09;
const SAW_MM: f64 = 1.8;
/// Before and after the turning, s.
pub const MARGIN_S: f64 = 5.0;
const STROKES: (f64, f64, i32) = (1.0, 0.2, 6);
const STROKE_MM: f64 = 0.2;

/// The world; time 0 is the start of the first margin.
pub struct ClockWorld {
    /// Length of all of it, s.
    pub length_s: f64,
}

impl ClockWorld {
    /// True while C turns at constant feed and readings tell their time.
    pub fn shows_time(&self, t_s: f64) -> bool {
        (MARGIN_S..self.length_s - MARGIN_S).contains(&t_s)
    }

    /// When C was there, s.
    pub fn time_of_c(c_rad: f64) -> f64 {
        MARGIN_S + c_rad / OMEGA
    }

    /// When a probe read this, s, nearest to a time known to less than half a period.
    pub fn time_of_reading(value_mm: f64, near_s: f64) -> f64 {
        let phase_s = (value_mm / SAW_MM + 0.5) * SAW_S;
        phase_s + ((near_s - phase_s) / SAW_S).round() * SAW_S
    }

    fn stroke_mm(&self, t_s: f64) -> f64 {
        let (first_s, stroke_s, count) = STROKES;
        let begins = [first_s, self.length_s - MARGIN_S + first_s];
        let phase = |begin_s: f64| (t_s - begin_s) / stroke_s;
        let of = |phase: f64| {
            let s = phase.fract();
            let soft = s * s * (3.0 - 2.0 * s);
            STROKE_MM * if (phase as i32) % 2 == 0 { soft } else { 1.0 - soft }
        };
        begins.into_iter().map(phase).find(|phase| (0.0..f64::from(count)).contains(phase)).map_or(0.0, of)
    }
}

impl World for ClockWorld {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        let mut axes = AxisValues::default();
        axes[Joint::X] = 100.0 + self.stroke_mm(t_s);
        axes[Joint::C] = OMEGA * (t_s.clamp(MARGIN_S, self.length_s - MARGIN_S) - MARGIN_S);
        axes
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        [self.bar_reading_mm(t_s); 3]
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        match self.shows_time(t_s) {
            true => SAW_MM * ((t_s / SAW_S).rem_euclid(1.0) - 0.5),
            false => self.stroke_mm(t_s),
        }
    }

    fn temperature_degc(&self, _: f64) -> f64 {
        20.0
    }

    fn cycle(&self, t_s: f64) -> CycleState {
        CycleState { program: "alignment".into(), block: 1, running: (0.0..self.length_s).contains(&t_s) }
    }
}
