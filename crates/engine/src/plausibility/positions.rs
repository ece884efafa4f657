//! Do the axes follow the ball? An R-test reads a ball in its nest, so both must be at one place, whatever the machine's
//! errors are: these are a thousand times smaller than any mistake here.

use super::found::Implausible;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{AxisValues, InstrumentKind, Joint, Setup, statistics};
use trunnion_cycles::Run;
use trunnion_machine::{JointErrors, Machine, shipped};

/// Farther apart than any probe of an R-test reads, mm.
const FAR_MM: f64 = 5.0;
/// With a mistake undone, ball and nest may stay this far apart: settings by hand and rounded positions, mm.
const TOGETHER_MM: f64 = 1.0;
/// Points of which the distance is formed while mistakes are tried: evenly chosen, for time only.
const TRIED_POINTS: usize = 600;
/// More mistakes that explain all are not listed.
const MOST_LISTED: usize = 3;
const MM_OF_INCH: f64 = 25.4;

/// What a run says of itself, or would say with a mistake undone.
struct Claim<'a> {
    machine: &'a Machine,
    setups: Vec<Setup>,
    positions: Vec<(usize, AxisValues<f64>)>,
}

impl Claim<'_> {
    fn rms_mm(&self) -> f64 {
        rms(self.positions.iter().map(|(setup, at)| apart_mm(self.machine, &self.setups[*setup], at)))
    }

    fn turned(&self, change: impl Fn(&AxisValues<f64>) -> AxisValues<f64>) -> f64 {
        let positions = self.positions.iter().map(|(setup, position)| (*setup, change(position)));
        Claim { machine: self.machine, setups: self.setups.clone(), positions: positions.collect() }.rms_mm()
    }
}

/// From the nest to the ball by nominal kinematics, machine axes, mm.
fn apart_mm(machine: &Machine, setup: &Setup, position: &AxisValues<f64>) -> Vector3<f64> {
    let none = JointErrors::default();
    machine.machine_from_tool(position, &none) * setup.ball_in_tool_mm
        - machine.machine_from_table(position, &none) * setup.ball_in_table_mm
}

fn rms(distances: impl Iterator<Item = Vector3<f64>>) -> f64 {
    statistics::rms(distances.map(|d| d.norm())).unwrap_or(0.0)
}

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    runs.iter().filter_map(of_run).collect()
}

fn of_run(run: &Run) -> Option<Implausible> {
    let brings_together = |setup: usize| run.setups[setup].instrument == InstrumentKind::RTest;
    let rows: Vec<usize> =
        (0..run.points.len()).filter(|&row| brings_together(run.points[row].state.setup)).collect();
    let apart_mm = |row: usize| {
        let state = &run.points[row].state;
        apart_mm(&run.machine, &run.setups[state.setup], &state.position)
    };
    let far: Vec<usize> = rows.iter().copied().filter(|&row| apart_mm(row).norm() > FAR_MM).collect();
    let (first, last) = (*far.first()?, *far.last()?);
    if let Some(found) = standing(run, &rows, &far) {
        return Some(found);
    }
    let tried_rows = rows.iter().step_by(rows.len().div_ceil(TRIED_POINTS));
    let at = |&row: &usize| (run.points[row].state.setup, run.points[row].state.position);
    let claim =
        Claim { machine: &run.machine, setups: run.setups.clone(), positions: tried_rows.map(at).collect() };
    let apart_mm = rms(rows.iter().map(|&row| apart_mm(row)));
    let mut tried = mistakes(run, &claim);
    let best =
        |tried: &[(String, f64)]| tried.iter().map(|(_, rms_mm)| *rms_mm).fold(f64::INFINITY, f64::min);
    // Places that are fitted explain what any mistake of a number does: they count where no mistake without a free number is enough.
    if best(&tried) > TOGETHER_MM {
        tried = other_places(&claim);
    }
    let best_mm = best(&tried);
    // Mistakes that undo it equally well are listed together: positions alone cannot choose.
    let mut listed: Vec<&str> = tried
        .iter()
        .filter(|(_, rms_mm)| best_mm < TOGETHER_MM && *rms_mm < 2.0 * best_mm + 0.01)
        .map(|(mistake, _)| mistake.as_str())
        .collect();
    listed.truncate(MOST_LISTED);
    let finding = format!(
        "{}: in {} of {} points (rows {} to {}) the axes do not follow the ball: by their positions, ball and nest are {apart_mm:.1} mm apart.",
        run.name,
        far.len(),
        rows.len(),
        first + 1,
        last + 1,
    );
    let hypothesis = if listed.is_empty() {
        "No single mistake of those tried explains it. Compare the points with the setup file and the machine file.".into()
    } else {
        format!("With {} they are {best_mm:.1} mm apart. Change it?", listed.join(", or "))
    };
    let rms_um_with_it = (!listed.is_empty()).then(|| um_from_mm(best_mm));
    Some(Implausible { finding, hypothesis, rms_um_with_it })
}

/// A stretch of points in which axes stood still by their positions, while the others went on.
fn standing(run: &Run, rows: &[usize], far: &[usize]) -> Option<Implausible> {
    let (first, last) = (*far.first()?, *far.last()?);
    // The first points of the stretch may still be right by chance, and poses of it that were meant to be there.
    let stretch = || (first..=last).filter(|row| rows.binary_search(row).is_ok());
    if 2 * far.len() > rows.len() || 2 * far.len() < stretch().count() {
        return None;
    }
    let value = |row: usize, joint: Joint| run.points[row].state.position[joint];
    let stands = |joint: &Joint| stretch().all(|row| value(row, *joint) == value(first, *joint));
    let others = |joint: &Joint| rows.iter().any(|&row| value(row, *joint) != value(first, *joint));
    let stuck: Vec<&str> = run
        .machine
        .joints()
        .into_iter()
        .filter(|joint| stands(joint) && others(joint))
        .map(Joint::as_str)
        .collect();
    let finding = format!(
        "{}: in rows {} to {} the axes do not follow the ball, elsewhere they do.",
        run.name,
        first + 1,
        last + 1
    );
    let hypothesis = if stuck.is_empty() {
        "Read the positions of these rows again.".into()
    } else {
        format!(
            "The position of {} stays the same there: it was not updated. Read these rows again.",
            stuck.join(" and ")
        )
    };
    Some(Implausible { finding, hypothesis, rms_um_with_it: None })
}

/// Every mistake that is tried, with what ball and nest are apart when it is undone, mm.
fn mistakes(run: &Run, claim: &Claim<'_>) -> Vec<(String, f64)> {
    let machine = claim.machine;
    let (linear, rotary) = (machine.linear_joints(), machine.rotary_joints());
    let mut tried = Vec::new();
    for joint in machine.joints() {
        let turned = claim.turned(|position| {
            let mut changed = *position;
            changed[joint] = -changed[joint];
            changed
        });
        tried.push((format!("the sense of {joint} reversed (sign −1)"), turned));
    }
    for joints in [&linear, &rotary] {
        for (k, &a) in joints.iter().enumerate() {
            for &b in &joints[k + 1..] {
                let swapped = claim.turned(|position| {
                    let mut changed = *position;
                    (changed[a], changed[b]) = (changed[b], changed[a]);
                    changed
                });
                tried.push((format!("the columns of the axes {a} and {b} exchanged"), swapped));
            }
        }
    }
    let scaled = |joints: &[Joint], factor: f64| {
        claim.turned(|position| {
            let mut changed = *position;
            joints.iter().for_each(|&joint| changed[joint] *= factor);
            changed
        })
    };
    // What was read as degrees is in radians inside; a number of radians read as degrees is too small by π/180.
    tried.push(("angles given in radians, not in degrees".into(), scaled(&rotary, 180.0 / PI)));
    tried.push(("lengths given in inches, not in mm".into(), scaled(&linear, MM_OF_INCH)));
    tried.push(("lengths given in metres, not in mm".into(), scaled(&linear, 1e3)));
    tried.push(("lengths given in µm, not in mm".into(), scaled(&linear, 1e-3)));
    tried.extend(exchanged_setups(claim));
    for (name, _) in shipped::FILES {
        let other = shipped::machine(name).filter(|other| other.name != run.machine.name);
        // Without the angle of its spindle, a machine that has one is the same as that without.
        let recorded = |joint: &Joint| run.machine.joint(joint.as_str()).is_some();
        let other = other.filter(|other| other.spindle.as_ref().is_none_or(recorded));
        if let Some(other) = other {
            let claim =
                Claim { machine: &other, setups: claim.setups.clone(), positions: claim.positions.clone() };
            tried.push((format!("another machine, {name}, not {}", run.machine.name), claim.rms_mm()));
        }
    }
    tried
}

fn exchanged_setups(claim: &Claim<'_>) -> Vec<(String, f64)> {
    let mut tried = Vec::new();
    for b in 1..claim.setups.len() {
        for a in 0..b {
            let mut setups = claim.setups.clone();
            setups[a].ball_in_table_mm = claim.setups[b].ball_in_table_mm;
            setups[b].ball_in_table_mm = claim.setups[a].ball_in_table_mm;
            let rms_mm =
                Claim { machine: claim.machine, setups, positions: claim.positions.clone() }.rms_mm();
            let [a, b] = [a, b].map(|k| claim.setups[k].name.as_str());
            tried.push((format!("the setups {a} and {b} exchanged (position of the ball)"), rms_mm));
        }
    }
    tried
}

/// The balls where the axes say they are, on the table or in the tool.
fn other_places(claim: &Claim<'_>) -> Vec<(String, f64)> {
    let none = JointErrors::default();
    let machine = claim.machine;
    let fitted = |place: &dyn Fn(&AxisValues<f64>, &Setup) -> Point3<f64>, k: usize| -> Option<Point3<f64>> {
        let own = claim.positions.iter().filter(|(setup, _)| *setup == k);
        let places: Vec<Vector3<f64>> =
            own.map(|(_, position)| place(position, &claim.setups[k]).coords).collect();
        let sum: Vector3<f64> = places.iter().sum();
        (!places.is_empty()).then(|| Point3::from(sum / places.len() as f64))
    };
    let in_table = |position: &AxisValues<f64>, setup: &Setup| {
        machine.machine_from_table(position, &none).inverse()
            * (machine.machine_from_tool(position, &none) * setup.ball_in_tool_mm)
    };
    let in_tool = |position: &AxisValues<f64>, setup: &Setup| {
        machine.machine_from_tool(position, &none).inverse()
            * (machine.machine_from_table(position, &none) * setup.ball_in_table_mm)
    };
    let (mut on_table, mut on_tool) = (claim.setups.clone(), claim.setups.clone());
    let (mut moved_on_table, mut moved_on_tool) = (Vec::new(), Vec::new());
    let words = |setup: &Setup, key: &str, from: &Point3<f64>, to: &Point3<f64>| {
        format!(
            "the position of the ball of setup {}, {key}, at [{:.1}, {:.1}, {:.1}], not [{:.1}, {:.1}, {:.1}] mm",
            setup.name, to.x, to.y, to.z, from.x, from.y, from.z
        )
    };
    for k in 0..claim.setups.len() {
        let setup = &claim.setups[k];
        if let Some(place) = fitted(&in_table, k) {
            if (place - setup.ball_in_table_mm).norm() > TOGETHER_MM {
                moved_on_table.push(words(setup, "ball_in_table_mm", &setup.ball_in_table_mm, &place));
            }
            on_table[k].ball_in_table_mm = place;
        }
        if let Some(place) = fitted(&in_tool, k) {
            if (place - setup.ball_in_tool_mm).norm() > TOGETHER_MM {
                moved_on_tool.push(words(setup, "ball_in_tool_mm", &setup.ball_in_tool_mm, &place));
            }
            on_tool[k].ball_in_tool_mm = place;
        }
    }
    let rms_mm = |setups: Vec<Setup>| Claim { machine, setups, positions: claim.positions.clone() }.rms_mm();
    vec![(moved_on_table.join(" and "), rms_mm(on_table)), (moved_on_tool.join(" and "), rms_mm(on_tool))]
}
