//! A cycle: the poses to visit and the rules for reading there. `config/cycles/*.toml`.
//!
//! ```toml
//! format = "trunnion-cycle/1"
//! name = "two-feeds"
//! machine = "table-bc"
//! kind = "on-the-fly"                 # or "static" with [[grid]] and [settle]
//! passes = ["+", "-"]                 # forward and backward; on the fly both when not given
//!
//! [[setup]]                           # as in a points file
//! name = "low"
//! instrument = "r-test"
//! nest = "table"
//! ball_in_table_mm = [150.0, 0.0, 60.0]
//!
//! [sweep]
//! axis = "C"
//! from_deg = 0
//! to_deg = 360
//! feeds_deg_per_min = [1800, 3600]
//! b_deg = 0                           # or [-30, 30]: from first to last, in step with C
//!
//! [rounds]                            # may be left out: once, one setup after the other
//! count = 3                           # the whole cycle three times
//! wait_s = 600                        # dwell in between
//! interleave = true                   # pass by pass through all setups, which all stay mounted
//!
//! [bar]                               # may be left out; how a ball bar points from the table's ball to the tool's
//! direction = [1, 0, 0]
//! frame = "machine"                   # keeps its direction in the machine, or "table": turns with it
//! ```

pub mod course;
mod definition;
mod path;
mod read;
pub mod visit;
mod write;

pub use definition::{Bar, BarFrame, GridAxis, Motion, Pose, Rounds, Settle, Sweep};
pub use path::{Line, Path};

use crate::RunKind;
use definition::OVERRUN_MM;
use nalgebra::{Point3, Vector3};
use trunnion_core::setup::Setup;
use trunnion_core::{AxisValues, Joint};
use trunnion_machine::{JointErrors, Machine};

/// A cycle file, `format = "trunnion-cycle/1"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Name of the cycle.
    pub name: String,
    /// Machine name or path.
    pub machine: String,
    /// Setups in the order they are measured.
    pub setups: Vec<Setup>,
    /// What is done in each setup.
    pub motion: Motion,
    /// How often, and in which order of the setups.
    pub rounds: Rounds,
    /// Where ball bars point.
    pub bar: Bar,
}

impl Cycle {
    /// The poses of a static cycle in order; empty for one on the fly. `None` when the machine cannot
    /// follow the ball, or lacks an axis.
    pub fn poses(&self, machine: &Machine) -> Option<Vec<Pose>> {
        self.has_its_axes(machine).ok()?;
        let mut poses = Vec::new();
        for leg in self.legs() {
            for station in self.stations(machine, leg.setup, leg.pass) {
                let position = self.dwell_at(machine, leg.setup, &station)?;
                let mut direction = AxisValues::default();
                for axis in self.grid(machine) {
                    direction[axis.letter] = axis.overrun().map_or(0.0, |_| leg.pass);
                }
                poses.push(Pose { setup: leg.setup, target: station.target, position, direction });
            }
        }
        Some(poses)
    }

    /// How its points come about.
    pub fn run_kind(&self) -> RunKind {
        match self.motion {
            Motion::Static { .. } | Motion::Line { .. } => RunKind::Static,
            Motion::OnTheFly { .. } | Motion::Path { .. } => RunKind::OnTheFly,
        }
    }

    /// When a point may be read; `None` on the fly.
    pub fn settle(&self) -> Option<&Settle> {
        match &self.motion {
            Motion::Static { settle, .. } | Motion::Line { settle, .. } => Some(settle),
            Motion::OnTheFly { .. } | Motion::Path { .. } => None,
        }
    }

    /// The axes of a grid as joints of a machine; empty for other cycles.
    fn grid(&self, machine: &Machine) -> Vec<GridAxis> {
        match &self.motion {
            Motion::Static { grid, .. } => grid.iter().map(|axis| axis.on(machine)).collect(),
            Motion::Line { .. } | Motion::Path { .. } | Motion::OnTheFly { .. } => Vec::new(),
        }
    }

    /// A joint that it turns and that is no letter of ISO 841: no NC program here turns one, and no driver reads it.
    pub fn named_joint(&self) -> Option<Joint> {
        let Motion::Static { grid, .. } = &self.motion else { return None };
        grid.iter().map(|axis| axis.letter).find(|joint| !Joint::ISO.contains(joint))
    }

    /// Where it stands in one pass of a setup, in order: every target at every place of the grid; none on the fly.
    fn stations(&self, machine: &Machine, setup: usize, pass: f64) -> Vec<Station> {
        let targets = self.setups[setup].targets();
        let at_target = |asked: AxisValues<f64>| (0..targets).map(move |target| Station { asked, target });
        let own = &self.setups[setup];
        let along = own.direction.unwrap_or_else(Vector3::x_axis);
        // With the rotary axes at zero the linear coordinates are those of the place.
        let on_line = |beyond_mm: Vector3<f64>| {
            let mut asked = AxisValues::default();
            let place_mm = own.ball_in_table_mm + beyond_mm - own.ball_in_tool_mm;
            for (k, letter) in Joint::LINEAR.into_iter().enumerate() {
                asked[letter] = place_mm[k];
            }
            Station { asked, target: 0 }
        };
        let mut stations: Vec<Station> = match &self.motion {
            Motion::Static { .. } => {
                grid_positions(&self.grid(machine)).into_iter().flat_map(at_target).collect()
            }
            Motion::Line { line, .. } => line.places_mm(&along).into_iter().map(on_line).collect(),
            Motion::OnTheFly { .. } | Motion::Path { .. } => Vec::new(),
        };
        if pass < 0.0 {
            stations.reverse();
        }
        stations
    }

    /// Beyond the first station of a pass along a line, so that it too is approached along the line [ISO 230-2, standard test cycle: the end targets are
    /// overrun]; `None` for other cycles.
    fn before_line(&self, setup: usize, pass: f64, first: &AxisValues<f64>) -> Option<AxisValues<f64>> {
        let Motion::Line { .. } = &self.motion else { return None };
        let along = self.setups[setup].direction.unwrap_or_else(Vector3::x_axis);
        let mut beyond = *first;
        for (k, letter) in Joint::LINEAR.into_iter().enumerate() {
            beyond[letter] -= pass * OVERRUN_MM * along[k];
        }
        Some(beyond)
    }

    /// All axes at a station: linear axes as asked where the cycle names them, else following the ball.
    fn dwell_at(&self, machine: &Machine, setup: usize, station: &Station) -> Option<AxisValues<f64>> {
        if self.names_linear() {
            return Some(station.asked);
        }
        self.follow(machine, setup, station.target, &station.asked)
    }

    /// True when the cycle says where the linear axes stand; else they follow the ball.
    fn names_linear(&self) -> bool {
        match &self.motion {
            Motion::Line { .. } => true,
            Motion::Static { grid, .. } => grid.iter().any(|axis| !axis.letter.is_rotary()),
            Motion::OnTheFly { .. } | Motion::Path { .. } => false,
        }
    }

    /// The passes of a cycle on the fly in order, over all setups, feeds and rounds; empty for one at rest. Along a curve the
    /// feed is that of the angle on it.
    pub fn sweeps(&self) -> Vec<Sweep> {
        let of = |(from, to): (f64, f64), feed: &dyn Fn(&Leg) -> f64| -> Vec<Sweep> {
            let forward = (to - from).signum();
            let sweep =
                |leg: Leg| Sweep { setup: leg.setup, feed_rad_per_s: feed(&leg) * leg.pass * forward };
            self.legs().into_iter().map(sweep).collect()
        };
        match &self.motion {
            Motion::Static { .. } | Motion::Line { .. } => Vec::new(),
            Motion::OnTheFly { feeds_rad_per_s, from_to_rad, .. } => {
                of(*from_to_rad, &|leg| feeds_rad_per_s[leg.feed])
            }
            Motion::Path { path, feeds_mm_per_s, from_to_rad, .. } => {
                of(*from_to_rad, &|leg| feeds_mm_per_s[leg.feed] / path.radius_mm(&self.setups[leg.setup]))
            }
        }
    }

    /// The rotary axes when the turning axis of a sweep is at an angle; `None` for a cycle that sweeps no axis.
    pub fn rotary_at(&self, angle_rad: f64) -> Option<AxisValues<f64>> {
        let Motion::OnTheFly { axis, from_to_rad: (from, to), others, .. } = &self.motion else {
            return None;
        };
        let share = if to == from { 0.0 } else { (angle_rad - from) / (to - from) };
        let mut rotary = AxisValues::from_fn(|letter| {
            let (first, last) = others[letter];
            first + share * (last - first)
        });
        rotary[*axis] = angle_rad;
        Some(rotary)
    }

    /// All axes at an angle of the curve that a cycle follows; `near`: where the rotary axes stood before. `None` when the
    /// cycle follows no curve or the machine cannot get there.
    pub fn curve_position(
        &self,
        machine: &Machine,
        setup: usize,
        angle_rad: f64,
        near: &AxisValues<f64>,
    ) -> Option<AxisValues<f64>> {
        match &self.motion {
            Motion::Path { path, .. } => path.position(machine, (&self.setups[setup], 0), angle_rad, near),
            Motion::Static { .. } | Motion::Line { .. } | Motion::OnTheFly { .. } => None,
        }
    }

    /// Angle on the curve that a cycle follows, −π…π, nearest to a place of the tool point in table axes, mm. `None` when it
    /// follows none.
    pub fn curve_angle_rad(&self, machine: &Machine, place_in_table_mm: &Point3<f64>) -> Option<f64> {
        let Motion::Path { path, .. } = &self.motion else { return None };
        let off = |setup: &&Setup| {
            let apart = (place_in_table_mm - setup.ball_in_table_mm).norm();
            (apart - path.radius_mm(setup)).abs()
        };
        let setup = self.setups.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some(path.angle_rad(machine, setup, place_in_table_mm))
    }

    /// All axes when the rotary axes stand at `rotary`: the linear axes bring the spindle side to the ball, or a ball bar's
    /// length away from it. `None` when the machine cannot follow.
    pub fn position(
        &self,
        machine: &Machine,
        setup: usize,
        rotary: &AxisValues<f64>,
    ) -> Option<AxisValues<f64>> {
        self.follow(machine, setup, 0, rotary)
    }

    fn follow(
        &self,
        machine: &Machine,
        setup: usize,
        target: usize,
        rotary: &AxisValues<f64>,
    ) -> Option<AxisValues<f64>> {
        let setup = &self.setups[setup];
        path::reach(machine, setup, rotary, &self.place_in_table_mm(machine, setup, target, rotary))
    }

    /// Where the spindle side has to be: at the target, or a bar's length away from it; table axes, mm.
    fn place_in_table_mm(
        &self,
        machine: &Machine,
        setup: &Setup,
        target: usize,
        rotary: &AxisValues<f64>,
    ) -> Point3<f64> {
        let target_in_table_mm = setup.target_in_table_mm(target);
        if !setup.instrument.keeps_bar_length() {
            return target_in_table_mm;
        }
        let machine_from_table = machine.machine_from_table(rotary, &JointErrors::default()).rotation;
        let bar_mm = self.bar_in_machine(machine, setup, rotary) * setup.bar_length_mm.unwrap_or_default();
        target_in_table_mm + machine_from_table.inverse() * bar_mm
    }

    /// Direction of a ball bar, from the table's ball to the tool's, machine axes.
    fn bar_in_machine(&self, machine: &Machine, setup: &Setup, rotary: &AxisValues<f64>) -> Vector3<f64> {
        let direction = setup.direction.unwrap_or(self.bar.direction).into_inner();
        match self.bar.frame {
            BarFrame::Table => {
                machine.machine_from_table(rotary, &JointErrors::default()).rotation * direction
            }
            BarFrame::Machine => direction,
        }
    }

    /// Passes of all setups, feeds and rounds in order.
    fn legs(&self) -> Vec<Leg> {
        let (passes, feeds) = match &self.motion {
            Motion::Static { passes, .. } | Motion::Line { passes, .. } => (passes, 1),
            Motion::Path { passes, feeds_mm_per_s, .. } => (passes, feeds_mm_per_s.len()),
            Motion::OnTheFly { passes, feeds_rad_per_s, .. } => (passes, feeds_rad_per_s.len()),
        };
        let setups = 0..self.setups.len();
        let of_setup = |round: usize, setup: usize| {
            (0..feeds).flat_map(move |feed| passes.iter().map(move |&pass| Leg { round, setup, feed, pass }))
        };
        let mut legs = Vec::new();
        for round in 0..self.rounds.count {
            let one_after_the_other: Vec<Vec<Leg>> =
                setups.clone().map(|setup| of_setup(round, setup).collect()).collect();
            if self.rounds.interleave {
                for k in 0..feeds * passes.len() {
                    legs.extend(one_after_the_other.iter().map(|legs_of_setup| legs_of_setup[k]));
                }
            } else {
                legs.extend(one_after_the_other.into_iter().flatten());
            }
        }
        legs
    }
}

/// One place to stand at.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Station {
    /// What the cycle asks of the axes, mm and rad.
    asked: AxisValues<f64>,
    /// Index of the target.
    target: usize,
}

/// One pass of one setup.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leg {
    round: usize,
    setup: usize,
    /// Index of the feed; 0 at rest.
    feed: usize,
    pass: f64,
}

fn grid_positions(grid: &[GridAxis]) -> Vec<AxisValues<f64>> {
    grid.iter().fold(vec![AxisValues::default()], |outer, axis| {
        let with = |base: &AxisValues<f64>, station: f64| {
            let mut position = *base;
            position[axis.letter] = station;
            position
        };
        outer.iter().flat_map(|base| axis.stations.iter().map(move |&s| with(base, s))).collect()
    })
}

#[cfg(test)]
mod tests;
