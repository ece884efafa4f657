//! Do the axes follow the ball? An R-test reads a ball in its nest, so both must be at one place; a ball bar keeps its two balls its length
//! apart. Both hold whatever the machine's errors are: these are a thousand times smaller than any mistake here.

use super::claim::{Claim, TOGETHER_MM, off_mm, rms};
use super::found::Implausible;
use super::{mirrored, places, tip};
use std::f64::consts::PI;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{InstrumentKind, Joint, Setup};
use trunnion_cycles::Run;
use trunnion_machine::shipped;

/// Farther off than any probe of an R-test reads, and than any ball bar grows or shrinks, mm.
pub(super) const FAR_MM: f64 = 5.0;
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
    // A mistake in one setup alone says more than that its rows are wrong.
    let in_setup = in_one_setup(run, &rows, &far).and_then(|(setup, own)| {
        let of_setup = |(mistake, rms_mm): (String, f64)| {
            (format!("{mistake} (setup {} alone)", run.setups[setup].name), rms_mm)
        };
        let tried = tried(run, &own).into_iter().map(of_setup).collect();
        Some((own, explained(tried)?))
    });
    if in_setup.is_none()
        && let Some(found) = standing(run, &rows, &far)
    {
        return Some(found);
    }
    let (rows, explained) = in_setup.map_or_else(
        || {
            let explained = explained(tried(run, &rows));
            (rows, explained)
        },
        |(own, explained)| (own, Some(explained)),
    );
    let apart_mm = rms(rows.iter().map(|&row| off(row)));
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
    let claim = claimed(run, &rows);
    let hypothesis = match &explained {
        _ if !of_bar && tip::stands_while_turning(&claim) => tip::HYPOTHESIS.into(),
        None => "No single mistake of those tried explains it. Compare the points with the setup file and the machine file.".into(),
        Some((mistakes, left_mm)) => {
            let left = if of_bar { "off" } else { "apart" };
            let change = match mirrored::either_side(&claim) {
                Some(mirror) => mirror.distinguished_by(),
                None => "Change it?".into(),
            };
            format!("With {mistakes} they are {left_mm:.1} mm {left}. {change}")
        }
    };
    Some(Implausible {
        finding,
        hypothesis,
        rms_um_with_it: explained.map(|(_, left_mm)| um_from_mm(left_mm)),
    })
}

/// The setup that has all the points that are far off, and its rows; `None` where others have some, there is no other, or most of its own
/// are right.
fn in_one_setup(run: &Run, rows: &[usize], far: &[usize]) -> Option<(usize, Vec<usize>)> {
    let of = |row: &usize| run.points[*row].state.setup;
    let setup = of(far.first()?);
    let own: Vec<usize> = rows.iter().copied().filter(|row| of(row) == setup).collect();
    let is_alone = far.iter().all(|row| of(row) == setup) && own.len() < rows.len();
    (is_alone && 2 * far.len() >= own.len()).then_some((setup, own))
}

/// What some rows say, evenly chosen where there are many.
pub(super) fn claimed<'r>(run: &'r Run, rows: &[usize]) -> Claim<'r> {
    claim_of(run, rows.iter().step_by(rows.len().div_ceil(TRIED_POINTS).max(1)))
}

fn claim_of<'r, 'a>(run: &'r Run, rows: impl Iterator<Item = &'a usize>) -> Claim<'r> {
    let at = |&row: &usize| (run.points[row].state.setup, run.points[row].state.position);
    Claim { machine: &run.machine, setups: run.setups.clone(), positions: rows.map(at).collect() }
}

/// Every mistake, with what ball and nest are apart when it is undone, mm.
fn tried(run: &Run, rows: &[usize]) -> Vec<(String, f64)> {
    let claim = claimed(run, rows);
    let mut tried = mistakes(run, &claim);
    tried.extend(late(&claim_of(run, rows.iter().take(TRIED_POINTS))));
    // Numbers that are fitted explain what any mistake does: they count where no mistake without a free number is enough.
    if explained(tried.clone()).is_none() {
        tried = places::offsets(&claim);
        tried.extend(places::other_places(&claim));
    }
    tried
}

/// What is off with the best mistake undone, mm, and every mistake that undoes it equally well: positions alone cannot choose.
fn explained(tried: Vec<(String, f64)>) -> Option<(String, f64)> {
    let best_mm = tried.iter().map(|(_, rms_mm)| *rms_mm).fold(f64::INFINITY, f64::min);
    let as_good = tried.into_iter().filter(|(_, rms_mm)| *rms_mm < 2.0 * best_mm + 0.01);
    let listed: Vec<String> = as_good.map(|(mistake, _)| mistake).take(MOST_LISTED).collect();
    (best_mm < TOGETHER_MM).then(|| (listed.join(", or "), best_mm))
}

/// Positions of one axis, or of all linear or rotary ones, that stand a row too late or too early: neighbours are needed.
fn late(claim: &Claim<'_>) -> Vec<(String, f64)> {
    let machine = claim.machine;
    let one = machine.joints().into_iter().map(|joint| vec![joint]);
    let several = [machine.linear_joints(), machine.rotary_joints()];
    let several = several.into_iter().filter(|joints| joints.len() > 1);
    let shifted = |joints: &[Joint], earlier: bool| {
        let neighbours = claim.positions.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        let moved = neighbours.map(|pair| {
            let ((setup, mut position), (_, from)) =
                if earlier { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
            joints.iter().for_each(|&joint| position[joint] = from[joint]);
            (setup, position)
        });
        Claim { positions: moved.collect(), ..claim.clone() }.rms_mm()
    };
    let both = |joints: Vec<Joint>| {
        let names: Vec<&str> = joints.iter().map(|joint| joint.as_str()).collect();
        let names = names.join(" and ");
        [
            (format!("the positions of {names}, which are one row late, moved up"), shifted(&joints, true)),
            (
                format!("the positions of {names}, which are one row early, moved down"),
                shifted(&joints, false),
            ),
        ]
    };
    one.chain(several).flat_map(both).collect()
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
    let rows = match first == last {
        true => format!("row {}", first + 1),
        false => format!("rows {} to {}", first + 1, last + 1),
    };
    let finding = format!("{}: in {rows} the axes do not follow the ball, elsewhere they do.", run.name);
    let hypothesis = if let Some(setup) = other_setup(run, far) {
        format!("By their positions they are of setup {setup}. Correct the setup of {rows}.")
    } else if stuck.is_empty() || first == last {
        format!("Read the positions of {rows} again.")
    } else {
        format!(
            "The position of {} stays the same there: it was not updated. Read these rows again.",
            stuck.join(" and ")
        )
    };
    Some(Implausible { finding, hypothesis, rms_um_with_it: None })
}

/// Name of a setup to whose ball all these rows belong.
fn other_setup<'r>(run: &'r Run, rows: &[usize]) -> Option<&'r str> {
    let belongs = |setup: &&Setup| {
        let off = |row: &usize| off_mm(&run.machine, setup, &run.points[*row].state.position).norm();
        rows.iter().all(|row| off(row) < TOGETHER_MM)
    };
    run.setups.iter().find(belongs).map(|setup| setup.name.as_str())
}

/// Every mistake that is tried, with what ball and nest are apart when it is undone, mm.
fn mistakes(run: &Run, claim: &Claim<'_>) -> Vec<(String, f64)> {
    let machine = claim.machine;
    let (linear, rotary) = (machine.linear_joints(), machine.rotary_joints());
    let mut tried = Vec::new();
    // Rotary axes first: controls count them one way or the other, linear ones seldom.
    for &joint in rotary.iter().chain(&linear) {
        let left_mm = mirrored::reversed_mm(claim, &[joint]);
        tried.push((format!("the sense of {joint} reversed (sign −1)"), left_mm));
        if rotary.len() > 1 && rotary.last() == Some(&joint) {
            let words = format!("the senses of {} reversed (sign −1)", mirrored::names(&rotary));
            tried.push((words, mirrored::reversed_mm(claim, &rotary)));
        }
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
    // Divided by 1000, every mismatch is small. It says something only where the balls are not together with all axes at zero as well.
    if scaled(&linear, 0.0) > TOGETHER_MM {
        tried.push(("lengths given in µm, not in mm".into(), scaled(&linear, 1e-3)));
    }
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
