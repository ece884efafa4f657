//! How high the free spindle goes: what stands on the table is met from above alone.

use super::{Guide, Place};
use crate::cycle::visit::VisitError;
use crate::cycle::{Leg, Motion};
use nalgebra::Point3;
use trunnion_core::{AxisValues, InstrumentKind, State};
use trunnion_machine::JointErrors;

impl Guide<'_> {
    /// The free spindle over a setup: higher by the clearance than every ball of the table, every place where it comes down or goes
    /// up, and, as a grid plate stands upright under its poses, every pose over one.
    pub(super) fn height_mm(&self, setup: usize, poses: &[State]) -> Result<f64, VisitError> {
        let mut places = Vec::new();
        let legs = self.cycle.legs();
        for stay in legs.chunk_by(|a, b| a.setup == b.setup).filter(|stay| stay[0].setup == setup) {
            places.push(self.start(&stay[0])?.1);
            places.extend(self.last(&stay[stay.len() - 1])?);
        }
        let plate = self.cycle.setups[setup].instrument == InstrumentKind::CrossGrid;
        let over = poses.iter().filter(|state| plate && state.setup == setup).map(|state| state.position);
        let tips = places.iter().copied().chain(over).map(|at| self.tip_in_machine(setup, &at).z);
        let own_mm = tips.fold(f64::NEG_INFINITY, f64::max);
        let every_ball = |at: &AxisValues<f64>| {
            let ball = |other: usize| self.ball_in_machine(other, at).z;
            (0..self.cycle.setups.len()).map(ball).fold(f64::NEG_INFINITY, f64::max)
        };
        let ball_mm = places.iter().map(every_ball).fold(f64::NEG_INFINITY, f64::max);
        let asked_mm = own_mm.max(ball_mm) + self.rules.clearance_mm;
        if !self.cycle.names_linear() {
            return Ok(asked_mm);
        }
        // It never comes down onto a ball that stands next to its volume: over that, what the travel leaves.
        let short_mm = |at: &AxisValues<f64>| Ok(self.beyond_mm(&self.raised(setup, at, asked_mm)?));
        let short_mm: Result<Vec<f64>, VisitError> = places.iter().map(short_mm).collect();
        let left_mm = asked_mm - short_mm?.into_iter().fold(0.0, f64::max);
        Ok(left_mm.max(own_mm + self.rules.clearance_mm).max(ball_mm))
    }

    /// Where the cycle leaves a pass: the end of its own way; `None` where it goes back to where it began.
    fn last(&self, leg: &Leg) -> Result<Option<AxisValues<f64>>, VisitError> {
        let place = match &self.cycle.motion {
            Motion::Path { .. } => self.ends(leg).map(|(_, ended)| ended),
            _ if self.cycle.names_linear() => {
                let stations = self.cycle.stations(self.machine, leg.setup, leg.pass);
                stations.last().map(|station| Place::asked(station.asked))
            }
            _ => None,
        };
        place.map(|place| self.axes_at(leg.setup, &place, &AxisValues::default())).transpose()
    }

    /// How far the linear axes are beyond their travel, mm.
    fn beyond_mm(&self, at: &AxisValues<f64>) -> f64 {
        let linear = self.machine.axes().filter(|axis| !axis.is_rotary());
        let beyond =
            linear.map(|axis| (axis.travel.0 - at[axis.letter]).max(at[axis.letter] - axis.travel.1));
        beyond.fold(0.0, f64::max)
    }

    /// Straight above a place, at the height of the free spindle.
    pub(super) fn above(&self, setup: usize, at: &AxisValues<f64>) -> Result<AxisValues<f64>, VisitError> {
        let above = self.raised(setup, at, self.heights_mm[setup])?;
        self.cycle.within_travel(self.machine, &above)?;
        Ok(above)
    }

    /// Straight above a place with the tip at this height of the machine, or where it is when that is higher.
    fn raised(
        &self,
        setup: usize,
        at: &AxisValues<f64>,
        height_mm: f64,
    ) -> Result<AxisValues<f64>, VisitError> {
        let none = JointErrors::default();
        let mut place = self.machine.machine_from_tool(at, &none) * Point3::origin();
        place.z += (height_mm - self.tip_in_machine(setup, at).z).max(0.0);
        let place_in_table = self.machine.machine_from_table(at, &none).inverse() * place;
        self.machine.follow(at, &place_in_table).ok_or_else(|| self.cycle.cannot_follow(self.machine, setup))
    }
}
