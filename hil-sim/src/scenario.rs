//! A cycle on the virtual machine: the motion of the CNC, and what the probes see along it.

use crate::devices::SimulatedCell;
use crate::motion::{Follow, Program, ProgramError, Step, Trajectory};
use crate::physics::{Sampler, VirtualMachine};
use std::sync::Arc;
use trunnion_core::{AxisValues, Joint, State};
use trunnion_machine::Machine;

/// Noise of one sample of a probe, mm: averaged away at rest, seen on the fly.
const SAMPLE_NOISE_MM: f64 = 0.2e-3;
/// Standing before the first and after the last motion, s.
const MARGIN_S: f64 = 0.4;
/// Ramps of a sweep, s.
const RAMP_S: f64 = 0.4;
/// The synchronisation move before and after a sweep cycle: strokes of X there and back, as the program writer of the product puts them.
const STROKE_MM: f64 = 0.2;
const STROKE_S: f64 = 0.2;
const STROKES: usize = 3;
const SYNC_MOVE_PAUSE_S: f64 = 1.0;

/// One pose of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Index of the setup.
    pub setup: usize,
    /// All axes, mm and rad.
    pub position: AxisValues<f64>,
}

/// Times of a static cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// From one pose to the next, s.
    pub move_s: f64,
    /// Standing at a pose, s.
    pub dwell_s: f64,
}

/// A scenario that cannot be run.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ScenarioError {
    /// No pose.
    #[error("a cycle needs at least one pose")]
    NoStation,
    /// The program is impossible.
    #[error("the simulated controller refuses the program")]
    Program(#[from] ProgramError),
}

/// How long a static cycle takes, s.
pub fn duration_s(stations: usize, pace: Pace) -> f64 {
    2.0 * MARGIN_S + stations as f64 * (pace.move_s + pace.dwell_s)
}

/// The machine visits the poses and rests at each.
///
/// # Errors
/// No pose, or times no machine can keep.
pub fn static_cycle(
    machine: Arc<VirtualMachine>,
    program: &str,
    stations: &[Station],
    pace: Pace,
) -> Result<SimulatedCell, ScenarioError> {
    let first = stations.first().ok_or(ScenarioError::NoStation)?;
    let mut steps = vec![Step::Dwell { duration_s: MARGIN_S }];
    let mut setup_of_step = vec![first.setup];
    let mut before = *first;
    for station in stations {
        if station.setup != before.setup {
            // The ball has been placed again: straight to its first pose.
            steps.push(Step::Move { target: station.position, duration_s: pace.move_s });
        } else {
            let follow = follow(machine.machine(), &machine, station.setup);
            steps.push(Step::Carry { target: station.position, duration_s: pace.move_s, follow });
        }
        steps.push(Step::Dwell { duration_s: pace.dwell_s });
        setup_of_step.extend([station.setup, station.setup]);
        before = *station;
    }
    steps.push(Step::Dwell { duration_s: MARGIN_S });
    setup_of_step.push(before.setup);
    let start = Program { start: first.position, steps };
    Ok(cell(machine, program, Trajectory::compile(&start)?, setup_of_step, Readings::Settled))
}

/// One rotary axis turns forward and back at each feed while the linear axes follow the ball of setup 0; strokes of X before and
/// after. The other rotary axes go from the first to the second of their angles in step with it.
///
/// # Errors
/// Feeds or angles no machine can keep.
pub fn sweep_cycle(
    machine: Arc<VirtualMachine>,
    program: &str,
    axis: Joint,
    from_to_rad: (f64, f64),
    feeds_rad_per_s: &[f64],
    others: &AxisValues<(f64, f64)>,
) -> Result<SimulatedCell, ScenarioError> {
    let (from, to) = from_to_rad;
    let (of_follow, others) = (Arc::clone(&machine), *others);
    let at = move |angle_rad: f64| {
        let share = (angle_rad - from) / (to - from);
        let mut rotary =
            AxisValues::from_fn(|letter| others[letter].0 + share * (others[letter].1 - others[letter].0));
        rotary[axis] = angle_rad;
        at_ball(of_follow.machine(), &of_follow, 0, &rotary)
    };
    let start = at(from);
    let follow = Follow::new(move |axes| at(axes[axis]));
    let mut steps = sync_move(&start);
    for &feed in feeds_rad_per_s {
        for (from, to) in [(from, to), (to, from)] {
            steps.push(Step::Sweep { axis, from, to, feed, ramp_s: RAMP_S, follow: follow.clone() });
            steps.push(Step::Dwell { duration_s: MARGIN_S });
        }
    }
    // The passes end where they began.
    steps.extend(sync_move(&start));
    let setup_of_step = vec![0; steps.len()];
    let trajectory = Trajectory::compile(&Program { start, steps })?;
    Ok(cell(machine, program, trajectory, setup_of_step, Readings::Streamed))
}

/// Strokes of X about where the machine stands.
fn sync_move(stand: &AxisValues<f64>) -> Vec<Step> {
    let mut there = *stand;
    there[Joint::X] += STROKE_MM;
    let pause = || Step::Dwell { duration_s: SYNC_MOVE_PAUSE_S };
    let strokes =
        (0..STROKES).flat_map(|_| [there, *stand]).map(|target| Step::Move { target, duration_s: STROKE_S });
    std::iter::once(pause()).chain(strokes).chain([pause()]).collect()
}

fn follow(nominal: &Machine, machine: &Arc<VirtualMachine>, setup: usize) -> Follow {
    let (nominal, machine) = (nominal.clone(), Arc::clone(machine));
    Follow::new(move |axes| at_ball(&nominal, &machine, setup, axes))
}

/// The linear axes bring the tool to the ball; the length of a bar before it in X of the machine.
fn at_ball(
    nominal: &Machine,
    machine: &VirtualMachine,
    setup: usize,
    axes: &AxisValues<f64>,
) -> AxisValues<f64> {
    let placed = &machine.truth().setups[setup].setup;
    let mut at = nominal.follow(axes, &placed.ball_in_table_mm).unwrap_or(*axes);
    if placed.instrument.kind.keeps_bar_length() {
        at[Joint::X] += placed.instrument.length_mm;
    }
    at
}

/// What is drawn once for a whole step.
#[derive(Clone, Copy)]
enum Readings {
    /// Everything: a pose is one reading, and may be an outlier.
    Settled,
    /// What does not change during a pass: its samples have white noise of their own, and one that is off is no pass that is off.
    Streamed,
}

fn cell(
    machine: Arc<VirtualMachine>,
    program: &str,
    trajectory: Trajectory,
    setup_of_step: Vec<usize>,
    readings: Readings,
) -> SimulatedCell {
    // Pass offsets, drift, scatter and outliers are drawn once for each step, in order of time, so that whoever asks
    // for a time gets the same answer.
    let mut sampler = Sampler::new(&machine, 0);
    let offsets_mm: Vec<[f64; 3]> = setup_of_step
        .iter()
        .enumerate()
        .map(|(step, &setup)| {
            let begin_s = trajectory.begin_s(step).unwrap_or(0.0);
            let end_s = trajectory.begin_s(step + 1).unwrap_or(begin_s);
            let time_s = 0.5 * (begin_s + end_s);
            let state = trajectory.at(time_s).state(time_s, Vec::new(), setup);
            let noisy = match readings {
                Readings::Settled => sampler.read_mm(&machine, &state),
                Readings::Streamed => sampler.still_mm(&machine, &state),
            };
            let ideal = machine.ideal_reading_mm(setup, &state);
            std::array::from_fn(|k| noisy[k] - ideal[k])
        })
        .collect();
    let seed = machine.truth().seed;
    let along = trajectory.clone();
    let is_bar = machine.truth().setups[0].setup.instrument.kind.keeps_bar_length();
    let reading_mm = Arc::new(move |state: &State| -> [f64; 3] {
        let step = along.at(state.time_s.unwrap_or(0.0)).step.min(setup_of_step.len() - 1);
        let ideal = machine.ideal_reading_mm(setup_of_step[step], state);
        std::array::from_fn(|k| ideal[k] + offsets_mm[step][k])
    });
    let of_bar = Arc::clone(&reading_mm);
    SimulatedCell {
        program: program.into(),
        deflection_mm: Box::new(move |state| if is_bar { [0.0; 3] } else { reading_mm(state) }),
        bar_mm: Box::new(move |state| if is_bar { of_bar(state)[0] } else { 0.0 }),
        noise_mm: SAMPLE_NOISE_MM,
        seed,
        ..SimulatedCell::along(trajectory)
    }
}
