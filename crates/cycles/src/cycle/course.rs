//! What a controller has to do to run a cycle, step by step: the neutral form of an NC program.
//!
//! An R-test's ball and nest (or the bar) are brought together and taken apart with the rotary axes at or near zero, the spindle coming
//! from straight above; on a curve where it begins. In between they stay together: whatever the rotary axes do, the linear axes follow along short straight
//! pieces, because the controller's own tool-point following is off. Where the cycle names the linear axes (lines, grids of X,
//! Y, Z under an interferometer) the way is straight. A pose is approached as [`Cycle::visits`] says, from
//! the side of its pass with an overrun; a sweep runs in and out by half the feed times the ramp.

mod guide;

use super::visit::VisitError;
use super::{Cycle, Leg, Pace};
use crate::RunKind;
use guide::Guide;
use trunnion_core::{AxisLetter, AxisValues, InstrumentKind, State};
use trunnion_machine::{Axis, Machine};

/// Farther than this from every pose, no one takes a stand for a pose, rad.
const FREE_RAD: f64 = 2.5 / 180.0 * std::f64::consts::PI;
/// Places looked at for standing free of the poses.
const MOST_PLACES: u32 = 36;

/// How a course is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseRules {
    /// Run-in, settling and the feed limits of axes whose machine file gives none.
    pub pace: Pace,
    /// Largest distance of the tool point from its path over the table in the straight pieces of a sweep, mm.
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
        /// The axis at its feed; `None` along a curve.
        turning: Option<AxisLetter>,
        /// Signed feed, rad/s of that axis or of the angle along the curve.
        feed: f64,
        /// Duration of every piece, s.
        piece_s: f64,
        /// Ends of the pieces; run-in and run-out included.
        ends: Vec<AxisValues<f64>>,
    },
}

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
