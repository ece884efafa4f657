//! How far along its path a step is: u(t) from 0 to 1, with u̇ and ü continuous and at rest at both ends but for the uniform one.
//! rest to rest: u = 10 τ³ − 15 τ⁴ + 6 τ⁵, τ = t/T (minimum jerk: Flash & Hogan, J. Neurosci. 5 (1985) 1688)
//! uniform: u = t/T
//! cruise: speed (1 − cos(π t/r))/2 · v during ramps of r, v between; T = 1/v + r.
//! T duration, s; r ramp, s; v cruising speed, 1/s.

use std::f64::consts::PI;

/// Time law of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Profile {
    Still { duration_s: f64 },
    RestToRest { duration_s: f64 },
    Uniform { duration_s: f64 },
    Cruise { speed_per_s: f64, ramp_s: f64 },
}

/// u, u̇ in 1/s, ü in 1/s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Progress {
    pub u: f64,
    pub u_dot: f64,
    pub u_ddot: f64,
}

impl Profile {
    /// Cruise over a path of this length (rad or mm) at `feed`; a path too short for it is cruised more slowly.
    pub fn cruise(length: f64, feed: f64, ramp_s: f64) -> Self {
        // The ramps together cover v·r, which must not exceed the path.
        let speed_per_s = (feed / length).min(1.0 / ramp_s);
        Self::Cruise { speed_per_s, ramp_s }
    }

    pub fn duration_s(self) -> f64 {
        match self {
            Self::Still { duration_s } | Self::RestToRest { duration_s } | Self::Uniform { duration_s } => {
                duration_s
            }
            Self::Cruise { speed_per_s, ramp_s } => 1.0 / speed_per_s + ramp_s,
        }
    }

    pub fn at(self, t_s: f64) -> Progress {
        match self {
            Self::Still { .. } => Progress { u: 0.0, u_dot: 0.0, u_ddot: 0.0 },
            Self::RestToRest { duration_s } => {
                let tau = (t_s / duration_s).clamp(0.0, 1.0);
                Progress {
                    u: tau.powi(3) * (10.0 - 15.0 * tau + 6.0 * tau * tau),
                    u_dot: 30.0 * tau * tau * (1.0 - tau).powi(2) / duration_s,
                    u_ddot: 60.0 * tau * (1.0 - tau) * (1.0 - 2.0 * tau) / duration_s.powi(2),
                }
            }
            Self::Uniform { duration_s } => {
                Progress { u: (t_s / duration_s).clamp(0.0, 1.0), u_dot: 1.0 / duration_s, u_ddot: 0.0 }
            }
            Self::Cruise { speed_per_s: v, ramp_s: r } => {
                let duration_s = self.duration_s();
                let t_s = t_s.clamp(0.0, duration_s);
                if t_s < r {
                    ramp(t_s, v, r)
                } else if t_s <= duration_s - r {
                    Progress { u: v * (t_s - 0.5 * r), u_dot: v, u_ddot: 0.0 }
                } else {
                    let mirrored = ramp(duration_s - t_s, v, r);
                    Progress { u: 1.0 - mirrored.u, u_dot: mirrored.u_dot, u_ddot: -mirrored.u_ddot }
                }
            }
        }
    }
}

fn ramp(t_s: f64, v: f64, r: f64) -> Progress {
    let phase = PI * t_s / r;
    Progress {
        u: 0.5 * v * (t_s - r / PI * phase.sin()),
        u_dot: 0.5 * v * (1.0 - phase.cos()),
        u_ddot: 0.5 * v * PI / r * phase.sin(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_the_derivatives_and_the_ends_are_at_rest() {
        let profiles = [
            Profile::RestToRest { duration_s: 0.7 },
            Profile::cruise(6.0, 1.5, 0.25),
            Profile::cruise(0.1, 2.0, 0.3), // too short to reach its feed
        ];
        for profile in profiles {
            let (end_s, h) = (profile.duration_s(), 1e-5);
            for k in 1..200 {
                let t = h + (end_s - 2.0 * h) * f64::from(k) / 200.0;
                let (before, here, after) = (profile.at(t - h), profile.at(t), profile.at(t + h));
                assert!(((after.u - before.u) / (2.0 * h) - here.u_dot).abs() < 1e-6, "{profile:?} {t}");
                assert!(
                    ((after.u_dot - before.u_dot) / (2.0 * h) - here.u_ddot).abs() < 1e-2,
                    "{profile:?} {t}"
                );
            }
            let (first, last) = (profile.at(0.0), profile.at(end_s));
            assert!(first.u.abs() < 1e-12 && (last.u - 1.0).abs() < 1e-12, "{first:?} {last:?}");
            assert!(first.u_dot.abs() < 1e-12 && last.u_dot.abs() < 1e-12);
        }
        let cruise = Profile::cruise(6.0, 1.5, 0.25);
        assert!((cruise.at(2.0).u_dot * 6.0 - 1.5).abs() < 1e-12, "the feed is kept between the ramps");
    }
}
