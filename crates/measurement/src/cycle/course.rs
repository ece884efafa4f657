//! What a controller has to do to run a cycle, step by step: the neutral form of an NC program.
//!
//! Ball and nest (or the bar) are brought together and taken apart with the rotary axes at or near zero, the spindle coming
//! from straight above. In between they stay together: whatever the rotary axes do, the linear axes follow along short straight
//! pieces, because the controller's own tool-point following is off. A pose is approached as [`Cycle::visits`] says, from
//! the side of its pass with an overrun; a sweep runs in and out by half the feed times the ramp.

use super::visit::{OVERRUN_RAD, VisitError};
use super::{Cycle, Leg, Motion, Pace, grid_positions};
use crate::InstrumentKind;
use nalgebra::Vector3;
use trunnion_machine::{Axis, JointErrors, Machine, State};
use trunnion_units::{AxisLetter, AxisValues};

/// Shortest standing still before a sweep, s: it tells the passes of a recording apart.
const PAUSE_S: f64 = 1.0;
/// One stroke of the gesture takes this long, s.
const STROKE_S: f64 = 0.2;
/// Pieces of a path from which its curvature is first judged.
const FIRST_PIECES: usize = 16;
/// Most pieces of one path.
const MOST_PIECES: usize = 1_000_000;
/// Farther than this from every pose, no one takes a stand for a pose, rad.
const FREE_RAD: f64 = 2.5 / 180.0 * std::f64::consts::PI;
/// Places looked at for standing free of the poses.
const MOST_PLACES: u32 = 36;
/// Travel that counts as motion, mm or rad.
const STANDSTILL: f64 = 1e-9;

/// How a course is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseRules {
    /// Run-in, settling and the feed limits of axes whose machine file gives none.
    pub pace: Pace,
    /// Largest distance of the straight pieces of a sweep from its path, any linear axis, mm.
    pub chord_mm: f64,
    /// The same on the way from pose to pose, mm.
    pub transfer_chord_mm: f64,
    /// Largest speed of a linear axis from pose to pose, mm/s.
    pub transfer_mm_per_s: f64,
    /// Largest speed of a rotary axis from pose to pose, rad/s.
    pub transfer_rad_per_s: f64,
    /// Height of the retracted spindle above the highest ball, mm.
    pub clearance_mm: f64,
    /// Standing still at a pose at rest, s; `None`: settling and two windows of the cycle.
    pub dwell_s: Option<f64>,
    /// Length of one stroke of the gesture that begins and ends a cycle on the fly, mm.
    pub stroke_mm: f64,
    /// Strokes of the gesture, each there and back.
    pub strokes: usize,
}

impl Default for CourseRules {
    /// Chords of 0.5 µm in sweeps and 50 µm between poses, 2000 mm/min and 1800°/min, 100 mm clearance, three strokes of
    /// 0.2 mm.
    fn default() -> Self {
        Self {
            pace: Pace::default(),
            chord_mm: 0.5e-3,
            transfer_chord_mm: 0.05,
            transfer_mm_per_s: 2000.0 / 60.0,
            transfer_rad_per_s: std::f64::consts::TAU * 5.0 / 60.0,
            clearance_mm: 100.0,
            dwell_s: None,
            stroke_mm: 0.2,
            strokes: 3,
        }
    }
}

/// One step of a course. Positions are of all axes, mm and rad; every move is straight in axis space.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// The spindle stands free above a setup: first in height, then the rotary axes, then over the place.
    Above {
        /// Where.
        at: AxisValues<f64>,
    },
    /// The operator fits what is named by the setups; the spindle is free.
    Fit {
        /// Indices of the setups.
        setups: Vec<usize>,
    },
    /// Straight down: ball and nest come together, or the table's ball comes within a bar's length.
    Join {
        /// Index of the setup.
        setup: usize,
        /// Where they are together.
        at: AxisValues<f64>,
        /// True when the operator has to see to it (a bar to put in, probes to look at).
        attended: bool,
    },
    /// Straight up again; a bar is taken out first.
    Part {
        /// Index of the setup.
        setup: usize,
        /// Where the spindle is free.
        to: AxisValues<f64>,
    },
    /// Along straight pieces, each at the speed the slowest axis allows.
    Transfer {
        /// End and duration, s, of every piece.
        pieces: Vec<(AxisValues<f64>, f64)>,
    },
    /// Stand until the pose is read.
    Stand {
        /// How long, s.
        seconds: f64,
    },
    /// Stand for another reason.
    Wait {
        /// How long, s.
        seconds: f64,
        /// Why.
        reason: &'static str,
    },
    /// A small motion that is seen by axes and probes alike.
    Gesture {
        /// The axis that strokes.
        axis: AxisLetter,
        /// End and duration, s, of every stroke.
        pieces: Vec<(AxisValues<f64>, f64)>,
    },
    /// At the feed of the cycle through pieces of equal duration.
    Sweep {
        /// The axis at its feed.
        axis: AxisLetter,
        /// Signed feed of that axis, rad/s.
        feed: f64,
        /// Duration of every piece, s.
        piece_s: f64,
        /// Ends of the pieces; run-in and run-out included.
        ends: Vec<AxisValues<f64>>,
    },
}

impl Cycle {
    /// The steps of the cycle in order.
    ///
    /// # Errors
    /// A cycle that the machine cannot run: axes, reach, travel (overruns and the retracted spindle included).
    pub fn course(&self, machine: &Machine, rules: &CourseRules) -> Result<Vec<Step>, VisitError> {
        self.has_its_axes(machine)?;
        let no_course = |what| Err(VisitError::NoCourse { cycle: self.name.clone(), what });
        if let Motion::Line { .. } | Motion::Path { .. } = self.motion {
            return no_course("it moves along a line or a curve");
        }
        if self.grid().iter().any(|axis| !axis.letter.is_rotary()) {
            return no_course("its grid names linear axes");
        }
        if self.setups.iter().any(|setup| setup.artefact.is_some()) {
            return no_course("it has an artefact with several targets");
        }
        let home = self.home(machine, &rules.pace)?;
        let mut guide =
            Guide { cycle: self, machine, rules, home, steps: Vec::new(), joined: None, fitted: Vec::new() };
        let mut last: Option<Leg> = None;
        for leg in self.legs() {
            guide.change_to(leg.setup)?;
            if last.is_some_and(|last| last.round != leg.round) && self.rounds.wait_s > 0.0 {
                guide
                    .steps
                    .push(Step::Wait { seconds: self.rounds.wait_s, reason: "rest between two rounds" });
            }
            match &self.motion {
                Motion::Static { .. } => guide.stand(&leg)?,
                Motion::OnTheFly { .. } => guide.sweep(&leg)?,
                Motion::Line { .. } | Motion::Path { .. } => unreachable!("refused above"),
            }
            last = Some(leg);
        }
        guide.part()?;
        Ok(guide.steps)
    }

    /// Where ball and nest come together: rotary axes at zero, or as near as their travel allows. Who watches the axes would
    /// take standing there for a pose of the cycle, so an upright axis is turned until no pose is near.
    fn home(&self, machine: &Machine, pace: &Pace) -> Result<AxisValues<f64>, VisitError> {
        let rotary = machine.rotary();
        let mut zero = AxisValues::default();
        for axis in &rotary {
            zero[axis.letter] = 0f64.clamp(axis.travel.0, axis.travel.1);
        }
        let upright = |axis: &&&Axis| axis.direction.z.abs();
        let turned = rotary.iter().max_by(|a, b| upright(a).total_cmp(&upright(b)));
        let Some(turned) = turned else { return Ok(zero) };
        let poses = self.visits(machine, pace)?.states;
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
        Ok(places.into_iter().find(free).unwrap_or(zero))
    }
}

/// Less the whole turns.
fn whole_turns_off(angle_rad: f64) -> f64 {
    angle_rad - (angle_rad / std::f64::consts::TAU).round() * std::f64::consts::TAU
}

/// Lays out a course.
struct Guide<'a> {
    cycle: &'a Cycle,
    machine: &'a Machine,
    rules: &'a CourseRules,
    /// Where the rotary axes stand while ball and nest come together and part.
    home: AxisValues<f64>,
    steps: Vec<Step>,
    /// The setup whose ball and nest are together, and where the rotary axes stand.
    joined: Option<(usize, AxisValues<f64>)>,
    /// Setups that have been mounted and stay so.
    fitted: Vec<usize>,
}

impl Guide<'_> {
    fn change_to(&mut self, setup: usize) -> Result<(), VisitError> {
        if self.joined.is_some_and(|(joined, _)| joined == setup) {
            return Ok(());
        }
        self.part()?;
        let home = self.home;
        self.steps.push(Step::Above { at: self.above(setup)? });
        let bar = self.cycle.setups[setup].instrument == InstrumentKind::BallBar;
        let new = !self.fitted.contains(&setup);
        if new {
            let all = 0..self.cycle.setups.len();
            let setups = if self.cycle.rounds.interleave { all.collect() } else { vec![setup] };
            self.fitted.clone_from(&setups);
            self.steps.push(Step::Fit { setups });
        }
        let at = self.position(setup, &home)?;
        self.steps.push(Step::Join { setup, at, attended: bar || new });
        self.joined = Some((setup, home));
        if let Motion::OnTheFly { .. } = self.cycle.motion {
            self.gesture(setup, &home)?;
        }
        Ok(())
    }

    /// Back to the zero of the rotary axes and up.
    fn part(&mut self) -> Result<(), VisitError> {
        let Some((setup, _)) = self.joined else { return Ok(()) };
        let home = self.home;
        self.transfer(&home)?;
        if let Motion::OnTheFly { .. } = self.cycle.motion {
            self.gesture(setup, &home)?;
        }
        self.steps.push(Step::Part { setup, to: self.above(setup)? });
        self.joined = None;
        Ok(())
    }

    /// One pass of a grid, read at rest.
    fn stand(&mut self, leg: &Leg) -> Result<(), VisitError> {
        let Motion::Static { grid, settle, .. } = &self.cycle.motion else { return Ok(()) };
        let seconds = self.rules.dwell_s.unwrap_or(self.rules.pace.settle_s + 2.0 * settle.window_s);
        let mut stations = grid_positions(grid);
        if leg.pass < 0.0 {
            stations.reverse();
        }
        let mut before: Option<AxisValues<f64>> = None;
        for rotary in stations {
            let mut beyond = rotary;
            for axis in grid {
                let letter = axis.letter;
                if before.is_none_or(|last| (rotary[letter] - last[letter]) * leg.pass < 0.0) {
                    beyond[letter] -= leg.pass * OVERRUN_RAD;
                }
            }
            self.transfer(&beyond)?;
            self.transfer(&rotary)?;
            self.steps.push(Step::Stand { seconds });
            before = Some(rotary);
        }
        Ok(())
    }

    /// One pass at one feed.
    fn sweep(&mut self, leg: &Leg) -> Result<(), VisitError> {
        let Motion::OnTheFly { axis, from_to_rad: (from, to), feeds_rad_per_s, others, .. } =
            &self.cycle.motion
        else {
            return Ok(());
        };
        let speed = feeds_rad_per_s[leg.feed];
        let (first, last) = if leg.pass < 0.0 { (*to, *from) } else { (*from, *to) };
        let heading = (last - first).signum();
        let run_in = 0.5 * speed * self.rules.pace.ramp_s;
        let at_angle = |angle: f64| {
            let mut rotary = *others;
            rotary[*axis] = angle;
            rotary
        };
        let (began, ends) = (at_angle(first - heading * run_in), at_angle(last + heading * run_in));
        self.transfer(&began)?;
        self.steps.push(Step::Wait { seconds: PAUSE_S, reason: "standing still before a pass" });
        let path = self.pieces(leg.setup, &began, &ends, self.rules.chord_mm)?;
        let piece_s = (ends[*axis] - began[*axis]).abs() / speed / path.len() as f64;
        self.steps.push(Step::Sweep { axis: *axis, feed: heading * speed, piece_s, ends: path });
        self.joined = Some((leg.setup, ends));
        Ok(())
    }

    /// Strokes along the linear axis in which the instrument sees most: X for an R-test, along the bar for a ball bar.
    fn gesture(&mut self, setup: usize, rotary: &AxisValues<f64>) -> Result<(), VisitError> {
        let seen = match self.cycle.setups[setup].instrument {
            InstrumentKind::BallBar => {
                self.cycle.bar_in_machine(self.machine, &self.cycle.setups[setup], rotary)
            }
            _ => Vector3::x(),
        };
        let shown = |letter: &AxisLetter| {
            self.machine.axis(*letter).map_or(-1.0, |axis| axis.direction.dot(&seen).abs())
        };
        let axis = AxisLetter::LINEAR
            .into_iter()
            .reduce(|best, letter| if shown(&letter) > shown(&best) { letter } else { best })
            .unwrap_or(AxisLetter::X);
        let here = self.position(setup, rotary)?;
        let mut there = here;
        there[axis] += self.rules.stroke_mm;
        let pieces = (0..self.rules.strokes).flat_map(|_| [(there, STROKE_S), (here, STROKE_S)]).collect();
        self.steps.push(Step::Wait { seconds: PAUSE_S, reason: "standing still before the gesture" });
        self.steps.push(Step::Gesture { axis, pieces });
        self.steps.push(Step::Wait { seconds: PAUSE_S, reason: "standing still after the gesture" });
        Ok(())
    }

    /// From where the rotary axes stand to `rotary`, joined.
    fn transfer(&mut self, rotary: &AxisValues<f64>) -> Result<(), VisitError> {
        let Some((setup, from)) = self.joined else { return Ok(()) };
        if AxisLetter::ALL.into_iter().all(|letter| (rotary[letter] - from[letter]).abs() < STANDSTILL) {
            return Ok(());
        }
        let ends = self.pieces(setup, &from, rotary, self.rules.transfer_chord_mm)?;
        let mut at = self.position(setup, &from)?;
        let mut pieces = Vec::new();
        for end in ends {
            pieces.push((end, self.seconds(&at, &end)));
            at = end;
        }
        self.steps.push(Step::Transfer { pieces });
        self.joined = Some((setup, *rotary));
        Ok(())
    }

    /// Ends of equal pieces of the rotary way whose linear axes stay within `chord_mm` of the true path.
    fn pieces(
        &self,
        setup: usize,
        from: &AxisValues<f64>,
        to: &AxisValues<f64>,
        chord_mm: f64,
    ) -> Result<Vec<AxisValues<f64>>, VisitError> {
        let along = |u: f64| AxisValues::from_fn(|letter| from[letter] + (to[letter] - from[letter]) * u);
        let at = |k: f64, count: usize| self.position(setup, &along(k / count as f64));
        let sagitta_mm = |count: usize| -> Result<f64, VisitError> {
            let mut most = 0f64;
            for k in (0..count).map(|k| k as f64) {
                let (begins, middle, ends) = (at(k, count)?, at(k + 0.5, count)?, at(k + 1.0, count)?);
                for letter in AxisLetter::LINEAR {
                    most = most.max((middle[letter] - 0.5 * (begins[letter] + ends[letter])).abs());
                }
            }
            Ok(most)
        };
        // The sagitta falls with the square of the count.
        let needed = FIRST_PIECES as f64 * (sagitta_mm(FIRST_PIECES)? / chord_mm).sqrt();
        let mut count = (needed.ceil().max(1.0) as usize).min(MOST_PIECES);
        while count < MOST_PIECES && sagitta_mm(count)? > chord_mm {
            count += count / 100 + 1;
        }
        let ends: Vec<_> = (1..=count).map(|k| at(k as f64, count)).collect::<Result<_, _>>()?;
        for end in &ends {
            self.cycle.within_travel(self.machine, end)?;
        }
        Ok(ends)
    }

    /// Time of a straight piece, s.
    fn seconds(&self, from: &AxisValues<f64>, to: &AxisValues<f64>) -> f64 {
        let of_axis = |letter: AxisLetter| {
            let usual =
                if letter.is_rotary() { self.rules.transfer_rad_per_s } else { self.rules.transfer_mm_per_s };
            let limit = self.machine.axis(letter).and_then(|axis| axis.facts.feed_limit);
            (to[letter] - from[letter]).abs() / limit.map_or(usual, |limit| limit.min(usual))
        };
        AxisLetter::ALL.into_iter().map(of_axis).fold(0.0, f64::max)
    }

    /// The spindle above a setup, at the same height above all of them.
    fn above(&self, setup: usize) -> Result<AxisValues<f64>, VisitError> {
        let home = self.home;
        let machine_from_table = self.machine.machine_from_table(&home, &JointErrors::default());
        let target_in_machine = |setup: usize| {
            let setup = &self.cycle.setups[setup];
            machine_from_table * self.cycle.place_in_table_mm(self.machine, setup, 0, &home)
        };
        let ball_mm = |setup: usize| (machine_from_table * self.cycle.setups[setup].ball_in_table_mm).z;
        let highest_mm = (0..self.cycle.setups.len())
            .map(|setup| target_in_machine(setup).z.max(ball_mm(setup)))
            .fold(f64::NEG_INFINITY, f64::max);
        let mut place = target_in_machine(setup);
        place.z = highest_mm + self.rules.clearance_mm;
        let place_in_table = machine_from_table.inverse() * place;
        let at = self
            .machine
            .follow(&home, &place_in_table)
            .ok_or_else(|| self.cycle.cannot_follow(self.machine, setup))?;
        self.cycle.within_travel(self.machine, &at)?;
        Ok(at)
    }

    fn position(&self, setup: usize, rotary: &AxisValues<f64>) -> Result<AxisValues<f64>, VisitError> {
        self.cycle.reach(self.machine, setup, rotary)
    }
}
