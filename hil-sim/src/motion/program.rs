//! What the machine is commanded to do.

use std::fmt;
use std::sync::Arc;
use thiserror::Error;
use trunnion_core::{AxisValues, Joint};

/// A program: where it starts and its steps. Compile it with [`super::Trajectory::compile`].
#[derive(Debug, Clone)]
pub struct Program {
    /// Axis positions before the first step, mm and rad.
    pub start: AxisValues<f64>,
    /// Steps in their order; each begins where the one before ended.
    pub steps: Vec<Step>,
}

/// One step of a program.
#[derive(Debug, Clone)]
pub enum Step {
    /// All axes go straight to the target and start and arrive together, at rest.
    Move {
        /// Where, mm and rad.
        target: AxisValues<f64>,
        /// How long it takes, s.
        duration_s: f64,
    },
    /// All axes go straight to a position at constant speed: a block that the controller runs without stopping before or after it.
    Line {
        /// Where to, mm and rad.
        target: AxisValues<f64>,
        /// How long it takes, s.
        duration_s: f64,
    },
    /// Rotary axes go straight to the target while the linear axes keep the ball in the nest; from rest to rest.
    Carry {
        /// Where the rotary axes go, rad; the linear entries are not used.
        target: AxisValues<f64>,
        /// How long it takes, s.
        duration_s: f64,
        /// Where the linear axes are.
        follow: Follow,
    },
    /// All axes are at rest.
    Dwell {
        /// How long, s.
        duration_s: f64,
    },
    /// One axis turns at constant feed between two short ramps while the others follow.
    Sweep {
        /// The axis.
        axis: Joint,
        /// Where it starts: where the step before has left it, rad (mm for a linear axis).
        from: f64,
        /// Where it ends, rad (mm for a linear axis).
        to: f64,
        /// Speed between the ramps, rad/s (mm/s for a linear axis), positive.
        feed: f64,
        /// Time of each ramp, s; 0 is not allowed.
        ramp_s: f64,
        /// Where the other axes are.
        follow: Follow,
    },
}

/// Where the followers are, given where all axes are: a function of the driven axes that fills in the others.
#[derive(Clone)]
pub struct Follow(Arc<FollowFn>);

type FollowFn = dyn Fn(&AxisValues<f64>) -> AxisValues<f64> + Send + Sync;

impl Follow {
    /// Follow by this function. It must be smooth, must not depend on the followers' own values, and must leave the
    /// driven axes as they are.
    pub fn new(follow: impl Fn(&AxisValues<f64>) -> AxisValues<f64> + Send + Sync + 'static) -> Self {
        Self(Arc::new(follow))
    }

    /// The other axes are at rest.
    pub fn none() -> Self {
        Self::new(|axes| *axes)
    }

    pub(super) fn apply(&self, axes: &AxisValues<f64>) -> AxisValues<f64> {
        (self.0)(axes)
    }
}

impl fmt::Debug for Follow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Follow")
    }
}

/// Why a program cannot be run.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ProgramError {
    /// A time or feed that no machine can keep.
    #[error("step {step}: {what} = {found}; it must be finite and above 0")]
    NotPositive {
        /// Index of the step.
        step: usize,
        /// Which number.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// A position that is no number.
    #[error("step {step}: position of {axis} is not finite")]
    NotFinite {
        /// Index of the step.
        step: usize,
        /// The axis.
        axis: Joint,
    },
    /// A step would begin with a jump.
    #[error(
        "step {step} begins with {axis} = {begins} where the step before ended at {ended}; move there first"
    )]
    Jump {
        /// Index of the step.
        step: usize,
        /// The axis.
        axis: Joint,
        /// Where the step begins, mm or rad.
        begins: f64,
        /// Where the step before ended, mm or rad.
        ended: f64,
    },
}
