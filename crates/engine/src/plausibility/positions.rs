//! Do the axes follow the ball? An R-test reads a ball in its nest, so both must be at one place; a ball bar keeps its two balls its length
//! apart. Both hold whatever the machine's errors are: these are a thousand times smaller than any mistake here.

use super::claim::{Claim, TOGETHER_MM, off_mm, rms};
use super::found::Implausible;
use super::places;
use std::f64::consts::PI;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{InstrumentKind, Joint};
use trunnion_cycles::Run;
use trunnion_machine::shipped;

/// Farther off than any probe of an R-test reads, and than any ball bar grows or shrinks, mm.
const FAR_MM: f64 = 5.0;
/// Points of which the distance is formed while mistakes are tried: evenly chosen, for time only.
const TRIED_POINTS: usize = 600;
/// More mistakes that explain all are not listed.
const MOST_LISTED: usize = 3;
const MM_OF_INCH: f64 = 25.4;

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    runs.iter().filter_map(of_run).collect()
}

fn of_run(run: &Run) -> Option<Implausible> {
    let is_known = |setup: usize| {
        let instrument = run.setups[setup].instrument;
        instrument == InstrumentKind::RTest || instrument.keeps_bar_length()
    };
    let rows: Vec<usize> =
        (0..run.points.len()).filter(|&row| is_known(run.points[row].state.setup)).collect();
    let off = |row: usize| {
        let state = &run.points[row].state;
        off_mm(&run.machine, &run.setups[state.setup], &state.position)
    };
    let far: Vec<usize> = rows.iter().copied().filter(|&row| off(row).norm() > FAR_MM).collect();
    let (first, last) = (*far.first()?, *far.last()?);
    if let Some(found) = standing(run, &rows, &far) {
        return Some(found);
    }
    let tried_rows = rows.iter().step_by(rows.len().div_ceil(TRIED_POINTS));
    let at = |&row: &usize| (run.points[row].state.setup, run.points[row].state.position);
    let claim =
        Claim { machine: &run.machine, setups: run.setups.clone(), positions: tried_rows.map(at).collect() };
    let apart_mm = rms(rows.iter().map(|&row| off(row)));
    let mut tried = mistakes(run, &claim);
    let best =
        |tried: &[(String, f64)]| tried.iter().map(|(_, rms_mm)| *rms_mm).fold(f64::INFINITY, f64::min);
    // Numbers that are fitted explain what any mistake does: they count where no mistake without a free number is enough.
    if best(&tried) > TOGETHER_MM {
        tried = places::offsets(&claim);
        tried.extend(places::other_places(&claim));
    }
    let best_mm = best(&tried);
    // Mistakes that undo it equally well are listed together: positions alone cannot choose.
    let mut listed: Vec<&str> = tried
        .iter()
        .filter(|(_, rms_mm)| best_mm < TOGETHER_MM && *rms_mm < 2.0 * best_mm + 0.01)
        .map(|(mistake, _)| mistake.as_str())
        .collect();
    listed.truncate(MOST_LISTED);
    let of_bar = run.setups[run.points[first].state.setup].instrument.keeps_bar_length();
    let how_far = match of_bar {
        true => format!("the ends of the ball bar are {apart_mm:.1} mm off its length"),
        false => format!("ball and nest are {apart_mm:.1} mm apart"),
    };
    let finding = format!(
        "{}: in {} of {} points (rows {} to {}) the axes do not follow the ball: by their positions, {how_far}.",
        run.name,
        far.len(),
        rows.len(),
        first + 1,
        last + 1,
    );
    let hypothesis = if listed.is_empty() {
        "No single mistake of those tried explains it. Compare the points with the setup file and the machine file.".into()
    } else {
        let left = if of_bar { "off" } else { "apart" };
        format!("With {} they are {best_mm:.1} mm {left}. Change it?", listed.join(", or "))
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
        tried.push((format!("the sense of {joint} reversed (sign −1)"), turned.rms_mm()));
    }
    for joints in [&linear, &rotary] {
        for (k, &a) in joints.iter().enumerate() {
            for &b in &joints[k + 1..] {
                let swapped = claim.turned(|position| {
                    let mut changed = *position;
                    (changed[a], changed[b]) = (changed[b], changed[a]);
                    changed
                });
                tried.push((format!("the columns of the axes {a} and {b} exchanged"), swapped.rms_mm()));
            }
        }
    }
    let scaled = |joints: &[Joint], factor: f64| {
        let turned = claim.turned(|position| {
            let mut changed = *position;
            joints.iter().for_each(|&joint| changed[joint] *= factor);
            changed
        });
        turned.rms_mm()
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
            let rms_mm = Claim { setups, ..claim.clone() }.rms_mm();
            let [a, b] = [a, b].map(|k| claim.setups[k].name.as_str());
            tried.push((format!("the setups {a} and {b} exchanged (position of the ball)"), rms_mm));
        }
    }
    tried
}
