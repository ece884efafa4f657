//! A compiled program: everything about the axes as a pure function of time.

use super::path::Path;
use super::profile::Profile;
use super::program::{Program, ProgramError, Step};
use trunnion_core::{AxisValues, Joint, State};

/// What the axes do at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Kinematics {
    /// Positions, mm and rad.
    pub position: AxisValues<f64>,
    /// Velocities, mm/s and rad/s.
    pub velocity: AxisValues<f64>,
    /// Accelerations, mm/s² and rad/s².
    pub acceleration: AxisValues<f64>,
    /// Direction of motion, at rest that of the last motion: −1, +1; 0 before an axis first moves.
    pub direction: AxisValues<f64>,
    /// Travel since the axis last turned round (since the start when it never did), mm and rad.
    pub since_reversal: AxisValues<f64>,
    /// Index of the step in the program; after the end the last one.
    pub step: usize,
    /// False before the start and after the end.
    pub running: bool,
}

impl Kinematics {
    /// The state an effect depends on, at `time_s` of the run.
    pub fn state(&self, time_s: f64, temperature_degc: Vec<f64>, setup: usize) -> State {
        State {
            position: self.position,
            direction: self.direction,
            velocity: self.velocity,
            acceleration: self.acceleration,
            since_reversal: self.since_reversal,
            time_s: Some(time_s),
            temperature_degc,
            setup,
            ..State::default()
        }
    }
}

/// A compiled [`Program`].
#[derive(Debug, Clone)]
pub struct Trajectory {
    segments: Vec<Segment>,
    end: Memory,
    end_position: AxisValues<f64>,
    duration_s: f64,
}

#[derive(Debug, Clone)]
struct Segment {
    begin_s: f64,
    profile: Profile,
    path: Path,
    /// What the axes did before.
    memory: Memory,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Memory {
    direction: AxisValues<f64>,
    since_reversal: AxisValues<f64>,
}

impl Trajectory {
    /// Checks the program and lays out its motion from time 0 on.
    pub fn compile(program: &Program) -> Result<Self, ProgramError> {
        check_finite(0, &program.start)?;
        let mut segments = Vec::with_capacity(program.steps.len());
        let mut position = program.start;
        let mut memory = Memory::default();
        let mut begin_s = 0.0;
        for (index, step) in program.steps.iter().enumerate() {
            let (path, profile) = lay_out(index, step, &position)?;
            let segment = Segment { begin_s, profile, path, memory };
            begin_s += profile.duration_s();
            if !matches!(step, Step::Dwell { .. }) {
                position = segment.path.at(1.0);
                memory = segment.memory_at(1.0, &position);
            }
            segments.push(segment);
        }
        Ok(Self { segments, end: memory, end_position: position, duration_s: begin_s })
    }

    /// When the last step ends, s.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// When a step begins, s; `None` when the program has no such step.
    pub fn begin_s(&self, step: usize) -> Option<f64> {
        self.segments.get(step).map(|segment| segment.begin_s)
    }

    /// What the axes do at `t_s`. Before the start they stand where the program starts, after the end where it ends.
    pub fn at(&self, t_s: f64) -> Kinematics {
        let begun = self.segments.partition_point(|segment| segment.begin_s <= t_s);
        let running = t_s >= 0.0 && t_s < self.duration_s;
        match (begun.checked_sub(1), self.segments.first()) {
            (Some(step), _) if running => self.segments[step].at(t_s, step),
            (None, Some(first)) => at_rest(first.path.at(0.0), Memory::default(), 0),
            _ => at_rest(self.end_position, self.end, self.segments.len().saturating_sub(1)),
        }
    }
}

impl Segment {
    fn at(&self, t_s: f64, step: usize) -> Kinematics {
        let progress = self.profile.at(t_s - self.begin_s);
        let position = self.path.at(progress.u);
        let Memory { direction, since_reversal } = self.memory_at(progress.u, &position);
        let (first, second) = self.path.derivatives(progress.u);
        let (u_dot, u_ddot) = (progress.u_dot, progress.u_ddot);
        Kinematics {
            position,
            velocity: AxisValues::from_fn(|axis| first[axis] * u_dot),
            acceleration: AxisValues::from_fn(|axis| first[axis] * u_ddot + second[axis] * u_dot * u_dot),
            direction,
            since_reversal,
            step,
            running: true,
        }
    }

    fn memory_at(&self, u: f64, position: &AxisValues<f64>) -> Memory {
        let mut memory = self.memory;
        for axis in Joint::ALL {
            let here = self.path.travel(axis, u, position[axis]);
            if here.direction == 0.0 {
                // Exactly at a turning point the direction is still that of the way there; nothing is travelled yet.
                if here.turned {
                    memory.since_reversal[axis] = 0.0;
                }
                continue;
            }
            let goes_on = !here.turned && memory.direction[axis] * here.direction >= 0.0;
            let before = if goes_on { memory.since_reversal[axis] } else { 0.0 };
            memory.direction[axis] = here.direction;
            memory.since_reversal[axis] = before + here.travel;
        }
        memory
    }
}

fn at_rest(position: AxisValues<f64>, memory: Memory, step: usize) -> Kinematics {
    Kinematics {
        position,
        velocity: AxisValues::default(),
        acceleration: AxisValues::default(),
        direction: memory.direction,
        since_reversal: memory.since_reversal,
        step,
        running: false,
    }
}

fn lay_out(index: usize, step: &Step, position: &AxisValues<f64>) -> Result<(Path, Profile), ProgramError> {
    let positive = |what, found: f64| {
        let ok = found.is_finite() && found > 0.0;
        if ok { Ok(found) } else { Err(ProgramError::NotPositive { step: index, what, found }) }
    };
    match step {
        Step::Dwell { duration_s } => {
            let duration_s = positive("duration_s", *duration_s)?;
            Ok((Path::straight(*position, *position), Profile::Still { duration_s }))
        }
        Step::Move { target, duration_s } => {
            check_finite(index, target)?;
            let duration_s = positive("duration_s", *duration_s)?;
            Ok((Path::straight(*position, *target), Profile::RestToRest { duration_s }))
        }
        Step::Line { target, duration_s } => {
            check_finite(index, target)?;
            let duration_s = positive("duration_s", *duration_s)?;
            Ok((Path::straight(*position, *target), Profile::Uniform { duration_s }))
        }
        Step::Carry { target, duration_s, follow } => {
            let to = AxisValues::from_fn(|axis| if axis.is_rotary() { target[axis] } else { position[axis] });
            check_finite(index, &to)?;
            let duration_s = positive("duration_s", *duration_s)?;
            let path = Path::followed(*position, to, follow.clone());
            check_joined(index, position, &path)?;
            Ok((path, Profile::RestToRest { duration_s }))
        }
        Step::Sweep { axis, from, to, feed, ramp_s, follow } => {
            let (mut begin, mut end) = (*position, *position);
            (begin[*axis], end[*axis]) = (*from, *to);
            check_finite(index, &begin)?;
            check_finite(index, &end)?;
            let length = positive("length of the sweep", (to - from).abs())?;
            let profile = Profile::cruise(length, positive("feed", *feed)?, positive("ramp_s", *ramp_s)?);
            let path = Path::followed(begin, end, follow.clone());
            check_joined(index, position, &path)?;
            Ok((path, profile))
        }
    }
}

fn check_finite(step: usize, position: &AxisValues<f64>) -> Result<(), ProgramError> {
    match Joint::ISO.into_iter().find(|&axis| !position[axis].is_finite()) {
        Some(axis) => Err(ProgramError::NotFinite { step, axis }),
        None => Ok(()),
    }
}

/// A step must begin where the one before ended, to within what a followed path rounds.
fn check_joined(step: usize, ended: &AxisValues<f64>, path: &Path) -> Result<(), ProgramError> {
    let begins = path.at(0.0);
    check_finite(step, &begins)?;
    check_finite(step, &path.at(1.0))?;
    match Joint::ISO.into_iter().find(|&axis| (begins[axis] - ended[axis]).abs() > 1e-6) {
        Some(axis) => Err(ProgramError::Jump { step, axis, begins: begins[axis], ended: ended[axis] }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Follow;
    use super::*;
    use std::f64::consts::{PI, TAU};
    use trunnion_core::axis::iso::{B, C, X, Y};

    /// The ball on a table turning about Z by C, at radius 100.
    fn circle() -> Follow {
        Follow::new(|axes| {
            let mut axes = *axes;
            (axes[X], axes[Y]) = (100.0 * axes[C].cos(), 100.0 * axes[C].sin());
            axes
        })
    }

    fn axes(list: &[(Joint, f64)]) -> AxisValues<f64> {
        let mut axes = AxisValues::default();
        list.iter().for_each(|&(axis, value)| axes[axis] = value);
        axes
    }

    fn program() -> Trajectory {
        let sweep = |from, to| Step::Sweep { axis: C, from, to, feed: 1.0, ramp_s: 0.2, follow: circle() };
        Trajectory::compile(&Program {
            start: axes(&[]),
            steps: vec![
                Step::Move { target: axes(&[(X, 100.0)]), duration_s: 2.0 },
                Step::Dwell { duration_s: 0.5 },
                sweep(0.0, TAU),
                sweep(TAU, PI),
                Step::Carry { target: axes(&[(B, 0.3), (C, PI)]), duration_s: 1.0, follow: circle() },
            ],
        })
        .unwrap()
    }

    #[test]
    fn velocity_and_acceleration_are_the_derivatives_of_the_position() {
        let (motion, h) = (program(), 1e-4);
        for k in 1..400 {
            let t = motion.duration_s() * f64::from(k) / 400.0 + 1e-3;
            let (before, here, after) = (motion.at(t - h), motion.at(t), motion.at(t + h));
            for axis in Joint::ALL {
                let velocity = (after.position[axis] - before.position[axis]) / (2.0 * h);
                let acceleration = (after.velocity[axis] - before.velocity[axis]) / (2.0 * h);
                assert!((velocity - here.velocity[axis]).abs() < 2e-3, "{axis} at {t}");
                assert!((acceleration - here.acceleration[axis]).abs() < 0.5, "{axis} at {t}");
            }
        }
    }

    #[test]
    fn a_swept_axis_keeps_its_feed_and_its_followers_the_circle() {
        let motion = program();
        let t = motion.begin_s(2).unwrap() + 3.0;
        let here = motion.at(t);
        assert!((here.velocity[C] - 1.0).abs() < 1e-9);
        assert!((here.position[X].hypot(here.position[Y]) - 100.0).abs() < 1e-9);
        // v = ω r, a = ω² r
        assert!((here.velocity[X].hypot(here.velocity[Y]) - 100.0).abs() < 1e-4);
        assert!((here.acceleration[X].hypot(here.acceleration[Y]) - 100.0).abs() < 1e-3);
    }

    #[test]
    fn direction_and_travel_since_reversal_are_remembered_across_steps() {
        let motion = program();
        let back = motion.begin_s(3).unwrap();
        let before = motion.at(back - 1e-9);
        assert_eq!((before.direction[C], before.direction[X]), (1.0, 1.0));
        assert!((before.since_reversal[C] - TAU).abs() < 1e-9);
        // X turned at C = π (−100) and has come back to +100.
        assert!((before.since_reversal[X] - 200.0).abs() < 1e-6);
        // Y turned last at 3π/2 (−100).
        assert!((before.since_reversal[Y] - 100.0).abs() < 1e-6);
        let after = motion.at(back + 1.0);
        assert_eq!((after.direction[C], after.direction[X]), (-1.0, -1.0));
        assert!((after.since_reversal[C] - (TAU - after.position[C])).abs() < 1e-9);
        let dwell = motion.at(motion.begin_s(1).unwrap() + 0.2);
        assert_eq!((dwell.direction[X], dwell.since_reversal[X], dwell.direction[C]), (1.0, 100.0, 0.0));
        let end = motion.at(1e6);
        assert!(!end.running && end.step == 4 && end.direction[B] == 1.0 && end.direction[C] == -1.0);
    }

    #[test]
    fn lines_in_a_row_are_travelled_at_their_speeds_without_a_stop_between() {
        let line = |x, duration_s| Step::Line { target: axes(&[(X, x)]), duration_s };
        let program = Program { start: axes(&[]), steps: vec![line(1.0, 0.5), line(2.0, 0.25)] };
        let motion = Trajectory::compile(&program).unwrap();
        let velocity = |t_s: f64| motion.at(t_s).velocity[X];
        assert_eq!([velocity(0.0), velocity(0.49), velocity(0.51), velocity(0.74)], [2.0, 2.0, 4.0, 4.0]);
        assert_eq!((motion.at(0.25).position[X], motion.duration_s()), (0.5, 0.75));
    }

    #[test]
    fn a_program_that_would_jump_is_refused() {
        let steps =
            vec![Step::Sweep { axis: C, from: 0.1, to: 1.0, feed: 1.0, ramp_s: 0.1, follow: Follow::none() }];
        let error = Trajectory::compile(&Program { start: axes(&[]), steps }).unwrap_err();
        assert_eq!(error, ProgramError::Jump { step: 0, axis: C, begins: 0.1, ended: 0.0 });
        let steps = vec![Step::Dwell { duration_s: 0.0 }];
        let error = Trajectory::compile(&Program { start: axes(&[]), steps }).unwrap_err();
        assert_eq!(error, ProgramError::NotPositive { step: 0, what: "duration_s", found: 0.0 });
    }
}
