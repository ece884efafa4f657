//! Which samples of a cycle on the fly count.

use super::pace::Motion;
use crate::interval::USUAL_GAP_S;
use trunnion_cycles::Cycle;
use trunnion_cycles::cycle::{self, Sweep};

/// A speed or acceleration is off its limit when it is so by this many standard uncertainties.
const SURE: f64 = 3.0;
/// Slower than this part of the slowest feed is standing.
const STANDING: f64 = 0.05;
/// A pass that goes on after a hold does so from where it was, rad; also the share of its end that a pass may lack.
pub(super) const GOES_ON_RAD: f64 = 0.17;

/// Rules of a cycle on the fly.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRules {
    /// First and last angle, rad; samples outside are the run-in and are left out.
    pub from_to_rad: (f64, f64),
    /// The passes of the cycle in order ([`trunnion_cycles::Cycle::sweeps`]).
    pub passes: Vec<Sweep>,
    /// Largest difference of the velocity from a feed, as a fraction of it.
    pub feed_tolerance: f64,
    /// Largest acceleration that counts as constant feed, rad/s².
    pub acceleration_limit: f64,
    /// Points a second after averaging; 0 keeps every sample.
    pub points_per_s: f64,
    /// Longest distance of two samples in one point, s; longer for probes that are read more slowly.
    pub sample_gap_s: f64,
}

impl SweepRules {
    /// Usual rules for a cycle on the fly; `None` for one at rest.
    pub fn of(cycle: &Cycle) -> Option<Self> {
        let from_to_rad = match &cycle.motion {
            cycle::Motion::OnTheFly { from_to_rad, .. } | cycle::Motion::Path { from_to_rad, .. } => {
                *from_to_rad
            }
            cycle::Motion::Static { .. } | cycle::Motion::Line { .. } => return None,
        };
        let passes = cycle.sweeps();
        let slowest = slowest(&passes);
        Some(Self {
            from_to_rad,
            passes,
            feed_tolerance: 0.05,
            acceleration_limit: if slowest.is_finite() { slowest } else { 1.0 },
            points_per_s: 100.0,
            sample_gap_s: USUAL_GAP_S,
        })
    }

    /// Lowest and highest angle, rad.
    pub(super) fn span(&self) -> (f64, f64) {
        (self.from_to_rad.0.min(self.from_to_rad.1), self.from_to_rad.0.max(self.from_to_rad.1))
    }

    /// True inside the span.
    pub(super) fn holds(&self, angle: f64) -> bool {
        let (low, high) = self.span();
        (low..=high).contains(&angle)
    }

    /// True when the machine goes the way of a pass; standing and the way back from one are not asked for.
    pub(super) fn is_asked(&self, motion: &Motion) -> bool {
        let velocity = motion.pace.0;
        velocity.abs() > STANDING * slowest(&self.passes)
            && self.passes.iter().any(|pass| pass.feed_rad_per_s * velocity > 0.0)
    }

    /// The signed feed at which a sample was taken, if it counts.
    pub(super) fn feed_of(&self, motion: &Motion) -> Option<f64> {
        let ((velocity, acceleration), (u_velocity, u_acceleration)) = (motion.pace, motion.u_pace);
        let steady = acceleration.abs() <= self.acceleration_limit + SURE * u_acceleration;
        let is_at =
            |feed: &f64| (velocity - feed).abs() <= self.feed_tolerance * feed.abs() + SURE * u_velocity;
        let feeds = self.passes.iter().map(|pass| pass.feed_rad_per_s).filter(is_at);
        let nearest = feeds.min_by(|a, b| (velocity - a).abs().total_cmp(&(velocity - b).abs()));
        nearest.filter(|_| steady)
    }
}

fn slowest(passes: &[Sweep]) -> f64 {
    passes.iter().map(|pass| pass.feed_rad_per_s.abs()).fold(f64::INFINITY, f64::min)
}
