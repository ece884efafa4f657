//! Readings taken while one rotary axis turned alone, as motion of what the axis carries [S0 §3].
//!
//! Each reading becomes the displacement of the carried side against the other side, less what the nominal machine would
//! show, in axes (u, v, w) of the part that carries the axis: w along the axis, u and v across, right-handed:
//! C: X Y Z, B: Z X Y, A: Y Z X. An axis error (δ, ω) then shows, for a ball at height h over the reference point of the axis, as
//! `u = δ_u + ω_v h`, `v = δ_v − ω_u h`, `w = δ_w`; a ball set off the axis by s turns with it: `R_w(θ) s`.
//! Limits: R-test readings (three components); the axis lies along a coordinate of its carrier.

use super::relative::{machine_from_reading, tool_against_table_mm};
use crate::common::{LeftOut, Mounted, mounted, reasons};
use crate::recipes::{Method, MethodError, one_machine};
use nalgebra::{Matrix3, Point3, Vector3};
use trunnion_core::convert::{deg_from_rad, rad_from_deg};
use trunnion_core::{AxisValues, InstrumentKind, Joint, Point, Setup};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::{JointErrors, Machine, Side};

/// Other axes that move less than this are at rest, mm or rad.
const STILL_MM: f64 = 0.05;
const STILL_RAD: f64 = 1e-4;
/// An axis that turns less than this is only positioned.
const LEAST_TURN_RAD: f64 = std::f64::consts::FRAC_PI_2;

/// Everything that was read while one axis turned alone.
#[derive(Clone, Debug)]
pub(crate) struct Turning {
    /// The axis.
    pub axis: Joint,
    /// Across and along: u, v, w.
    pub frame: [Joint; 3],
    /// One for each setup of each run.
    pub sets: Vec<TurningSet>,
    /// True when the readings are blocks of samples of a moving axis.
    pub on_the_fly: bool,
    pub left_out: Vec<LeftOut>,
}

/// One setup of one run.
#[derive(Clone, Debug)]
pub(crate) struct TurningSet {
    /// Name of the setup, with the run's number in front when there are several runs.
    pub name: String,
    /// Index of the run.
    pub run: usize,
    /// Height of the ball over the reference point of the axis, along the axis, mm.
    pub height_mm: f64,
    /// Readings in the order they were taken.
    pub readings: Vec<Turned>,
    /// How many passes (at most one turn in one direction) there are.
    pub passes: usize,
    /// Positions of the axes that stood still.
    pub position: AxisValues<f64>,
}

/// One reading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned {
    /// Coordinate of the axis, rad.
    pub angle_rad: f64,
    /// Right-handed turn about w, rad.
    pub turned_rad: f64,
    /// −1 or +1; 0 when it cannot be distinguished.
    pub direction: f64,
    /// Index of the pass.
    pub pass: usize,
    /// Displacement of the carried side in u, v, w, mm.
    pub moved_mm: Vector3<f64>,
    /// The same for a unit of each component of the reading.
    pub moved_per_reading: Matrix3<f64>,
    /// Number of the reading among the good ones of all runs.
    pub number: usize,
}

impl Turning {
    /// Finds the axis that turns alone, or checks the one asked for, and gathers its readings.
    ///
    /// # Errors
    /// No setup in which one rotary axis turns alone, several such axes and none chosen, or runs of several machines.
    pub fn of(method: &Method, runs: &[Run], asked: Option<Joint>) -> Result<Self, MethodError> {
        let machine = one_machine(runs)?;
        if let Some(letter) = asked
            && !machine.axis(letter).is_some_and(|axis| axis.is_rotary())
        {
            let rotary: Vec<_> = machine.rotary().iter().map(|axis| axis.letter.as_str()).collect();
            let found = format!("machine {} has no rotary axis {letter}", machine.name);
            return Err(method.lacks(found, format!("Choose --axis {}.", rotary.join(" or "))));
        }
        let (mut found, mut left_out) = (Vec::new(), Vec::new());
        for mounted in mounted(runs) {
            match alone(machine, mounted.setup, &mounted.points) {
                Ok(letter) if asked.is_none_or(|asked| asked == letter) => found.push((letter, mounted)),
                Ok(letter) => {
                    left_out.push(LeftOut::setup(mounted.name, format!("axis {letter} turns there")));
                }
                Err(why) => left_out.push(LeftOut::setup(mounted.name, why)),
            }
        }
        let Some((axis, first)) = found.first().map(|(axis, first)| (*axis, first)) else {
            let wanted = asked.map_or("a rotary axis".into(), |letter| format!("axis {letter}"));
            let found = format!("in no setup does {wanted} turn alone ({})", reasons(&left_out));
            return Err(method.lacks(found, "Run a cycle such as config/cycles/two-height-c.toml."));
        };
        if let Some((other, Mounted { name, .. })) = found.iter().find(|(letter, _)| *letter != axis) {
            let found = format!("axis {axis} turns alone in setup {}, {other} in setup {name}", first.name);
            return Err(method.lacks(found, format!("Choose one with --axis {axis} or --axis {other}.")));
        }
        let place = Placed::of(machine, axis).ok_or_else(|| {
            let found = format!("axis {axis} of machine {} lies along no coordinate", machine.name);
            method.lacks(found, "Use the joint fit (identify without --method).")
        })?;
        let sets = found.iter().map(|(_, mounted)| place.set(mounted)).collect();
        let on_the_fly = found.iter().any(|(_, mounted)| mounted.run.kind == RunKind::OnTheFly);
        Ok(Self { axis, frame: place.frame, sets, on_the_fly, left_out })
    }

    /// Symbol of an error of the axis: `E`, direction, axis, e.g. `EXC`; of its average line with a `0`, `EX0C`.
    pub fn symbol(&self, direction: Joint, average_line: bool) -> String {
        format!("E{direction}{}{}", if average_line { "0" } else { "" }, self.axis)
    }

    /// The letters of the rotations about u, v, w.
    pub fn rotations(&self) -> [Joint; 3] {
        self.frame.map(|letter| Joint::ROTARY[letter.index()])
    }

    /// True when a pass goes once around.
    pub fn whole_turn(&self) -> bool {
        self.sets.iter().all(|set| {
            let angles = || set.readings.iter().filter(|r| r.pass == 0).map(|r| r.angle_rad);
            // The last station of a grid is one step short of a whole turn.
            span(angles()) * (1.0 + 1.0 / angles().count().max(2) as f64) > 0.95 * std::f64::consts::TAU
        })
    }
}

/// The rotary axis that turns while everything else is at rest, or why there is none.
fn alone(machine: &Machine, setup: &Setup, points: &[&Point]) -> Result<Joint, String> {
    if setup.instrument != InstrumentKind::RTest {
        return Err(format!("read by {}, not by an R-test", setup.instrument.with_article()));
    }
    let moves = |letter: Joint| span(points.iter().map(|p| p.state.position[letter]));
    let turning: Vec<_> =
        machine.rotary_joints().into_iter().filter(|&letter| moves(letter) > LEAST_TURN_RAD).collect();
    let &[axis] = &turning[..] else {
        return Err(match turning.is_empty() {
            true => format!("no axis turns by {:.0}° or more", deg_from_rad(LEAST_TURN_RAD)),
            false => format!("axes {} turn", names(&turning)),
        });
    };
    let still = |letter: Joint| if letter.is_rotary() { STILL_RAD } else { STILL_MM };
    let others: Vec<_> = machine
        .joints()
        .into_iter()
        .filter(|&letter| letter != axis && moves(letter) > still(letter))
        .collect();
    match others.is_empty() {
        true => Ok(axis),
        false => Err(format!(
            "with axis {axis} also {} moves; put the ball on the axis line, so that the others can stand",
            names(&others)
        )),
    }
}

fn names(letters: &[Joint]) -> String {
    letters.iter().map(|letter| letter.as_str()).collect::<Vec<_>>().join(", ")
}

/// Largest minus smallest.
fn span(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    (high - low).max(0.0)
}

/// The axis in its machine.
struct Placed<'a> {
    machine: &'a Machine,
    axis: Joint,
    side: Side,
    frame: [Joint; 3],
    /// Right-handed turn about w for a positive coordinate.
    sense: f64,
}

impl<'a> Placed<'a> {
    fn of(machine: &'a Machine, axis: Joint) -> Option<Self> {
        let joint = machine.axis(axis)?;
        let along = joint.direction.iamax();
        let frame = [(along + 1) % 3, (along + 2) % 3, along].map(|k| Joint::LINEAR[k]);
        let cosine = joint.direction[along];
        let side = machine.side(axis)?;
        (cosine.abs() > 0.999).then_some(Self {
            machine,
            axis,
            side,
            frame,
            sense: joint.sense * cosine.signum(),
        })
    }

    fn set(&self, mounted: &Mounted<'_>) -> TurningSet {
        let Mounted { name, at, setup, points, numbers, .. } = mounted;
        let numbered = points.iter().zip(numbers);
        let mut readings: Vec<Turned> =
            numbered.map(|(point, &number)| self.turned(setup, point, number)).collect();
        let passes = number_passes(&mut readings);
        let position = points[0].state.position;
        TurningSet {
            name: name.clone(),
            run: *at,
            height_mm: self.height_mm(setup, &position),
            readings,
            passes,
            position,
        }
    }

    fn turned(&self, setup: &Setup, point: &Point, number: usize) -> Turned {
        let position = &point.state.position;
        let tool_against_table = tool_against_table_mm(self.machine, setup, point);
        let carried = match self.side {
            Side::Table => -tool_against_table,
            Side::Tool => tool_against_table,
        };
        let frame = self.machine.joint_frame(self.axis, position).expect("the machine has this axis");
        let in_carrier = frame.machine_from_carrier.inverse() * carried;
        let per_reading = frame.machine_from_carrier.inverse().to_rotation_matrix().into_inner()
            * machine_from_reading(self.machine, setup, point);
        let sense = if self.side == Side::Table { -1.0 } else { 1.0 };
        let angle_rad = position[self.axis];
        Turned {
            angle_rad,
            turned_rad: self.sense * angle_rad,
            direction: point.state.direction[self.axis],
            pass: 0,
            moved_mm: Vector3::from_fn(|k, _| in_carrier[self.frame[k].index()]),
            moved_per_reading: Matrix3::from_fn(|k, of| sense * per_reading[(self.frame[k].index(), of)]),
            number,
        }
    }

    fn height_mm(&self, setup: &Setup, position: &AxisValues<f64>) -> f64 {
        let none = JointErrors::default();
        let frame = self.machine.joint_frame(self.axis, position).expect("the machine has this axis");
        let ball_in_machine = match self.side {
            Side::Table => self.machine.machine_from_table(position, &none) * setup.ball_in_table_mm,
            Side::Tool => self.machine.machine_from_tool(position, &none) * Point3::origin(),
        };
        let from_origin =
            frame.machine_from_carrier.inverse() * (ball_in_machine - frame.origin_in_machine_mm);
        from_origin[self.frame[2].index()]
    }
}

/// Numbers the passes: a new one wherever the axis turns round, jumps back, or has gone once around. Directions that
/// the run does not state follow from the angles.
fn number_passes(readings: &mut [Turned]) -> usize {
    let nearly = rad_from_deg(1e-3);
    let (mut pass, mut began_rad) = (0, readings.first().map_or(0.0, |r| r.angle_rad));
    for i in 0..readings.len() {
        let step = if i > 0 { readings[i].angle_rad - readings[i - 1].angle_rad } else { 0.0 };
        if readings[i].direction == 0.0 {
            let next = readings.get(i + 1).map_or(step, |next| next.angle_rad - readings[i].angle_rad);
            readings[i].direction = if i > 0 && step != 0.0 { step.signum() } else { next.signum() };
        }
        if i > 0 {
            let (now, before) = (readings[i].direction, readings[i - 1].direction);
            let around = (readings[i].angle_rad - began_rad).abs() > std::f64::consts::TAU - nearly;
            // A grid that holds 0° and 360° reads the same place twice; the second belongs to the next turn only if it goes on.
            let closes = around && readings.get(i + 1).is_none_or(|next| next.direction != now);
            if now != before || step * now < -nearly || (around && !closes) {
                pass += 1;
                began_rad = readings[i].angle_rad;
            }
        }
        readings[i].pass = pass;
    }
    if readings.is_empty() { 0 } else { pass + 1 }
}
