//! A cycle as a controller runs it: its NC program as steps of the virtual machine, and which setup is mounted at each.

use crate::interpreter::{Event, interpret};
use trunnion_core::{AxisValues, convert};
use trunnion_cycles::nc::{Block, DIALECTS, Program};
use trunnion_cycles::{CourseRules, Cycle};
use trunnion_hil_sim::motion::{Program as Steps, Step, Trajectory};
use trunnion_machine::Machine;

/// The free spindle goes so many times as fast as programmed.
const HURRY: f64 = 20.0;

/// The program of a cycle, under way.
pub struct CycleProgram {
    pub trajectory: Trajectory,
    /// Which is mounted; none while the spindle is free.
    pub setup_of_step: Vec<Option<usize>>,
    /// The stops of the program (M0), s.
    pub stops_s: Vec<(f64, f64)>,
}

impl CycleProgram {
    /// A stop lasts until the operator has mounted ball, nest or bar, or taken the bar out.
    pub fn of(cycle: &Cycle, machine: &Machine, rules: &CourseRules, operator_s: f64) -> Self {
        let program = Program::of_cycle(cycle, machine, rules).unwrap();
        let dialect = DIALECTS[0];
        let mut stops = program.blocks.iter().filter_map(|block| match block {
            Block::Stop(message) => Some(message),
            _ => None,
        });
        let (mut steps, mut setup_of_step, mut stops_s) = (Vec::new(), Vec::new(), Vec::new());
        let (mut setup, mut now_s) = (None, 0.0);
        for event in interpret(dialect.name, &(dialect.write)(&program, dialect.decimals)) {
            let (step, duration_s) = match event {
                // The way to where the program begins.
                Event::Move { seconds, .. } if seconds <= 0.0 => continue,
                Event::Move { to, seconds } => {
                    // Nothing is measured then, and nothing can be hit.
                    let seconds = if setup.is_none() { seconds / HURRY } else { seconds };
                    (Step::Line { target: inside(&to), duration_s: seconds }, seconds)
                }
                Event::Dwell { seconds } => (Step::Dwell { duration_s: seconds }, seconds),
                Event::Stop(_) => {
                    // The message names the setup that is mounted, or whose bar is taken out.
                    let message = stops.next().unwrap();
                    let named =
                        cycle.setups.iter().position(|s| message.contains(&format!("Setup {}:", s.name)));
                    setup = named.filter(|_| !message.contains("take the bar out"));
                    stops_s.push((now_s, now_s + operator_s));
                    (Step::Dwell { duration_s: operator_s }, operator_s)
                }
            };
            now_s += duration_s;
            steps.push(step);
            setup_of_step.push(setup);
        }
        let trajectory = Trajectory::compile(&Steps { start: AxisValues::default(), steps }).unwrap();
        Self { trajectory, setup_of_step, stops_s }
    }
}

/// Positions as a program names them, in mm and rad.
fn inside(position: &AxisValues<f64>) -> AxisValues<f64> {
    AxisValues::from_fn(|letter| {
        if letter.is_rotary() { convert::rad_from_deg(position[letter]) } else { position[letter] }
    })
}
