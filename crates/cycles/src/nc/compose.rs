//! From the steps of a cycle to the blocks of a program, with a header that says what has to be right before the start.

use super::program::{Block, Program, Target};
use crate::{CourseRules, Step, VisitError};
use crate::{Cycle, RunKind};
use nalgebra::Point3;
use trunnion_core::{AxisValues, InstrumentKind, Joint, NestSide, Setup, convert};
use trunnion_machine::{Axis, Machine, Side};

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
    /// A cycle that the machine cannot run.
    pub fn of_cycle(cycle: &Cycle, machine: &Machine, rules: &CourseRules) -> Result<Self, VisitError> {
        let steps = cycle.course(machine, rules)?;
        let mut writer =
            Writer { cycle, machine, blocks: Vec::new(), seconds: 0.0, shortest_s: None, at: None };
        for step in &steps {
            writer.step(step);
        }
        let sweeps = steps.iter().any(|step| matches!(step, Step::Sweep { .. }));
        let mut program = Self {
            name: cycle.name.clone(),
            header: Vec::new(),
            tolerance_mm: if sweeps { rules.chord_mm } else { rules.transfer_chord_mm },
            blocks: writer.blocks,
            duration_s: writer.seconds,
            shortest_block_s: writer.shortest_s,
        };
        program.header = header(cycle, machine, rules, &program);
        Ok(program)
    }
}

struct Writer<'a> {
    cycle: &'a Cycle,
    machine: &'a Machine,
    blocks: Vec<Block>,
    /// Running time so far, s.
    seconds: f64,
    shortest_s: Option<f64>,
    at: Option<AxisValues<f64>>,
}

impl Writer<'_> {
    fn step(&mut self, step: &Step) {
        match step {
            Step::Above { at } => self.above(at),
            Step::Fit { setups } => {
                let setups: Vec<String> =
                    setups.iter().map(|&setup| mounting(&self.cycle.setups[setup])).collect();
                self.blocks.push(Block::Stop(format!("Mount {}. Then cycle start.", setups.join("; and "))));
            }
            Step::Join { setup, at, attended } => {
                self.feed(at, &Joint::LINEAR, JOIN_MM_PER_MIN);
                let setup = &self.cycle.setups[*setup];
                if *attended {
                    self.blocks.push(Block::Stop(match setup.instrument {
                        InstrumentKind::RTest => format!(
                            "Setup {}: all probes in range? Start the recording. Then cycle start.",
                            setup.name
                        ),
                        InstrumentKind::BallBar => format!(
                            "Setup {}: put the bar between the balls. Start the recording. Then cycle start.",
                            setup.name
                        ),
                        _ => format!("Setup {}: start the recording. Then cycle start.", setup.name),
                    }));
                }
            }
            Step::Part { setup, to } => {
                let setup = &self.cycle.setups[*setup];
                if setup.instrument == InstrumentKind::BallBar {
                    self.blocks.push(Block::Stop(format!(
                        "Setup {}: take the bar out. Then cycle start.",
                        setup.name
                    )));
                }
                self.feed(to, &Joint::LINEAR, JOIN_MM_PER_MIN);
            }
            Step::Transfer { pieces } => pieces.iter().for_each(|(end, seconds)| self.timed(end, *seconds)),
            Step::Dwell { seconds } => self.dwell(*seconds),
            Step::Wait { seconds, reason } => {
                self.blocks.push(Block::Remark((*reason).into()));
                self.dwell(*seconds);
            }
            Step::SyncMove { axis, pieces } => {
                self.blocks.push(Block::Remark(format!("synchronisation move of axis {axis}")));
                pieces.iter().for_each(|(end, seconds)| self.timed(end, *seconds));
            }
            Step::Sweep { turning, feed, piece_s, ends } => {
                let deg_per_min = convert::deg_from_rad(*feed) * 60.0;
                let what = turning.map_or("pass along the curve".into(), |axis| format!("pass of {axis}"));
                self.blocks.push(Block::Remark(format!(
                    "{what} at {deg_per_min:+.0} deg/min, {:.1} s with run-in and run-out",
                    piece_s * ends.len() as f64
                )));
                self.shortest_s = Some(self.shortest_s.map_or(*piece_s, |shortest| shortest.min(*piece_s)));
                ends.iter().for_each(|end| self.timed(end, *piece_s));
            }
        }
    }

    /// First in height, then the rotary axes, then over the place.
    fn above(&mut self, at: &AxisValues<f64>) {
        let rising =
            |letter: &Joint| self.machine.axis(*letter).is_some_and(|axis| axis.direction.z.abs() > 0.5);
        let (up, across): (Vec<Joint>, Vec<Joint>) = Joint::LINEAR.into_iter().partition(rising);
        self.feed(at, &up, FREE_MM_PER_MIN);
        self.feed(at, &Joint::ROTARY, FREE_DEG_PER_MIN);
        self.feed(at, &across, FREE_MM_PER_MIN);
    }

    fn feed(&mut self, to: &AxisValues<f64>, letters: &[Joint], per_min: f64) {
        let target = target(self.machine, to, letters);
        if target.is_empty() {
            return;
        }
        if let Some(at) = &mut self.at {
            let way = |letter: &Joint| {
                let travel = to[*letter] - at[*letter];
                if letter.is_rotary() { convert::deg_from_rad(travel) } else { travel }
            };
            self.seconds += letters.iter().map(way).fold(0.0, f64::hypot) / per_min * 60.0;
            letters.iter().for_each(|&letter| at[letter] = to[letter]);
        } else if letters.contains(&Joint::X) {
            self.at = Some(*to);
        }
        self.blocks.push(Block::Feed { to: target, per_min });
    }

    fn timed(&mut self, to: &AxisValues<f64>, seconds: f64) {
        self.seconds += seconds;
        self.at = Some(*to);
        self.blocks.push(Block::Timed { to: target(self.machine, to, &Joint::ALL), seconds });
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

fn header(cycle: &Cycle, machine: &Machine, rules: &CourseRules, program: &Program) -> Vec<String> {
    let mut lines = vec![format!(
        "Measuring cycle {}, machine {}. About {:.0} minutes without stops.",
        cycle.name,
        machine.name,
        (program.duration_s / 60.0).ceil()
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
    lines
        .push(format!("1. Tool length and all tool offsets are zero: the programmed point is {programmed}."));
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
    lines.push("4. Five-axis transformation and tool-point following (TCP, RTCP, TRAORI, M128) are off; linear axes follow by the program.".into());
    lines.push(format!(
        "5. Spindle retracted and locked, way free up to {} mm above the highest ball; feed override 100 percent while it measures.",
        rules.clearance_mm
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
