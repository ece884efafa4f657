//! Laying out a course: where to go, how to stay together on the way.

mod height;

use super::super::visit::{Sweeping, VisitError};
use super::super::{Cycle, Leg, Motion};
use super::step::{CourseRules, Step};
use crate::RunKind;
use nalgebra::{Point3, Vector3};
use trunnion_core::{AxisValues, InstrumentKind, Joint, Slot, State};
use trunnion_machine::{JointErrors, Machine};

/// Shortest dwell before a sweep, s: it separates the passes of a recording.
const PAUSE_S: f64 = 1.0;
/// One stroke of the synchronisation move takes this long, s.
const STROKE_S: f64 = 0.2;
/// Pieces of a path from which its curvature is first judged.
const FIRST_PIECES: usize = 16;
/// Most pieces of one path.
const MOST_PIECES: usize = 1_000_000;
/// Travel that counts as motion, mm or rad.
const STANDSTILL: f64 = 1e-9;

/// Where the cycle is on its way: what the positions of all axes follow from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    /// Rotary axes, and the linear ones where the cycle names them, mm and rad; not used on a curve.
    asked: AxisValues<f64>,
    /// Angle on a curve, rad.
    angle_rad: f64,
}

impl Place {
    fn asked(asked: AxisValues<f64>) -> Self {
        Self { asked, angle_rad: 0.0 }
    }

    fn between(&self, to: &Self, u: f64) -> Self {
        let asked = &self.asked;
        Self {
            asked: AxisValues::from_fn(|letter| asked[letter] + (to.asked[letter] - asked[letter]) * u),
            angle_rad: self.angle_rad + (to.angle_rad - self.angle_rad) * u,
        }
    }

    fn is(&self, other: &Self) -> bool {
        (self.angle_rad - other.angle_rad).abs() < STANDSTILL
            && Slot::ALL
                .into_iter()
                .all(|letter| (self.asked[letter] - other.asked[letter]).abs() < STANDSTILL)
    }
}

/// Ball and nest together.
#[derive(Clone, Copy, Debug)]
struct Joined {
    setup: usize,
    place: Place,
    /// All axes there.
    at: AxisValues<f64>,
}

/// Lays out a course.
pub(super) struct Guide<'a> {
    cycle: &'a Cycle,
    machine: &'a Machine,
    rules: &'a CourseRules,
    /// Where the rotary axes stand while ball and nest come together and part.
    home: AxisValues<f64>,
    /// Of the free spindle's tip over each setup, machine Z, mm.
    heights_mm: Vec<f64>,
    steps: Vec<Step>,
    joined: Option<Joined>,
    /// Setups that have been mounted and stay so.
    fitted: Vec<usize>,
}

impl<'a> Guide<'a> {
    /// At the start of a cycle that visits `poses`; ball and nest come together with the rotary axes at `home`.
    pub fn new(
        cycle: &'a Cycle,
        machine: &'a Machine,
        rules: &'a CourseRules,
        home: AxisValues<f64>,
        poses: &[State],
    ) -> Result<Self, VisitError> {
        let (steps, fitted) = (Vec::new(), Vec::new());
        let mut guide =
            Self { cycle, machine, rules, home, heights_mm: Vec::new(), steps, joined: None, fitted };
        let heights_mm = (0..cycle.setups.len()).map(|setup| guide.height_mm(setup, poses));
        guide.heights_mm = heights_mm.collect::<Result<_, _>>()?;
        Ok(guide)
    }

    pub fn wait(&mut self, seconds: f64, reason: &'static str) {
        self.steps.push(Step::Wait { seconds, reason });
    }

    /// All steps.
    pub fn finish(mut self) -> Result<Vec<Step>, VisitError> {
        self.part()?;
        Ok(self.steps)
    }

    /// Brings a leg's ball and nest together unless they are.
    pub fn change_to(&mut self, leg: &Leg) -> Result<(), VisitError> {
        let setup = leg.setup;
        if self.joined.is_some_and(|joined| joined.setup == setup) {
            return Ok(());
        }
        self.part()?;
        let (place, at) = self.start(leg)?;
        self.steps.push(Step::Above { at: self.above(setup, &at)? });
        let bar = self.cycle.setups[setup].instrument == InstrumentKind::BallBar;
        let new = !self.fitted.contains(&setup);
        if new {
            let all = 0..self.cycle.setups.len();
            let setups = if self.cycle.rounds.interleave { all.collect() } else { vec![setup] };
            self.fitted.clone_from(&setups);
            self.steps.push(Step::Fit { setups });
        }
        self.steps.push(Step::Join { setup, at, attended: bar || new });
        self.joined = Some(Joined { setup, place, at });
        self.sync_move();
        Ok(())
    }

    /// Back to where they came together, unless the way is the cycle's own, and up.
    fn part(&mut self) -> Result<(), VisitError> {
        let Some(joined) = self.joined else { return Ok(()) };
        let own_way = self.cycle.names_linear() || matches!(self.cycle.motion, Motion::Path { .. });
        if !own_way {
            self.transfer(&Place::asked(self.home))?;
        }
        self.sync_move();
        let at = self.joined.map_or(joined.at, |joined| joined.at);
        self.steps.push(Step::Part { setup: joined.setup, to: self.above(joined.setup, &at)? });
        self.joined = None;
        Ok(())
    }

    /// Where a setup's ball and nest come together before a pass.
    fn start(&self, leg: &Leg) -> Result<(Place, AxisValues<f64>), VisitError> {
        let place = match &self.cycle.motion {
            Motion::Path { .. } => self.ends(leg).map_or(Place::asked(self.home), |(began, _)| began),
            _ if self.cycle.names_linear() => {
                let first = self
                    .cycle
                    .stations(self.machine, leg.setup, leg.pass)
                    .first()
                    .map(|station| station.asked);
                Place::asked(first.unwrap_or_default())
            }
            _ => Place::asked(self.home),
        };
        let at = self.axes_at(leg.setup, &place, &AxisValues::default())?;
        Ok((place, at))
    }

    /// One pass of a grid or a line, read at rest.
    pub fn stand(&mut self, leg: &Leg) -> Result<(), VisitError> {
        let Some(settle) = self.cycle.settle() else { return Ok(()) };
        let seconds = self.rules.dwell_of(settle.window_s);
        let mut before: Option<AxisValues<f64>> = None;
        for station in self.cycle.stations(self.machine, leg.setup, leg.pass) {
            let line = self.cycle.before_line(leg.setup, leg.pass, &station.asked);
            let mut beyond = line.filter(|_| before.is_none()).unwrap_or(station.asked);
            for axis in self.cycle.grid(self.machine) {
                let letter = axis.letter;
                let goes_back =
                    |last: AxisValues<f64>| (station.asked[letter] - last[letter]) * leg.pass < 0.0;
                if before.is_none_or(goes_back) {
                    beyond[letter] -= leg.pass * axis.overrun().unwrap_or(0.0);
                }
            }
            self.transfer(&Place::asked(beyond))?;
            self.transfer(&Place::asked(station.asked))?;
            self.steps.push(Step::Dwell { seconds });
            before = Some(station.asked);
        }
        Ok(())
    }

    /// One pass at one feed.
    pub fn sweep(&mut self, leg: &Leg) -> Result<(), VisitError> {
        let Some((began, ends)) = self.ends(leg) else { return Ok(()) };
        let Some(Sweeping { turning, feed, .. }) = self.cycle.sweeping(leg) else { return Ok(()) };
        self.transfer(&began)?;
        self.wait(PAUSE_S, "dwell before a pass");
        let near = self.joined.map_or_else(AxisValues::default, |joined| joined.at);
        let path = self.pieces(leg.setup, (&began, &ends), &near, self.rules.chord_mm)?;
        let travel =
            turning.map_or(ends.angle_rad - began.angle_rad, |axis| ends.asked[axis] - began.asked[axis]);
        let piece_s = travel.abs() / feed / path.len() as f64;
        let at = path.last().copied().unwrap_or(near);
        self.steps.push(Step::Sweep { turning, feed: feed * travel.signum(), piece_s, ends: path });
        self.joined = Some(Joined { setup: leg.setup, place: ends, at });
        Ok(())
    }

    /// Where a pass on the fly begins and ends, run-in and run-out included; `None` at rest.
    fn ends(&self, leg: &Leg) -> Option<(Place, Place)> {
        let Sweeping { from_to_rad: (from, to), feed, .. } = self.cycle.sweeping(leg)?;
        let (first, last) = if leg.pass < 0.0 { (to, from) } else { (from, to) };
        let run_in = 0.5 * feed * self.rules.pace.ramp_s * (last - first).signum();
        let at = |angle_rad: f64| match self.cycle.rotary_at(angle_rad) {
            Some(asked) => Place::asked(asked),
            None => Place { asked: AxisValues::default(), angle_rad },
        };
        Some((at(first - run_in), at(last + run_in)))
    }

    /// On the fly only: strokes along the linear axis in which the instrument sees most, X for an R-test, along the bar for a
    /// ball bar, along a grating of a plate.
    fn sync_move(&mut self) {
        let Some(Joined { setup, at, .. }) =
            self.joined.filter(|_| self.cycle.run_kind() == RunKind::OnTheFly)
        else {
            return;
        };
        let seen = match self.cycle.setups[setup].instrument {
            InstrumentKind::BallBar => self.tip_in_machine(setup, &at) - self.ball_in_machine(setup, &at),
            InstrumentKind::CrossGrid => {
                let table = self.machine.machine_from_table(&at, &JointErrors::default()).rotation;
                table * self.cycle.setups[setup].gratings()[0].into_inner()
            }
            _ => Vector3::x(),
        };
        let shown =
            |letter: &Joint| self.machine.axis(*letter).map_or(-1.0, |axis| axis.direction.dot(&seen).abs());
        let axis = Joint::LINEAR
            .into_iter()
            .reduce(|best, letter| if shown(&letter) > shown(&best) { letter } else { best })
            .unwrap_or(Joint::X);
        let mut there = at;
        there[axis] += self.rules.stroke_mm;
        let pieces = (0..self.rules.strokes).flat_map(|_| [(there, STROKE_S), (at, STROKE_S)]).collect();
        self.wait(PAUSE_S, "dwell before the synchronisation move");
        self.steps.push(Step::SyncMove { axis, pieces });
        self.wait(PAUSE_S, "dwell after the synchronisation move");
    }

    /// To another place, joined.
    fn transfer(&mut self, to: &Place) -> Result<(), VisitError> {
        let Some(Joined { setup, place, mut at }) = self.joined.filter(|joined| !joined.place.is(to)) else {
            return Ok(());
        };
        let mut pieces = Vec::new();
        for end in self.pieces(setup, (&place, to), &at, self.rules.transfer_chord_mm)? {
            pieces.push((end, self.seconds(&at, &end)));
            at = end;
        }
        self.steps.push(Step::Transfer { pieces });
        self.joined = Some(Joined { setup, place: *to, at });
        Ok(())
    }

    /// Ends of equal pieces of the way between two places whose tool point stays within `chord_mm` of the true path over the
    /// table. `near`: where the axes stand.
    fn pieces(
        &self,
        setup: usize,
        (from, to): (&Place, &Place),
        near: &AxisValues<f64>,
        chord_mm: f64,
    ) -> Result<Vec<AxisValues<f64>>, VisitError> {
        // Positions at the halves of `count` pieces, each near the one before.
        let halves = |count: usize| -> Result<Vec<AxisValues<f64>>, VisitError> {
            let mut halves = vec![self.axes_at(setup, from, near)?];
            for k in 1..=2 * count {
                let place = from.between(to, k as f64 / (2 * count) as f64);
                halves.push(self.axes_at(setup, &place, &halves[k - 1])?);
            }
            Ok(halves)
        };
        let sagitta_mm = |halves: &[AxisValues<f64>]| {
            let of_piece = |k: usize| {
                let (begins, ends) = (&halves[k], &halves[k + 2]);
                let straight = AxisValues::from_fn(|letter| 0.5 * (begins[letter] + ends[letter]));
                (self.tip_in_table(setup, &straight) - self.tip_in_table(setup, &halves[k + 1])).norm()
            };
            (0..halves.len() - 2).step_by(2).map(of_piece).fold(0.0, f64::max)
        };
        // The sagitta falls with the square of the count.
        let needed = FIRST_PIECES as f64 * (sagitta_mm(&halves(FIRST_PIECES)?) / chord_mm).sqrt();
        let mut count = (needed.ceil().max(1.0) as usize).min(MOST_PIECES);
        let mut found = halves(count)?;
        while count < MOST_PIECES && sagitta_mm(&found) > chord_mm {
            count += count / 100 + 1;
            found = halves(count)?;
        }
        let ends: Vec<_> = found.into_iter().skip(2).step_by(2).collect();
        for end in &ends {
            self.cycle.within_travel(self.machine, end)?;
        }
        Ok(ends)
    }

    /// Time of a straight piece, s.
    fn seconds(&self, from: &AxisValues<f64>, to: &AxisValues<f64>) -> f64 {
        let of_axis = |letter: Joint| {
            let usual =
                if letter.is_rotary() { self.rules.transfer_rad_per_s } else { self.rules.transfer_mm_per_s };
            let limit = self.machine.axis(letter).and_then(|axis| axis.facts.feed_limit);
            (to[letter] - from[letter]).abs() / limit.map_or(usual, |limit| limit.min(usual))
        };
        self.machine.joints().into_iter().map(of_axis).fold(0.0, f64::max)
    }

    /// All axes at a place. `near`: where they stood before.
    fn axes_at(
        &self,
        setup: usize,
        place: &Place,
        near: &AxisValues<f64>,
    ) -> Result<AxisValues<f64>, VisitError> {
        let found = match &self.cycle.motion {
            Motion::Path { .. } => self.cycle.on_the_way(self.machine, (setup, 0), place.angle_rad, near),
            _ if self.cycle.names_linear() => Some(place.asked),
            _ => self.cycle.position(self.machine, setup, &place.asked),
        };
        found.ok_or_else(|| self.cycle.cannot_follow(self.machine, setup))
    }

    /// Centre of what the spindle carries, machine axes, mm.
    fn tip_in_machine(&self, setup: usize, at: &AxisValues<f64>) -> Point3<f64> {
        self.machine.machine_from_tool(at, &JointErrors::default()) * self.cycle.setups[setup].ball_in_tool_mm
    }

    /// The same in table axes, mm.
    fn tip_in_table(&self, setup: usize, at: &AxisValues<f64>) -> Point3<f64> {
        self.machine.machine_from_table(at, &JointErrors::default()).inverse()
            * self.tip_in_machine(setup, at)
    }

    /// Centre of what the table carries, machine axes, mm.
    fn ball_in_machine(&self, setup: usize, at: &AxisValues<f64>) -> Point3<f64> {
        self.machine.machine_from_table(at, &JointErrors::default())
            * self.cycle.setups[setup].ball_in_table_mm
    }
}
