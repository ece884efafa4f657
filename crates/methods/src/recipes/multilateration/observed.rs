//! Which readings are of one target: the same commanded axes, approached alike, with the reflector at the same place of the tool.

use crate::common::{LeftOut, Mounted, mounted, reasons};
use crate::recipes::{Method, MethodError};
use nalgebra::{Point3, Vector3};
use trunnion_core::number::counted;
use trunnion_core::{InstrumentKind, Point, State};
use trunnion_cycles::Run;
use trunnion_instruments::predict;
use trunnion_machine::{Errors, JointErrors, Machine};

/// Positions nearer than these are one target: what a control holds at rest is far nearer, steps between targets are far larger.
const ONE_TARGET_MM: f64 = 0.05;
const ONE_TARGET_RAD: f64 = 1e-4;
/// Reflectors nearer than this sit at the same place of the tool, mm.
const ONE_REFLECTOR_MM: f64 = 1e-3;
/// Stations that fix a place with one reading over [S2 §3.5].
pub(super) const LEAST_STATIONS: usize = 4;

/// All readings, by the place of the reflector.
pub(super) struct Observed {
    pub groups: Vec<Group>,
    pub left_out: Vec<LeftOut>,
    /// Targets that too few stations saw, a part of a sentence for each place of the reflector.
    pub seen_by_few: Vec<String>,
}

/// Readings with the reflector at one place of the tool.
pub(super) struct Group {
    pub reflector_in_tool_mm: Point3<f64>,
    pub stations: Vec<Station>,
    pub targets: Vec<Target>,
    pub distances: Vec<Distance>,
}

/// Where a tracker stood.
pub(super) struct Station {
    pub name: String,
    /// By the setup, table axes, mm.
    pub nominal_mm: Vector3<f64>,
}

/// A place of the reflector.
pub(super) struct Target {
    state: State,
    /// Commanded, table axes, mm.
    pub nominal_mm: Vector3<f64>,
}

/// One reading.
pub(super) struct Distance {
    pub station: usize,
    pub target: usize,
    /// Distance less the unknown dead path, mm.
    pub length_mm: f64,
}

/// The readings of all stations.
///
/// # Errors
/// Too few stations saw the same targets.
pub(super) fn recognised(method: &Method, runs: &[Run]) -> Result<Observed, MethodError> {
    let mut found = Observed { groups: Vec::new(), left_out: Vec::new(), seen_by_few: Vec::new() };
    for Mounted { name, run, setup, points, .. } in mounted(runs) {
        if setup.instrument != InstrumentKind::Tracker {
            let why =
                format!("read by {}, not by a tracking interferometer", setup.instrument.with_article());
            found.left_out.push(LeftOut::setup(name, why));
            continue;
        }
        let at = setup.ball_in_tool_mm;
        let same = |group: &Group| (group.reflector_in_tool_mm - at).norm() < ONE_REFLECTOR_MM;
        let k = found.groups.iter().position(same).unwrap_or_else(|| {
            found.groups.push(Group {
                reflector_in_tool_mm: at,
                stations: Vec::new(),
                targets: Vec::new(),
                distances: Vec::new(),
            });
            found.groups.len() - 1
        });
        let group = &mut found.groups[k];
        let station = group.stations.len();
        group.stations.push(Station { name, nominal_mm: setup.ball_in_table_mm.coords });
        for point in points {
            let target = group.target_of(&run.machine, point);
            // Where the axes stood a little elsewhere for this station, the distance is that to the target.
            let nominal_mm = |state| predict(&run.machine, setup, state, &Errors::default()).x;
            let moved_mm = nominal_mm(&group.targets[target].state) - nominal_mm(&point.state);
            let length_mm = point.reading_mm[0] + setup.bar_length_mm.unwrap_or_default() + moved_mm;
            group.distances.push(Distance { station, target, length_mm });
        }
    }
    let next = "Run a cycle such as config/cycles/tracker.toml.";
    if found.groups.is_empty() {
        let why = reasons(&found.left_out);
        return Err(method.lacks(format!("no setup holds distances of a tracker ({why})"), next));
    }
    for group in &mut found.groups {
        if group.stations.len() < LEAST_STATIONS {
            return Err(method.lacks(
                format!(
                    "{} with the reflector at {}",
                    counted(group.stations.len() as u64, "station"),
                    group.place()
                ),
                next,
            ));
        }
        let unseen = group.keep_seen();
        if unseen > 0 {
            found.seen_by_few.push(format!(
                "{unseen} targets with the reflector at {}: seen from fewer than {LEAST_STATIONS} stations",
                group.place()
            ));
        }
        if group.freedom() <= 0 {
            return Err(method.lacks(
                format!(
                    "{} readings of {} targets from {} stations leave nothing over",
                    group.distances.len(),
                    group.targets.len(),
                    group.stations.len()
                ),
                next,
            ));
        }
    }
    Ok(found)
}

impl Group {
    /// `X0 Y0 Z-60` of the tool.
    pub fn place(&self) -> String {
        let [x, y, z]: [f64; 3] = self.reflector_in_tool_mm.coords.into();
        format!("X{x} Y{y} Z{z} of the tool")
    }

    /// Readings beyond unknowns.
    pub fn freedom(&self) -> isize {
        let unknowns = 3 * self.targets.len() + 4 * self.stations.len() - 6;
        self.distances.len() as isize - unknowns as isize
    }

    fn target_of(&mut self, machine: &Machine, point: &Point) -> usize {
        let same = |target: &Target| one_target(machine, &target.state, &point.state);
        self.targets.iter().position(same).unwrap_or_else(|| {
            let none = JointErrors::default();
            let position = &point.state.position;
            let reflector = machine.machine_from_tool(position, &none) * self.reflector_in_tool_mm;
            let in_table = machine.machine_from_table(position, &none).inverse() * reflector;
            self.targets.push(Target { state: point.state.clone(), nominal_mm: in_table.coords });
            self.targets.len() - 1
        })
    }

    /// Keeps the targets that enough stations saw; how many it drops.
    fn keep_seen(&mut self) -> usize {
        let stations = self.stations.len();
        let mut seen = vec![vec![false; stations]; self.targets.len()];
        for distance in &self.distances {
            seen[distance.target][distance.station] = true;
        }
        let enough: Vec<bool> =
            seen.iter().map(|by| by.iter().filter(|seen| **seen).count() >= LEAST_STATIONS).collect();
        let mut number = 0;
        let renumbered: Vec<Option<usize>> = enough
            .iter()
            .map(|enough| {
                number += usize::from(*enough);
                enough.then(|| number - 1)
            })
            .collect();
        let before = self.targets.len();
        let mut kept = enough.iter();
        self.targets.retain(|_| *kept.next().unwrap_or(&false));
        self.distances.retain(|distance| enough[distance.target]);
        for distance in &mut self.distances {
            distance.target = renumbered[distance.target].unwrap_or_default();
        }
        before - self.targets.len()
    }
}

fn one_target(machine: &Machine, one: &State, other: &State) -> bool {
    machine.joints().into_iter().all(|joint| {
        let within = if joint.is_rotary() { ONE_TARGET_RAD } else { ONE_TARGET_MM };
        let same = one.direction[joint] * other.direction[joint] >= 0.0;
        same && (one.position[joint] - other.position[joint]).abs() < within
    })
}
