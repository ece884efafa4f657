//! From the steps of a cycle to the blocks of a program, with a header that says what has to be right before the start.

use super::program::{Block, Program, Target, whole_minutes};
use super::tool_point;
use crate::{CourseRules, Step, VisitError};
use crate::{Cycle, RunKind};
use nalgebra::Point3;
use trunnion_core::{AxisValues, InstrumentKind, Joint, NestSide, Setup, convert};
use trunnion_machine::{Axis, JointErrors, Machine, Side};

/// Feed of the free spindle, mm/min.
const FREE_MM_PER_MIN: f64 = 2000.0;
/// Feed of the last way to ball or nest, mm/min.
const JOIN_MM_PER_MIN: f64 = 300.0;
/// Feed of the rotary axes while the spindle is free, degrees/min.
const FREE_DEG_PER_MIN: f64 = 1800.0;

impl Program {
    /// The program of a cycle on a machine. Positions are those of the machine file: the centre of the ball or nest in the
    /// spindle, in machine axes.
    ///
    /// # Errors
    /// A cycle that the machine cannot run; with tool centre point control one without rotary axes.
    pub fn of_cycle(cycle: &Cycle, machine: &Machine, rules: &CourseRules) -> Result<Self, VisitError> {
        cycle.has_its_axes(machine)?;
        if Joint::LINEAR.iter().any(|&letter| machine.axis(letter).is_none()) {
            let what = "its machine has linear joints other than X, Y and Z";
            return Err(VisitError::NoCourse { cycle: cycle.name.clone(), what });
        }
        let steps = cycle.course(machine, rules)?;
        if rules.tool_point {
            tool_point::possible(cycle, machine)?;
        }
        let mut writer = Writer {
            cycle,
            machine,
            rules,
            blocks: Vec::new(),
            seconds: 0.0,
            shortest_s: None,
            at: None,
            keeps_tool_point: false,
        };
        for step in &steps {
            writer.step(step)?;
        }
        if writer.keeps_tool_point {
            writer.blocks.push(Block::ToolPoint(false));
        }
        let sweeps = steps.iter().any(|step| matches!(step, Step::Sweep { .. }));
        let mut program = Self {
            name: cycle.name.clone(),
            header: Vec::new(),
            tolerance_mm: if sweeps { rules.chord_mm } else { rules.transfer_chord_mm },
            tool_point: rules.tool_point,
            blocks: writer.blocks,
            duration_s: writer.seconds,
            shortest_block_s: writer.shortest_s,
            number: rules.program_number,
        };
        program.header = header(cycle, machine, rules, &program, clear_mm(cycle, machine, &steps));
        Ok(program)
    }
}

struct Writer<'a> {
    cycle: &'a Cycle,
    machine: &'a Machine,
    rules: &'a CourseRules,
    blocks: Vec<Block>,
    /// Running time so far, s.
    seconds: f64,
    shortest_s: Option<f64>,
    /// Where all axes stand; unknown before the first place.
    at: Option<AxisValues<f64>>,
    /// True while tool centre point control is on.
    keeps_tool_point: bool,
}

impl Writer<'_> {
    fn step(&mut self, step: &Step) -> Result<(), VisitError> {
        match step {
            Step::Above { at } => self.above(at)?,
            Step::Fit { setups } => {
                let setups: Vec<String> =
                    setups.iter().map(|&setup| mounting(&self.cycle.setups[setup])).collect();
                self.blocks.push(Block::Stop(format!("Mount {}. Then cycle start.", setups.join("; and "))));
            }
            Step::Join { setup, at, attended } => {
                self.feed(at, &Joint::LINEAR, JOIN_MM_PER_MIN)?;
                let setup = &self.cycle.setups[*setup];
                if *attended {
                    let first = match setup.instrument {
                        InstrumentKind::RTest => "all probes in range? ",
                        InstrumentKind::BallBar => "put the bar between the balls. ",
                        InstrumentKind::LaserBallBar | InstrumentKind::PassiveArm => {
                            "connect it to the spindle. "
                        }
                        InstrumentKind::CrossGrid => "head at its distance from the plate? ",
                        _ => "",
                    };
                    let start = if first.is_empty() { "start" } else { "Start" };
                    self.blocks.push(Block::Stop(format!(
                        "Setup {}: {first}{start} the recording. Then cycle start.",
                        setup.name
                    )));
                }
            }
            Step::Part { setup, to } => {
                let setup = &self.cycle.setups[*setup];
                let held = match setup.instrument {
                    InstrumentKind::BallBar => Some("take the bar out"),
                    InstrumentKind::LaserBallBar | InstrumentKind::PassiveArm => {
                        Some("disconnect it from the spindle")
                    }
                    _ => None,
                };
                if let Some(held) = held {
                    self.blocks.push(Block::Stop(format!("Setup {}: {held}. Then cycle start.", setup.name)));
                }
                self.feed(to, &Joint::LINEAR, JOIN_MM_PER_MIN)?;
            }
            Step::Transfer { pieces } => {
                pieces.iter().try_for_each(|(end, seconds)| self.timed(end, *seconds))?;
            }
            Step::Dwell { seconds } => self.dwell(*seconds),
            Step::Wait { seconds, reason } => {
                self.blocks.push(Block::Remark((*reason).into()));
                self.dwell(*seconds);
            }
            Step::SyncMove { axis, pieces } => {
                self.blocks.push(Block::Remark(format!("synchronisation move of axis {axis}")));
                pieces.iter().try_for_each(|(end, seconds)| self.timed(end, *seconds))?;
            }
            Step::Sweep { turning, feed, piece_s, ends } => {
                let deg_per_min = convert::deg_from_rad(*feed) * 60.0;
                let what = turning.map_or("pass along the curve".into(), |axis| format!("pass of {axis}"));
                self.blocks.push(Block::Remark(format!(
                    "{what} at {deg_per_min:+.0} deg/min, {:.1} s with run-in and run-out",
                    piece_s * ends.len() as f64
                )));
                self.shortest_s = Some(self.shortest_s.map_or(*piece_s, |shortest| shortest.min(*piece_s)));
                ends.iter().try_for_each(|end| self.timed(end, *piece_s))?;
            }
        }
        Ok(())
    }

    /// First in height, then the rotary axes, then over the place. Tool centre point control is switched on there, with the rotary axes at zero.
    fn above(&mut self, at: &AxisValues<f64>) -> Result<(), VisitError> {
        let first = match self.rules.tool_point && !self.keeps_tool_point {
            true => {
                let mut upright = self.programmed(at)?;
                Joint::ROTARY.into_iter().for_each(|letter| upright[letter] = 0.0);
                self.cycle.within_travel(self.machine, &upright)?;
                upright
            }
            false => *at,
        };
        let rising =
            |letter: &Joint| self.machine.axis(*letter).is_some_and(|axis| axis.direction.z.abs() > 0.5);
        let (up, across): (Vec<Joint>, Vec<Joint>) = Joint::LINEAR.into_iter().partition(rising);
        let across = if self.keeps_tool_point { Joint::LINEAR.to_vec() } else { across };
        self.feed(&first, &up, FREE_MM_PER_MIN)?;
        self.turn(&first)?;
        self.feed(&first, &across, FREE_MM_PER_MIN)?;
        if self.rules.tool_point && !self.keeps_tool_point {
            self.blocks.push(Block::ToolPoint(true));
            self.keeps_tool_point = true;
            self.turn(at)?;
        }
        Ok(())
    }

    /// The rotary axes of the free spindle. Under tool centre point control the tool point goes with the table: a feed would be that of the one or
    /// the other, by the control, a duration is not.
    fn turn(&mut self, to: &AxisValues<f64>) -> Result<(), VisitError> {
        let Some(at) = self.at.filter(|_| self.keeps_tool_point) else {
            return self.feed(to, &Joint::ROTARY, FREE_DEG_PER_MIN);
        };
        let travel = |letter: Joint| convert::deg_from_rad(to[letter] - at[letter]);
        let seconds = Joint::ROTARY.into_iter().map(travel).fold(0.0, f64::hypot) / FREE_DEG_PER_MIN * 60.0;
        if seconds == 0.0 {
            return Ok(());
        }
        let there = tool_point::turned(self.machine, &at, to).ok_or_else(|| self.cannot_follow())?;
        self.timed(&there, seconds)
    }

    fn feed(&mut self, to: &AxisValues<f64>, letters: &[Joint], per_min: f64) -> Result<(), VisitError> {
        if target(self.machine, to, letters).is_empty() {
            return Ok(());
        }
        let there = match self.at {
            Some(at) => {
                let way = |letter: &Joint| {
                    let travel = to[*letter] - at[*letter];
                    if letter.is_rotary() { convert::deg_from_rad(travel) } else { travel }
                };
                self.seconds += letters.iter().map(way).fold(0.0, f64::hypot) / per_min * 60.0;
                let mut there = at;
                letters.iter().for_each(|&letter| there[letter] = to[letter]);
                Some(there)
            }
            None => letters.contains(&Joint::X).then_some(*to),
        };
        self.at = there;
        let to = match there.filter(|_| self.keeps_tool_point) {
            Some(there) => target(self.machine, &self.programmed(&there)?, &Joint::LINEAR),
            None => target(self.machine, to, letters),
        };
        self.blocks.push(Block::Feed { to, per_min });
        Ok(())
    }

    fn timed(&mut self, to: &AxisValues<f64>, seconds: f64) -> Result<(), VisitError> {
        self.seconds += seconds;
        self.at = Some(*to);
        let written = if self.keeps_tool_point { self.programmed(to)? } else { *to };
        self.blocks.push(Block::Timed { to: target(self.machine, &written, &Joint::ALL), seconds });
        Ok(())
    }

    fn programmed(&self, at: &AxisValues<f64>) -> Result<AxisValues<f64>, VisitError> {
        tool_point::programmed(self.machine, at).ok_or_else(|| self.cannot_follow())
    }

    fn cannot_follow(&self) -> VisitError {
        self.cycle.cannot_follow(self.machine, 0)
    }

    fn dwell(&mut self, seconds: f64) {
        self.seconds += seconds;
        self.blocks.push(Block::Dwell { seconds });
    }
}

/// Positions of the axes the machine has, mm and degrees.
fn target(machine: &Machine, position: &AxisValues<f64>, letters: &[Joint]) -> Target {
    let edge = |letter: Joint| match letter.is_rotary() {
        true => convert::deg_from_rad(position[letter]),
        false => position[letter],
    };
    let has = |letter: &Joint| machine.axis(*letter).is_some();
    letters.iter().copied().filter(has).map(|letter| (letter, edge(letter))).collect()
}

/// How far the free spindle is above the highest ball of the table, mm: the least of its stops.
fn clear_mm(cycle: &Cycle, machine: &Machine, steps: &[Step]) -> f64 {
    let none = JointErrors::default();
    let mut least_mm = f64::INFINITY;
    let mut above = None;
    for step in steps {
        match (step, above) {
            (Step::Above { at }, _) => above = Some(at),
            (Step::Join { setup, .. }, Some(at)) => {
                let ball = |setup: &Setup| (machine.machine_from_table(at, &none) * setup.ball_in_table_mm).z;
                let highest_mm = cycle.setups.iter().map(ball).fold(f64::NEG_INFINITY, f64::max);
                let tip = machine.machine_from_tool(at, &none) * cycle.setups[*setup].ball_in_tool_mm;
                least_mm = least_mm.min(tip.z - highest_mm);
            }
            _ => {}
        }
    }
    least_mm
}

fn header(
    cycle: &Cycle,
    machine: &Machine,
    rules: &CourseRules,
    program: &Program,
    clear_mm: f64,
) -> Vec<String> {
    let mut lines = vec![format!(
        "Measuring cycle {}, machine {}. About {} minutes without stops.",
        cycle.name,
        machine.name,
        whole_minutes(program.duration_s)
    )];
    for setup in &cycle.setups {
        lines.push(format!("Setup {}.", mounting(setup)));
    }
    if cycle.run_kind() == RunKind::OnTheFly {
        lines.push(format!(
            "On the fly: straight blocks at most {} um off the path of the tool point; shortest block {:.1} ms. \
             Recording begins and ends with {} strokes of {} mm there and back (synchronisation move).",
            convert::um_from_mm(rules.chord_mm),
            program.shortest_block_s.unwrap_or_default() * 1e3,
            rules.strokes,
            rules.stroke_mm,
        ));
    }
    lines.push("Check before the start:".into());
    let offset = cycle.setups.iter().any(|setup| setup.ball_in_tool_mm != Point3::origin());
    let programmed = match offset {
        false => "the centre of ball or nest in the spindle, on the spindle line",
        true => "the tool point of the machine file; ball or nest stands off it as the setups say",
    };
    lines.push(match program.tool_point {
        false => format!("1. Tool length and all tool offsets are zero: the programmed point is {programmed}."),
        true => format!("1. The tool data hold the length of the tool in the spindle, all other offsets are zero: the programmed point is {programmed}."),
    });
    let centre = machine.rotary().last().map_or("the origin of the machine file".to_string(), |axis| {
        let [x, y, z] = axis.through_mm.coords.into();
        format!(
            "the origin of the machine file (the line of {} goes through X{x} Y{y} Z{z} of it)",
            axis.letter
        )
    });
    lines.push(format!("2. Work offset G54 (preset): with all axes at 0 that point is in {centre}."));
    lines.push(format!(
        "3. Senses: {}.",
        machine.axes().map(|axis| sense(machine, axis)).collect::<Vec<_>>().join("; ")
    ));
    lines.push(match program.tool_point {
        false => "4. Five-axis transformation and tool-point following (TCP, RTCP, TRAORI, M128) are off; linear axes follow by the program.",
        true => "4. The program switches tool centre point control on with the spindle up: positions then are of the programmed point over the table. Run it once without instrument, in single block.",
    }.into());
    lines.push(format!(
        "5. Spindle retracted and locked, way free up to {clear_mm:.0} mm above the highest ball; feed override 100 percent while it measures."
    ));
    lines
}

fn sense(machine: &Machine, axis: &Axis) -> String {
    let along = axis.direction.into_inner() * axis.sense;
    let k = along.iamax();
    let sign = if along[k] < 0.0 { '-' } else { '+' };
    let towards = ["X", "Y", "Z"][k];
    let part = match machine.side(axis.letter) {
        Some(Side::Table) => "table",
        _ => "tool",
    };
    if axis.is_rotary() {
        format!("{}+ turns the {part} right-handed about {sign}{towards}", axis.letter)
    } else {
        format!("{}+ moves the {part} to {sign}{towards}", axis.letter)
    }
}

fn mounting(setup: &Setup) -> String {
    let [x, y, z] = setup.ball_in_table_mm.coords.into();
    let [dx, dy, dz]: [f64; 3] = setup.ball_in_tool_mm.coords.into();
    let off = match setup.ball_in_tool_mm == Point3::origin() {
        true => String::new(),
        false => format!(" (in the spindle at X{dx} Y{dy} Z{dz} of the tool point)"),
    };
    let place = format!("at X{x} Y{y} Z{z} of the table{off}");
    let name = &setup.name;
    match (setup.instrument, setup.nest) {
        (InstrumentKind::RTest, NestSide::Table) => {
            format!("{name}: R-test, nest {place}, ball in the spindle")
        }
        (InstrumentKind::RTest, NestSide::Spindle) => {
            format!("{name}: R-test, ball {place}, nest in the spindle")
        }
        (InstrumentKind::BallBar, _) => {
            let length_mm = setup.bar_length_mm.unwrap_or_default();
            format!("{name}: ball bar of {length_mm} mm, its ball {place}, the other in the spindle")
        }
        (kind, _) => format!("{name}: {} {place}", kind.name()),
    }
}
