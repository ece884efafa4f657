//! What a cycle needs of machine and devices before it can be measured.

use crate::{NestCalibration, StandsAt, StaticRules};
use trunnion_core::channel::instrument_channels;
use trunnion_core::{Channel, InstrumentKind};
use trunnion_cycles::Cycle;
use trunnion_cycles::cycle::Motion;
use trunnion_machine::Machine;

/// What is measured and how.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The machine.
    pub machine: Machine,
    /// The cycle.
    pub cycle: Cycle,
    /// Probe directions.
    pub nest: NestCalibration,
    /// Channels of all devices.
    pub channels: Vec<Channel>,
}

impl Plan {
    /// What the channels of the instrument become: the three probes the displacement in the nest, the bar its own reading.
    pub fn calibration(&self) -> NestCalibration {
        match self.cycle.setups[0].instrument {
            InstrumentKind::RTest => self.nest,
            _ => NestCalibration::orthogonal(),
        }
    }

    /// Where the cycle begins; `None` for one that is not measured pose by pose.
    pub fn first_pose(&self) -> Option<StandsAt> {
        let (Motion::Static { settle, .. } | Motion::Line { settle, .. }) = &self.cycle.motion else {
            return None;
        };
        let axes = self.machine.axes().map(|axis| axis.letter).collect();
        let poses = self.cycle.poses(&self.machine)?;
        Some(StandsAt::pose(poses.first()?, axes, &StaticRules::new(*settle)))
    }
}

/// A plan that cannot be measured.
#[derive(Clone, Debug, thiserror::Error)]
pub enum PlanError {
    /// The linear axes cannot follow the ball.
    #[error(
        "machine {machine} cannot bring its tool to the ball with its linear axes; check the machine file"
    )]
    CannotFollow {
        /// Machine name.
        machine: String,
    },
    /// A probe is missing.
    #[error(
        "the cycle measures with {instrument}, but the configuration lacks {needed}; add [[device]] with these roles"
    )]
    NoChannels {
        /// Instrument name.
        instrument: &'static str,
        /// Roles needed.
        needed: &'static str,
    },
    /// Something the service cannot read from its own devices.
    #[error(
        "cycle {cycle} measures with {what}, which is not read live; measure with its own software and bring the points with `trunnion import`"
    )]
    NotLive {
        /// Cycle name.
        cycle: String,
        /// What is not read live.
        what: String,
    },
    /// Two kinds of instrument.
    #[error("cycle {cycle} mixes instruments; measure each instrument in a cycle of its own")]
    MixedInstruments {
        /// Cycle name.
        cycle: String,
    },
}

/// Checks that the configured channels can measure the cycle.
///
/// # Errors
/// When they cannot, or when the machine cannot follow the ball.
pub fn check(plan: &Plan) -> Result<Vec<u16>, PlanError> {
    let kind = plan.cycle.setups[0].instrument;
    if plan.cycle.setups.iter().any(|setup| setup.instrument != kind) {
        return Err(PlanError::MixedInstruments { cycle: plan.cycle.name.clone() });
    }
    let (bar, needed) = match kind {
        InstrumentKind::BallBar => (true, "bar"),
        InstrumentKind::RTest => (false, "probe-1, probe-2, probe-3"),
        other => {
            let cycle = plan.cycle.name.clone();
            return Err(PlanError::NotLive { cycle, what: format!("the instrument {}", other.name()) });
        }
    };
    let instrument = kind.name();
    if let Some(joint) = plan.cycle.named_joint() {
        // Drivers read axes by letter: the angle of C1 would be that of C.
        let (cycle, what) = (plan.cycle.name.clone(), format!("the angle of joint {joint}"));
        return Err(PlanError::NotLive { cycle, what });
    }
    plan.cycle
        .poses(&plan.machine)
        .ok_or_else(|| PlanError::CannotFollow { machine: plan.machine.name.clone() })?;
    instrument_channels(&plan.channels, bar).ok_or(PlanError::NoChannels { instrument, needed })
}

#[cfg(test)]
mod tests {
    use super::{Plan, check};
    use crate::NestCalibration;
    use trunnion_cycles::Cycle;
    use trunnion_machine::shipped;

    #[test]
    fn a_joint_that_no_driver_reads_is_refused_by_name() {
        let text = include_str!("../../../config/cycles/r-test-head-bc-spindle.toml");
        let cycle = Cycle::parse("c.toml", text).unwrap();
        let machine = shipped::machine(&cycle.machine).unwrap();
        let refused =
            check(&Plan { machine, cycle, nest: NestCalibration::orthogonal(), channels: Vec::new() });
        let said = refused.unwrap_err().to_string();
        assert!(said.contains("the angle of joint C1, which is not read live"), "{said}");
    }
}
