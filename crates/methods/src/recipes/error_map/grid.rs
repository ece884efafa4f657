//! Readings at rest gathered on the grid of both axes, repeats averaged.

use super::nest_calibration::commanded_mm;
use crate::common::relative::{machine_from_reading, tool_against_table_mm};
use crate::common::shares::Shares;
use crate::common::stations::Stations;
use crate::common::{LeftOut, Mounted, mounted, reasons};
use crate::recipes::{Method, MethodError, one_machine};
use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};
use trunnion_core::{InstrumentKind, Joint, Point, Setup, Twist};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::propagation::JointFrame;
use trunnion_machine::{JointErrors, Machine};

/// Fewest poses of the turning axis at one angle of the tilting axis.
const LEAST_TURNS: usize = 3;
/// A ball commanded further than this from the nest was not read there, mm.
const MOST_OFF_MM: f64 = 5.0;
/// Nest positions nearer in height than this give no tilt, mm.
const APART_MM: f64 = 10.0;

/// All readings of a grid.
pub(super) struct Grid<'a> {
    pub machine: &'a Machine,
    /// The axis next to the bed, S1's B.
    pub tilting: Joint,
    /// The axis that carries the table, S1's C.
    pub turning: Joint,
    /// Angles of the tilting axis, rad.
    pub tilts_rad: Vec<f64>,
    /// Angles of the turning axis, rad.
    pub turns_rad: Vec<f64>,
    /// Names of the nest positions.
    pub nests: Vec<String>,
    /// `cells[tilt][turn][nest]`.
    pub cells: Vec<Vec<Vec<Option<Cell>>>>,
    /// Standard deviation of one reading by its repeats, mm; `None` when nothing was read twice.
    pub repeat_mm: Option<f64>,
    /// Runs, points and setups that could not be used, one sentence each.
    pub left_out: Vec<LeftOut>,
}

/// One pose of one nest position.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// Mean displacement of the tool against the table, table axes, mm.
    pub mean_mm: Vector3<f64>,
    /// Readings behind it.
    pub readings: usize,
    /// What each reading counts in the sum of them, component by component.
    pub shares_of_sum: [Shares; 3],
    /// The nest in machine axes, mm.
    pub nest_in_machine_mm: Point3<f64>,
    /// Machine axes from table axes.
    pub machine_from_table: UnitQuaternion<f64>,
    /// Joint of the tilting axis.
    pub tilting: JointFrame,
    /// Joint of the turning axis.
    pub turning: JointFrame,
}

impl<'a> Grid<'a> {
    pub fn of(method: &Method, runs: &'a [Run]) -> Result<Self, MethodError> {
        let machine = one_machine(runs)?;
        let rotary: Vec<Joint> =
            machine.table.iter().rev().filter(|axis| axis.is_rotary()).map(|axis| axis.letter).collect();
        let &[tilting, turning] = &rotary[..] else {
            let found = format!("machine {} has {} rotary axes under the table", machine.name, rotary.len());
            return Err(method.lacks(found, "Use the joint fit (identify without --method)."));
        };
        let mut left_out = Vec::new();
        let mut readings: Vec<Reading<'_>> = Vec::new();
        for Mounted { name, run, setup, points, numbers, .. } in mounted(runs) {
            if run.kind == RunKind::OnTheFly {
                left_out.push(LeftOut::run(run.name.clone(), "read on the fly"));
                left_out.dedup();
                continue;
            }
            if setup.instrument != InstrumentKind::RTest {
                left_out.push(LeftOut::setup(name, format!("read by {}", setup.instrument.with_article())));
                continue;
            }
            let off_mm = points.iter().map(|point| commanded_mm(run, point).norm()).fold(0.0, f64::max);
            if off_mm > MOST_OFF_MM {
                let found =
                    format!("in setup {name} the ball is commanded up to {off_mm:.1} mm off the nest");
                return Err(
                    method.lacks(found, "Check the positions of the linear axes and the place of the nest.")
                );
            }
            readings.extend(
                numbers.into_iter().zip(points).map(|(number, point)| (name.clone(), setup, number, point)),
            );
        }
        let angles =
            |letter| Stations::of_grid(readings.iter().map(|(.., p)| p.state.position[letter]), false);
        let (tilts, turns) = (angles(tilting), angles(turning));
        let mut nests: Vec<(String, &Setup)> = Vec::new();
        for (name, setup, ..) in &readings {
            if !nests.iter().any(|(known, _)| known == name) {
                nests.push((name.clone(), setup));
            }
        }
        let heights = || nests.iter().map(|(_, setup)| setup.ball_in_table_mm.z);
        let (low, high) =
            heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        if nests.len() < 2 || high - low < APART_MM {
            let found = match nests.len() {
                0 => match left_out.is_empty() {
                    true => "they hold no R-test readings at rest".into(),
                    false => format!("they hold no R-test readings at rest ({})", reasons(&left_out)),
                },
                1 => format!("there is one nest position ({})", nests[0].0),
                n => format!("the {n} nest positions are less than {APART_MM} mm apart in height"),
            };
            return Err(method.lacks(found, "Run config/cycles/r-test-static.toml, or give both recordings."));
        }
        let (repeat_mm, cells) = averaged(machine, [tilting, turning], [&tilts, &turns], &nests, &readings);
        let grid = Self {
            machine,
            tilting,
            turning,
            tilts_rad: tilts.angles_rad,
            turns_rad: turns.angles_rad,
            nests: nests.into_iter().map(|(name, _)| name).collect(),
            cells,
            repeat_mm,
            left_out,
        };
        let poses = |i: usize| (0..grid.turns_rad.len()).filter(|&j| grid.has_all(i, j)).count();
        let thin = (0..grid.tilts_rad.len()).find(|&i| poses(i) < LEAST_TURNS);
        if let Some(i) = thin {
            let found = format!(
                "at {tilting} = {:.1}° all nest positions were read at {} angle(s) of {turning} only",
                grid.tilts_rad[i].to_degrees(),
                poses(i)
            );
            return Err(method.lacks(found, format!("Read {LEAST_TURNS} or more angles of {turning} there.")));
        }
        Ok(grid)
    }

    /// True when every nest position was read at this pose.
    pub fn has_all(&self, tilt: usize, turn: usize) -> bool {
        self.cells[tilt][turn].iter().all(Option::is_some)
    }

    /// Cells of one tilt with their nest.
    pub fn at_tilt(&self, tilt: usize) -> impl Iterator<Item = (usize, usize, &Cell)> {
        let of_turn = |(turn, cells): (usize, &'_ Vec<Option<Cell>>)| -> Vec<(usize, usize)> {
            (0..cells.len()).filter(|&s| cells[s].is_some()).map(|s| (turn, s)).collect()
        };
        let places: Vec<(usize, usize)> = self.cells[tilt].iter().enumerate().flat_map(of_turn).collect();
        places.into_iter().filter_map(move |(turn, s)| Some((turn, s, self.cells[tilt][turn][s].as_ref()?)))
    }

    /// Index of the tilt nearest to an angle.
    pub fn tilt_near(&self, angle_rad: f64) -> usize {
        let away = |i: &usize| (self.tilts_rad[*i] - angle_rad).abs();
        (0..self.tilts_rad.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0)
    }
}

/// Name of its setup, the setup, its number among the good readings of all runs.
type Reading<'r> = (String, &'r Setup, usize, &'r Point);

type Cells = Vec<Vec<Vec<Option<Cell>>>>;

fn averaged(
    machine: &Machine,
    [tilting, turning]: [Joint; 2],
    [tilts, turns]: [&Stations; 2],
    nests: &[(String, &Setup)],
    readings: &[Reading<'_>],
) -> (Option<f64>, Cells) {
    let (count_i, count_j) = (tilts.angles_rad.len(), turns.angles_rad.len());
    let mut cells: Cells = vec![vec![vec![None; nests.len()]; count_j]; count_i];
    let mut squares = vec![vec![vec![0.0; nests.len()]; count_j]; count_i];
    for (name, setup, number, point) in readings {
        let position = &point.state.position;
        let Some((i, j)) = tilts.at(position[tilting]).zip(turns.at(position[turning])) else { continue };
        let Some(s) = nests.iter().position(|(known, _)| known == name) else { continue };
        let table_from_machine =
            machine.machine_from_table(position, &JointErrors::default()).rotation.inverse();
        let reading = table_from_machine * tool_against_table_mm(machine, setup, point);
        // What an error does there is that of the grid: where every cell of a tilt stands a little elsewhere, what no reading sees
        // (the zero pose along and about the turning axis) would pass for seen, with millimetres of u.
        let mut nominal = *position;
        nominal[tilting] = tilts.angles_rad[i];
        nominal[turning] = turns.angles_rad[j];
        let machine_from_table = machine.machine_from_table(&nominal, &JointErrors::default());
        let Some(frames) = machine.joint_frame(tilting, &nominal).zip(machine.joint_frame(turning, &nominal))
        else {
            continue;
        };
        let cell = cells[i][j][s].get_or_insert_with(|| Cell {
            mean_mm: Vector3::zeros(),
            readings: 0,
            shares_of_sum: Default::default(),
            nest_in_machine_mm: machine_from_table * setup.ball_in_table_mm,
            machine_from_table: machine_from_table.rotation,
            tilting: frames.0,
            turning: frames.1,
        });
        let per_reading = table_from_machine.to_rotation_matrix().into_inner()
            * machine_from_reading(machine, setup, point);
        for (k, shares) in cell.shares_of_sum.iter_mut().enumerate() {
            (0..3).for_each(|of| shares.add(*number, of, per_reading[(k, of)]));
        }
        // Running mean and sum of squares (Welford).
        cell.readings += 1;
        let off = reading - cell.mean_mm;
        cell.mean_mm += off / cell.readings as f64;
        squares[i][j][s] += off.dot(&(reading - cell.mean_mm));
    }
    let all = || cells.iter().flatten().flatten().flatten();
    let freedom: usize = all().map(|cell| 3 * (cell.readings - 1)).sum();
    let sum: f64 = squares.iter().flatten().flatten().sum();
    ((freedom > 0).then(|| (sum / freedom as f64).sqrt()), cells)
}

impl Cell {
    /// What a unit error at a joint does to the reading, table axes: columns δ, then ω.
    pub fn columns(&self, joint: &JointFrame) -> [Matrix3<f64>; 2] {
        let table_from_machine = self.machine_from_table.inverse();
        let column =
            |twist: Twist| table_from_machine * -joint.displacement_mm(&self.nest_in_machine_mm, &twist);
        let unit = |k: usize| Vector3::ith(k, 1.0);
        [
            Matrix3::from_columns(&[0, 1, 2].map(|k| column(Twist::translation(unit(k))))),
            Matrix3::from_columns(&[0, 1, 2].map(|k| column(Twist::rotation(unit(k))))),
        ]
    }

    /// Reading that errors of the tilting axis make, table axes, mm.
    pub fn of_tilting(&self, twist: &Twist) -> Vector3<f64> {
        self.machine_from_table.inverse() * -self.tilting.displacement_mm(&self.nest_in_machine_mm, twist)
    }

    /// Reading that errors of the turning axis make, table axes, mm.
    pub fn of_turning(&self, twist: &Twist) -> Vector3<f64> {
        self.machine_from_table.inverse() * -self.turning.displacement_mm(&self.nest_in_machine_mm, twist)
    }
}
