//! The states a machine goes through in a cycle, and how long it takes.
//!
//! At rest: every pose of the grid, every row of the fast axis approached from the side of its pass with an overrun. On the
//! fly: points at a constant rate while the axis turns at its feed, the linear axes following. Moves take the time of the
//! slowest axis at its feed limit; ramps and look-ahead of the controller are in the allowances of [`Pace`].

use super::{Cycle, Leg, Motion};
use trunnion_core::{AxisValues, Joint, State, convert};
use trunnion_machine::Machine;

/// Distance for differences along the path, rad.
const NEAR_RAD: f64 = 5e-3;
/// Curvature of the path that counts, mm or rad per rad².
const BENT: f64 = 1e-6;
/// Travel that counts as motion, mm or rad.
const STANDSTILL: f64 = 1e-9;

/// How fast a machine goes about a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Feed of linear axes whose limit the machine file does not give, mm/s.
    pub linear_mm_per_s: f64,
    /// Feed of rotary axes whose limit the machine file does not give, rad/s.
    pub rotary_rad_per_s: f64,
    /// From standstill to a settled reading, in addition to the window of the cycle, s.
    pub settle_s: f64,
    /// Speeding up and slowing down at both ends of a sweep, s each.
    pub ramp_s: f64,
    /// Mounting ball and nest of one setup, s.
    pub mount_s: f64,
    /// Points a second on the fly.
    pub points_per_s: f64,
}

impl Default for Pace {
    /// 10 m/min, 3600°/min, 1.5 s to settle, ramps of 0.5 s, 5 minutes to mount, 10 points a second.
    fn default() -> Self {
        Self {
            linear_mm_per_s: 10_000.0 / 60.0,
            rotary_rad_per_s: convert::rad_from_deg(3600.0) / 60.0,
            settle_s: 1.5,
            ramp_s: 0.5,
            mount_s: convert::s_from_min(5.0),
            points_per_s: 10.0,
        }
    }
}

/// What a cycle goes through.
#[derive(Clone, Debug, PartialEq)]
pub struct Visits {
    /// State of every point in order; the first pose is reached at time 0.
    pub states: Vec<State>,
    /// Machine time with mounting, s.
    pub duration_s: f64,
}

/// A cycle that the machine cannot run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VisitError {
    /// The linear axes cannot follow the ball.
    #[error(
        "machine {machine} cannot bring its spindle to the ball of setup {setup}; it needs three linear axes"
    )]
    CannotFollow {
        /// The machine.
        machine: String,
        /// The setup.
        setup: String,
    },
    /// A position outside the travel.
    #[error(
        "cycle {cycle} needs {axis} at {position}, its travel is {low}..={high}; move the ball or leave these poses out"
    )]
    BeyondTravel {
        /// The cycle.
        cycle: String,
        /// The axis.
        axis: Joint,
        /// Position needed, mm or degrees.
        position: f64,
        /// Smallest coordinate, mm or degrees.
        low: f64,
        /// Largest coordinate, mm or degrees.
        high: f64,
    },
    /// A cycle that has no NC program.
    #[error(
        "cycle {cycle} has no NC program: {what}; programs are written for R-test and ball-bar cycles over rotary axes"
    )]
    NoCourse {
        /// The cycle.
        cycle: String,
        /// Why.
        what: &'static str,
    },
    /// An axis the machine has not.
    #[error("cycle {cycle} moves axis {axis}, which machine {machine} does not have; its axes: {axes}")]
    NoSuchAxis {
        /// The cycle.
        cycle: String,
        /// The axis.
        axis: Joint,
        /// The machine.
        machine: String,
        /// Its axes.
        axes: String,
    },
}

impl Cycle {
    /// The states of a cycle in order of time.
    ///
    /// # Errors
    /// A cycle that the machine cannot run: axes, reach, travel.
    pub fn visits(&self, machine: &Machine, pace: &Pace) -> Result<Visits, VisitError> {
        self.has_its_axes(machine)?;
        let mut tour = Tour { cycle: self, machine, pace, time_s: 0.0, states: Vec::new(), at: None };
        let mut last: Option<Leg> = None;
        let mut mountings = if self.rounds.interleave { self.setups.len() } else { 1 };
        for leg in self.legs() {
            if let Some(last) = last {
                if last.round != leg.round {
                    tour.time_s += self.rounds.wait_s;
                }
                if last.setup != leg.setup && !self.rounds.interleave {
                    tour.time_s += pace.mount_s;
                    mountings += 1;
                }
            }
            match &self.motion {
                Motion::Static { .. } | Motion::Line { .. } => tour.stand(&leg)?,
                Motion::OnTheFly { .. } | Motion::Path { .. } => tour.sweep(&leg)?,
            }
            last = Some(leg);
        }
        let before_s = if self.rounds.interleave { mountings as f64 * pace.mount_s } else { pace.mount_s };
        Ok(Visits { states: tour.states, duration_s: tour.time_s + before_s })
    }

    /// # Errors
    /// An axis of the cycle that the machine has not.
    pub(crate) fn has_its_axes(&self, machine: &Machine) -> Result<(), VisitError> {
        let moved: Vec<Joint> = match &self.motion {
            Motion::Static { .. } => self.grid(machine).iter().map(|axis| axis.letter).collect(),
            Motion::Line { .. } => Joint::LINEAR.to_vec(),
            Motion::Path { path, .. } => path.axes(),
            Motion::OnTheFly { axis, .. } => vec![*axis],
        };
        if let Some(&axis) = moved.iter().find(|&&letter| machine.axis(letter).is_none()) {
            let axes = machine.axes().map(|axis| axis.letter.as_str()).collect::<Vec<_>>().join(", ");
            return Err(VisitError::NoSuchAxis {
                cycle: self.name.clone(),
                axis,
                machine: machine.name.clone(),
                axes,
            });
        }
        Ok(())
    }

    pub(crate) fn cannot_follow(&self, machine: &Machine, setup: usize) -> VisitError {
        VisitError::CannotFollow { machine: machine.name.clone(), setup: self.setups[setup].name.clone() }
    }

    /// # Errors
    /// An axis beyond its travel.
    pub(crate) fn within_travel(
        &self,
        machine: &Machine,
        position: &AxisValues<f64>,
    ) -> Result<(), VisitError> {
        for axis in machine.axes() {
            let (low, high) = axis.travel;
            let here = position[axis.letter];
            if here < low - 1e-9 || here > high + 1e-9 {
                let edge = |value: f64| {
                    let value = if axis.is_rotary() { convert::deg_from_rad(value) } else { value };
                    (value * 1e3).round() / 1e3
                };
                return Err(VisitError::BeyondTravel {
                    cycle: self.name.clone(),
                    axis: axis.letter,
                    position: edge(here),
                    low: edge(low),
                    high: edge(high),
                });
            }
        }
        Ok(())
    }

    /// What turns in a pass on the fly, and how fast; `None` at rest.
    pub(super) fn sweeping(&self, leg: &Leg) -> Option<Sweeping> {
        match &self.motion {
            Motion::Static { .. } | Motion::Line { .. } => None,
            Motion::OnTheFly { axis, from_to_rad, feeds_rad_per_s, .. } => Some(Sweeping {
                turning: Some(*axis),
                from_to_rad: *from_to_rad,
                feed: feeds_rad_per_s[leg.feed],
            }),
            Motion::Path { path, from_to_rad, feeds_mm_per_s, .. } => {
                let feed = feeds_mm_per_s[leg.feed] / path.radius_mm(&self.setups[leg.setup]);
                Some(Sweeping { turning: None, from_to_rad: *from_to_rad, feed })
            }
        }
    }

    /// All axes at an angle of a pass on the fly through a target. `near`: where the axes stood before.
    pub(super) fn on_the_way(
        &self,
        machine: &Machine,
        (setup, target): (usize, usize),
        angle: f64,
        near: &AxisValues<f64>,
    ) -> Option<AxisValues<f64>> {
        match &self.motion {
            Motion::Static { .. } | Motion::Line { .. } => None,
            Motion::OnTheFly { .. } => self.position(machine, setup, &self.rotary_at(angle)?),
            Motion::Path { path, .. } => path.position(machine, (&self.setups[setup], target), angle, near),
        }
    }
}

/// A pass on the fly.
pub(super) struct Sweeping {
    /// The axis that turns at the feed; `None` on a curve.
    pub turning: Option<Joint>,
    pub from_to_rad: (f64, f64),
    /// rad/s of the axis or along the curve.
    pub feed: f64,
}

/// The machine on its way.
struct Tour<'a> {
    cycle: &'a Cycle,
    machine: &'a Machine,
    pace: &'a Pace,
    time_s: f64,
    states: Vec<State>,
    /// Where it stands, with the directions and travels since reversal so far.
    at: Option<State>,
}

impl Tour<'_> {
    /// One pass of a grid or a line, read at rest.
    fn stand(&mut self, leg: &Leg) -> Result<(), VisitError> {
        let Some(settle) = self.cycle.settle() else { return Ok(()) };
        let grid = self.cycle.grid(self.machine);
        let mut row_began = AxisValues::<f64>::default();
        let mut before: Option<AxisValues<f64>> = None;
        for station in self.cycle.stations(self.machine, leg.setup, leg.pass) {
            let asked = station.asked;
            if before.is_none()
                && let Some(beyond) = self.cycle.before_line(leg.setup, leg.pass, &asked)
            {
                self.at = Some(self.arrive(leg, Some(beyond))?);
            }
            let approached =
                || grid.iter().filter_map(|axis| axis.overrun().map(|overrun| (axis.letter, overrun)));
            for (letter, overrun) in approached() {
                let back = |last: &AxisValues<f64>| (asked[letter] - last[letter]) * leg.pass < 0.0;
                if before.as_ref().is_none_or(back) {
                    // Back to the beginning of a row, beyond it and forward again.
                    row_began[letter] = asked[letter] - leg.pass * overrun;
                    self.time_s += self.seconds(letter, 2.0 * overrun);
                }
            }
            let position = self.cycle.dwell_at(self.machine, leg.setup, &station);
            let mut state = self.arrive(leg, position)?;
            state.target = station.target;
            for (letter, _) in approached() {
                state.direction[letter] = leg.pass;
                state.since_reversal[letter] = (asked[letter] - row_began[letter]).abs();
            }
            let first = self.states.is_empty();
            // Time runs from the first reading.
            self.time_s = if first { 0.0 } else { self.time_s + self.pace.settle_s + settle.window_s };
            state.time_s = Some(self.time_s);
            self.at = Some(state.clone());
            self.states.push(state);
            before = Some(asked);
        }
        Ok(())
    }

    /// One pass at one feed.
    fn sweep(&mut self, leg: &Leg) -> Result<(), VisitError> {
        let Some(Sweeping { turning, from_to_rad: (from, to), feed }) = self.cycle.sweeping(leg) else {
            return Ok(());
        };
        let (first, last) = if leg.pass < 0.0 { (to, from) } else { (from, to) };
        let heading = (last - first).signum();
        let run_in = 0.5 * feed * self.pace.ramp_s;
        let began = first - heading * run_in;
        let start = self.arrive(leg, self.on_the_way(leg, 0, began))?;
        if self.states.is_empty() {
            self.time_s = 0.0;
        }
        self.at = Some(start);
        self.time_s += self.pace.ramp_s;
        let begin_s = self.time_s;
        for (circle, travelled, target) in self.read_at(leg, (first, last), feed) {
            let angle = first + heading * travelled;
            let mut state = self.arrive(leg, self.on_the_way(leg, target, angle))?;
            state.target = target;
            let around: Vec<AxisValues<f64>> = [-2.0, -1.0, 1.0, 2.0]
                .iter()
                .map(|k| {
                    self.on_the_way(leg, target, angle + k * NEAR_RAD)
                        .ok_or_else(|| self.cycle.cannot_follow(self.machine, leg.setup))
                })
                .collect::<Result<_, _>>()?;
            for letter in self.machine.joints() {
                let [p2, p1, n1, n2] = std::array::from_fn(|k| around[k][letter]);
                let here = state.position[letter];
                // Central differences of fourth order.
                let slope = (p2 - 8.0 * p1 + 8.0 * n1 - n2) / (12.0 * NEAR_RAD);
                let bend = (16.0 * (p1 + n1) - p2 - n2 - 30.0 * here) / (12.0 * NEAR_RAD.powi(2));
                state.velocity[letter] = if slope.abs() < STANDSTILL { 0.0 } else { heading * feed * slope };
                state.acceleration[letter] = if bend.abs() < BENT { 0.0 } else { bend * feed.powi(2) };
            }
            if let Some(axis) = turning {
                state.direction[axis] = heading;
                state.since_reversal[axis] = run_in + travelled;
            }
            let before_s = circle as f64 * ((last - first).abs() / feed + 2.0 * self.pace.ramp_s);
            self.time_s = begin_s + before_s + travelled / feed;
            state.time_s = Some(self.time_s);
            self.at = Some(State {
                velocity: Default::default(),
                acceleration: Default::default(),
                ..state.clone()
            });
            self.states.push(state);
        }
        let last_s = self.states.last().and_then(|state| state.time_s).unwrap_or(begin_s);
        self.time_s = last_s.max(begin_s + (last - first).abs() / feed) + self.pace.ramp_s;
        Ok(())
    }

    /// Where a pass is read: the number of the circle, the way on it, rad, and the target there. The targets of a curve, else equal times.
    fn read_at(&self, leg: &Leg, (first, last): (f64, f64), feed: f64) -> Vec<(usize, f64, usize)> {
        let setup = &self.cycle.setups[leg.setup];
        match &self.cycle.motion {
            Motion::Path { path, .. } if setup.artefact.is_some() => {
                path.targets_between(self.machine, setup, first, last)
            }
            _ => {
                let step_rad = feed / self.pace.points_per_s;
                let count = ((last - first).abs() / step_rad + 1e-6).floor() as usize;
                (0..count).map(|i| (0, step_rad * (i as f64 + 0.5), 0)).collect()
            }
        }
    }

    fn on_the_way(&self, leg: &Leg, target: usize, angle: f64) -> Option<AxisValues<f64>> {
        let near = self.at.as_ref().map_or_else(AxisValues::default, |state| state.position);
        self.cycle.on_the_way(self.machine, (leg.setup, target), angle, &near)
    }

    /// Moves to the next position; the time passes, directions and travels of all axes follow.
    fn arrive(&mut self, leg: &Leg, position: Option<AxisValues<f64>>) -> Result<State, VisitError> {
        let position = position.ok_or_else(|| self.cycle.cannot_follow(self.machine, leg.setup))?;
        self.cycle.within_travel(self.machine, &position)?;
        let mut state = State { position, setup: leg.setup, ..State::default() };
        if let Some(before) = &self.at {
            let mut longest_s = 0f64;
            for letter in self.machine.joints() {
                let travel = position[letter] - before.position[letter];
                longest_s = longest_s.max(self.seconds(letter, travel));
                let direction =
                    if travel.abs() < STANDSTILL { before.direction[letter] } else { travel.signum() };
                let so_far =
                    if direction == before.direction[letter] { before.since_reversal[letter] } else { 0.0 };
                state.direction[letter] = direction;
                state.since_reversal[letter] = so_far + travel.abs();
            }
            self.time_s += longest_s;
        }
        Ok(state)
    }

    fn seconds(&self, letter: Joint, travel: f64) -> f64 {
        let usual = if letter.is_rotary() { self.pace.rotary_rad_per_s } else { self.pace.linear_mm_per_s };
        let feed = self.machine.axis(letter).and_then(|axis| axis.facts.feed_limit).unwrap_or(usual);
        travel.abs() / feed
    }
}
