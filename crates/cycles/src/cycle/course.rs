//! What a controller has to do to run a cycle, step by step: the neutral form of an NC program.
//!
//! An R-test's ball and nest (or the bar) are brought together and taken apart with the rotary axes at or near zero, the spindle coming
//! from straight above; on a curve where it begins. In between they stay together: whatever the rotary axes do, the linear axes follow along short straight
//! pieces, because the controller's own tool-point following is off. Where the cycle names the linear axes (lines, grids of X,
//! Y, Z under an interferometer) the way is straight. A pose is approached as [`Cycle::visits`] says, from
//! the side of its pass with an overrun; a sweep runs in and out by half the feed times the ramp.

mod guide;
mod step;

pub use step::{CourseRules, Step};

use super::visit::VisitError;
use super::{Cycle, Leg};
use crate::RunKind;
use guide::Guide;
use trunnion_core::{AxisValues, InstrumentKind, State};
use trunnion_machine::{Axis, Machine};

/// Farther than this from every pose, no one takes a stand for a pose, rad.
const FREE_RAD: f64 = 2.5 / 180.0 * std::f64::consts::PI;
/// Places looked at for standing free of the poses.
const MOST_PLACES: u32 = 36;

impl Cycle {
    /// True when it touches surfaces or balls: that is left to the probing cycles of the controller.
    pub fn touches(&self) -> bool {
        let touching = |kind: InstrumentKind| kind.has_targets() || kind == InstrumentKind::TouchProbe;
        self.setups.iter().any(|setup| touching(setup.instrument) || setup.artefact.is_some())
    }

    /// The steps of the cycle in order.
    ///
    /// # Errors
    /// A cycle that the machine cannot run: axes, reach, travel (overruns and the retracted spindle included); one that
    /// touches surfaces.
    pub fn course(&self, machine: &Machine, rules: &CourseRules) -> Result<Vec<Step>, VisitError> {
        self.has_its_axes(machine)?;
        if self.touches() {
            let what = "it touches surfaces or balls; use the probing cycles of the controller";
            return Err(VisitError::NoCourse { cycle: self.name.clone(), what });
        }
        if self.named_joint().is_some() {
            let what = "programs move X Y Z A B C, and it turns another joint; turn that by hand";
            return Err(VisitError::NoCourse { cycle: self.name.clone(), what });
        }
        let poses = self.visits(machine, &rules.pace)?.states;
        let home = self.home(machine, &poses);
        let mut guide = Guide::new(self, machine, rules, home, &poses)?;
        let mut last: Option<Leg> = None;
        for leg in self.legs() {
            guide.change_to(&leg)?;
            if last.is_some_and(|last| last.round != leg.round) && self.rounds.wait_s > 0.0 {
                guide.wait(self.rounds.wait_s, "rest between two rounds");
            }
            match self.run_kind() {
                RunKind::Static => guide.stand(&leg)?,
                RunKind::OnTheFly => guide.sweep(&leg)?,
            }
            last = Some(leg);
        }
        guide.finish()
    }

    /// Where ball and nest come together: rotary axes at zero, or as near as their travel allows. Who watches the axes would
    /// take standing there for a pose of the cycle, so an upright axis is turned until no pose is near.
    fn home(&self, machine: &Machine, poses: &[State]) -> AxisValues<f64> {
        let rotary = machine.rotary();
        let mut zero = AxisValues::default();
        for axis in &rotary {
            zero[axis.letter] = 0f64.clamp(axis.travel.0, axis.travel.1);
        }
        let upright = |axis: &&&Axis| axis.direction.z.abs();
        let turned = rotary.iter().max_by(|a, b| upright(a).total_cmp(&upright(b)));
        let Some(turned) = turned else { return zero };
        let free = |home: &AxisValues<f64>| {
            let near = |state: &State| {
                let off = |axis: &&Axis| whole_turns_off(state.position[axis.letter] - home[axis.letter]);
                state.velocity == AxisValues::default()
                    && rotary.iter().all(|axis| off(axis).abs() < FREE_RAD)
            };
            !poses.iter().any(near)
        };
        let places = (0..MOST_PLACES).map(|k| {
            let mut home = zero;
            home[turned.letter] = (zero[turned.letter] + FREE_RAD * f64::from(k)).min(turned.travel.1);
            home
        });
        places.into_iter().find(free).unwrap_or(zero)
    }
}

/// Less the whole turns.
fn whole_turns_off(angle_rad: f64) -> f64 {
    angle_rad - (angle_rad / std::f64::consts::TAU).round() * std::f64::consts::TAU
}
