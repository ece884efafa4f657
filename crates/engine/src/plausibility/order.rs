//! Times and directions: does the order of the points make sense?

use super::clock::set_back;
use super::found::{Implausible, plain};
use crate::problem::steps::{FEWEST_STEPS, only_direction, steps, steps_by};
use std::f64::consts::TAU;
use trunnion_core::{Joint, Point, statistics};
use trunnion_cycles::{Run, RunKind};

/// No cycle lasts longer; the longest of docs/use are thermal runs of a night, s.
const LONGEST_S: f64 = 3.0 * 86_400.0;
/// Mean speeds between poses at rest that no axis reaches from stop to stop, rad/s and mm/s: rapids of fast machines are 60 m/min, and
/// tables that turn faster than once a second do so in turning, not from pose to pose. Steps of 30° every 4 s are 450°/s where minutes are
/// taken for seconds.
const FASTEST_RAD_PER_S: f64 = TAU;
const FASTEST_MM_PER_S: f64 = 1000.0;
/// Units that are taken for seconds, and the usual time for a pose: the unit that comes nearest to it is named.
const USUAL_S: f64 = 5.0;
const UNITS: [(&str, f64); 3] = [("minutes", 60.0), ("hours", 3600.0), ("days", 86_400.0)];
/// Share of the steps against the stated directions, where both are stated: what is left are the returns to the beginning of a pass.
const REVERSED: f64 = 0.9;
/// A direction that is stated of another axis says nothing: half of the steps go against it, and on no cycle so few as a quarter.
const STRANGE: f64 = 0.25;
/// Feeds below which nothing is measured on the fly, 5°/min and 5 mm/min: a circle of 150 mm would take three hours. A usual feed of
/// 1000 mm/min is 1 mm/min where milliseconds are taken for seconds.
const SLOWEST_RAD_PER_S: f64 = TAU / 72.0 / 60.0;
const SLOWEST_MM_PER_S: f64 = 5.0 / 60.0;
/// A count is not that of a random order when it is so many standard deviations away: one in 700 on one side [normal distribution].
const SURE: f64 = 3.0;
/// With fewer steps a random order may run back no more often than a clock that began again twice: n/2 − SURE √((n + 2)/12) is 2 for
/// n = 10. Then only rows that run back in most of their steps are named.
const FEWEST_TIMES: usize = 11;
/// So many steps that all run back are the reversed order: of the 6! orders of six rows it is one, as seldom as [`SURE`] asks.
const REVERSED_STEPS: usize = 5;

/// `belong`: the positions can be right, so that directions can be compared with them.
pub(super) fn implausible(runs: &[Run], belong: bool) -> Vec<Implausible> {
    let of_run = |run: &Run| {
        let joints = if belong { run.machine.joints() } else { Vec::new() };
        let mut directions: Vec<Implausible> = match exchanged(run, &joints) {
            Some(exchanged) => vec![exchanged],
            None => joints.into_iter().filter_map(|joint| against(run, joint)).collect(),
        };
        if let [_, .., last] = &mut directions[..] {
            last.hypothesis +=
                " Where several axes go against their directions, the positions may stand in reversed order.";
        }
        backward(run)
            .or_else(|| set_back(run))
            .into_iter()
            .chain(too_long(run))
            .chain(too_fast(run))
            .chain(too_slow(run))
            .chain(directions)
            .collect::<Vec<_>>()
    };
    runs.iter().flat_map(of_run).collect()
}

fn times(run: &Run) -> Vec<f64> {
    run.points.iter().filter_map(|point| point.state.time_s).collect()
}

/// Time that runs backward, or in no order. The number of descents of a random order of n + 1 values has the mean n/2 and the variance
/// (n + 2)/12 [Eulerian numbers, Graham 1994 §6.2]; in the order in which points are taken there are none, but where a setup begins.
fn backward(run: &Run) -> Option<Implausible> {
    let of_one_setup = |pair: &&[Point]| pair[0].state.setup == pair[1].state.setup;
    let steps: Vec<f64> = run
        .points
        .windows(2)
        .filter(of_one_setup)
        .filter_map(|pair| Some(pair[1].state.time_s? - pair[0].state.time_s?))
        .collect();
    let back = steps.iter().filter(|step| **step < 0.0).count();
    let (count, mean) = (steps.len(), steps.len() as f64 / 2.0);
    let random = SURE * ((count as f64 + 2.0) / 12.0).sqrt();
    let few = count < FEWEST_TIMES;
    let reversed = match few {
        true => count >= REVERSED_STEPS && back == count,
        false => back as f64 > mean + random,
    };
    let in_order = if few { 2 * back <= count + 1 } else { (back as f64) < mean - random };
    if in_order {
        return None;
    }
    let advice = match (reversed, few && back == count) {
        // One order of a few dozen at most: it may be either.
        (false, true) => "The rows were reversed or shuffled, or the times belong to other rows.",
        (false, false) => "The rows were shuffled, or the times belong to other rows.",
        (true, _) => "The rows stand in reversed order, or the times do.",
    };
    let advice = format!("{advice} Give the rows in the order in which they were taken.");
    Some(match reversed {
        true => plain(
            format!("{}: time runs backward from row to row ({back} of {count} steps).", run.name),
            &advice,
        ),
        false => plain(
            format!(
                "{}: the rows are in no order of time: it runs back in {back} of {count} steps.",
                run.name
            ),
            &advice,
        ),
    })
}

fn too_long(run: &Run) -> Option<Implausible> {
    let times = times(run);
    let last = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let first = times.iter().copied().fold(f64::INFINITY, f64::min);
    let span_s = last - first;
    (span_s > LONGEST_S).then(|| {
        plain(
            format!("{}: by its times the cycle took {:.0} days, which is too long.", run.name, span_s / 86_400.0),
            "In milliseconds instead of seconds (factor 1000) it would be plausible. Check the units of time_s.",
        )
    })
}

/// Poses at rest in too quick a sequence, or rows on the fly in one that no axis follows. Equal times say nothing of it, and points that were
/// formed from samples have the times of a clock.
fn too_fast(run: &Run) -> Option<Implausible> {
    if run.points.iter().any(|point| point.samples > 1) {
        return None;
    }
    let Pace { usual_s, usual, .. } = Pace::of(run, FASTEST_RAD_PER_S, FASTEST_MM_PER_S)?;
    let off_usual = |(_, factor): &&(&str, f64)| (usual_s * factor / USUAL_S).ln().abs();
    let nearest = UNITS.iter().min_by(|a, b| off_usual(a).total_cmp(&off_usual(b)));
    // On the fly there is no usual time from row to row: the unit that is the least off.
    let (rows, digits, and_stop, (unit, factor)) = match run.kind {
        RunKind::Static => ("its poses at rest", 3, " and stop", nearest.unwrap_or(&UNITS[0])),
        RunKind::OnTheFly => ("on the fly its rows", 6, "", &UNITS[0]),
    };
    (usual > 1.0).then(|| {
        plain(
            format!(
                "{}: {rows} are {usual_s:.digits$} s apart, for which an axis would have to move at more than 360°/s or 60 m/min{and_stop}.",
                run.name
            ),
            &format!(
                "In {unit} instead of seconds (factor {factor}) it would be plausible. Check the units of time_s."
            ),
        )
    })
}

/// Rows on the fly that follow each other too slowly.
fn too_slow(run: &Run) -> Option<Implausible> {
    if run.kind != RunKind::OnTheFly {
        return None;
    }
    let Pace { usual_s, fastest, .. } = Pace::of(run, SLOWEST_RAD_PER_S, SLOWEST_MM_PER_S)?;
    (fastest < 1.0).then(|| {
        plain(
            format!(
                "{}: on the fly its rows are {usual_s:.1} s apart, and no axis moves faster than 5 mm/min or 5°/min.",
                run.name
            ),
            "In milliseconds instead of seconds (factor 1000) it would be plausible. Check the units of time_s.",
        )
    })
}

/// How the rows of a run follow each other.
struct Pace {
    /// Usual time between two rows at which an axis moved, s.
    usual_s: f64,
    /// Usual speed of the axis that is the fastest there, as a share of what was asked about.
    usual: f64,
    /// The greatest of these.
    fastest: f64,
}

impl Pace {
    /// Speeds as shares of these; `None` of few rows.
    fn of(run: &Run, rad_per_s: f64, mm_per_s: f64) -> Option<Self> {
        let joints = run.machine.joints();
        let share = |from: &Point, to: &Point| {
            let step_s = to.state.time_s? - from.state.time_s?;
            let of_joint = |joint: &Joint| {
                let moved = to.state.position[*joint] - from.state.position[*joint];
                match joint.is_rotary() {
                    true => (moved - (moved / TAU).round() * TAU).abs() / rad_per_s,
                    false => moved.abs() / mm_per_s,
                }
            };
            let least_s = joints.iter().map(of_joint).fold(0.0, f64::max);
            (step_s > 0.0 && least_s > 0.0).then_some((step_s, least_s / step_s))
        };
        let (steps_s, shares): (Vec<f64>, Vec<f64>) =
            run.points.windows(2).filter_map(|pair| share(&pair[0], &pair[1])).unzip();
        if steps_s.len() < FEWEST_TIMES {
            return None;
        }
        let fastest = shares.iter().fold(0.0, |a: f64, b| a.max(*b));
        Some(Self { usual_s: statistics::median(&steps_s)?, usual: statistics::median(&shares)?, fastest })
    }
}

/// Two axes whose directions stand in each other's columns: as they are, many steps of both go against them; exchanged, hardly any does.
fn exchanged(run: &Run, joints: &[Joint]) -> Option<Implausible> {
    let points = &run.points;
    let contrary = |joint: Joint, stated_of: Joint| {
        let steps = steps_by(points, joint, stated_of);
        let contrary = steps.iter().filter(|step| step.is_contrary()).count();
        (steps.len() >= FEWEST_STEPS).then_some((contrary, steps.len()))
    };
    let share = |(contrary, count): (usize, usize)| contrary as f64 / count as f64;
    let is_strange = |of: &(usize, usize)| share(*of) > STRANGE;
    let agrees = |of: &(usize, usize)| share(*of) < 1.0 - REVERSED;
    let stated = joints.iter().filter(|joint| only_direction(points, **joint).is_none());
    let strange: Vec<(Joint, (usize, usize))> =
        stated.filter_map(|&joint| Some((joint, contrary(joint, joint).filter(is_strange)?))).collect();
    let pairs = strange.iter().enumerate().flat_map(|(k, a)| strange[k + 1..].iter().map(move |b| (a, b)));
    let found = pairs.into_iter().find(|((a, _), (b, _))| {
        [(*a, *b), (*b, *a)]
            .iter()
            .all(|(joint, other)| contrary(*joint, *other).is_some_and(|of| agrees(&of)))
    });
    found.map(|((a, of_a), (b, of_b))| {
        let [column_a, column_b] = [a, b].map(|joint| format!("direction_{}", joint.lower()));
        plain(
            format!(
                "{}: {column_a} is opposite to the motion of {a} in {} of {} steps, and {column_b} to that of {b} in {} of {}.",
                run.name, of_a.0, of_a.1, of_b.0, of_b.1
            ),
            &format!("Exchanged, both columns agree with the motion. Exchange {column_a} and {column_b} in the file."),
        )
    })
}

/// An axis whose stated directions are the opposite of its steps. One direction throughout is none of it: it may be an approach from one
/// side, and is asked of the readings ([`super::ways`]).
fn against(run: &Run, joint: Joint) -> Option<Implausible> {
    let steps = steps(&run.points, joint);
    let count = steps.len();
    if run.kind != RunKind::Static || count < FEWEST_STEPS || only_direction(&run.points, joint).is_some() {
        return None;
    }
    let column = format!("direction_{}", joint.lower());
    let contrary = steps.iter().filter(|step| step.is_contrary()).count();
    (contrary as f64 > REVERSED * count as f64).then(|| {
        plain(
            format!("{}: {column} is opposite to the motion of {joint} in {contrary} of {count} steps.", run.name),
            &format!(
                "The signs of {column} are reversed, and backlash would have the wrong sign. Give +1 where {joint} came from below."
            ),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use trunnion_core::axis::iso::{X, Y};
    use trunnion_core::{InstrumentKind, NestSide, Quality, Setup, State};

    fn found(times: &[f64]) -> Option<String> {
        let ball = Setup::new("ball", InstrumentKind::RTest, NestSide::Table, Point3::new(100.0, 0.0, 50.0));
        let machine = trunnion_machine::shipped::machine("table-bc").unwrap();
        let at = |time: &f64| Point {
            state: State { time_s: Some(*time), ..State::default() },
            reading_mm: [0.0; 3],
            spread_mm: [0.0; 3],
            samples: 1,
            quality: Quality::Good,
        };
        let points = times.iter().map(at).collect();
        let kind = RunKind::Static;
        let run = Run { name: "short".into(), machine, kind, setups: vec![ball], channels: vec![], points };
        backward(&run).map(|found| found.finding)
    }

    /// A circle on the fly in XY, there and back, a row every `row_s`.
    fn circle(row_s: f64) -> Run {
        let bar = Setup::new("bar", InstrumentKind::BallBar, NestSide::Table, Point3::new(0.0, 0.0, 100.0));
        let machine = trunnion_machine::shipped::machine("three-axis").unwrap();
        let at = |k: i32| {
            let (way, turn) = if k < 360 { (1.0, f64::from(k)) } else { (-1.0, f64::from(719 - k)) };
            let (sin, cos) = (turn + 0.5).to_radians().sin_cos();
            let mut state = State { time_s: Some(row_s * f64::from(k)), ..State::default() };
            for (joint, place, heading) in [(X, cos, -way * sin), (Y, sin, way * cos)] {
                state.position[joint] = 150.0 * place;
                state.direction[joint] = f64::signum(heading);
            }
            Point { state, reading_mm: [0.0; 3], spread_mm: [0.0; 3], samples: 1, quality: Quality::Good }
        };
        let points = (0..720).map(at).collect();
        Run {
            name: "xy".into(),
            machine,
            kind: RunKind::OnTheFly,
            setups: vec![bar],
            channels: vec![],
            points,
        }
    }

    fn words(run: Run) -> String {
        implausible(&[run], true).iter().map(|one| format!("{} {}\n", one.finding, one.hypothesis)).collect()
    }

    #[test]
    fn directions_in_each_others_columns_are_named_and_right_ones_are_not() {
        assert_eq!(words(circle(0.16)), "");
        let mut exchanged = circle(0.16);
        for point in &mut exchanged.points {
            let [x, y] = [X, Y].map(|joint| point.state.direction[joint]);
            (point.state.direction[X], point.state.direction[Y]) = (y, x);
        }
        let said = words(exchanged);
        assert!(said.contains("Exchange direction_x and direction_y in the file"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        // An axis whose signs are wrong is not exchanged with another.
        let mut reversed = circle(0.16);
        reversed.points.iter_mut().for_each(|point| point.state.direction[X] *= -1.0);
        assert!(!words(reversed).contains("Exchange"));
    }

    #[test]
    fn milliseconds_in_the_column_of_seconds_are_named_on_the_fly() {
        // 2.6 mm every 0.16 s are 980 mm/min.
        let said = words(circle(160.0));
        assert!(
            said.contains("160.0 s apart") && said.contains("In milliseconds instead of seconds"),
            "{said}"
        );
        assert_eq!(words(circle(1.6)), "", "98 mm/min is slow, and possible");
    }

    #[test]
    fn minutes_in_the_column_of_seconds_are_named_on_the_fly() {
        // 2.6 mm every 0.08 s are 2 m/min, and 118 m/min by minutes.
        let said = words(circle(0.08 / 60.0));
        assert!(
            said.contains("rows are 0.001333 s apart")
                && said.contains("In minutes instead of seconds (factor 60)"),
            "{said}"
        );
        assert_eq!(words(circle(0.01)), "", "16 m/min is fast, and possible");
    }

    #[test]
    fn few_rows_in_reversed_order_are_named_and_a_clock_that_began_again_is_not() {
        assert_eq!(found(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), None);
        let reversed = found(&[5.0, 4.0, 3.0, 2.0, 1.0, 0.0]).expect("a finding");
        assert!(reversed.contains("backward from row to row (5 of 5 steps)"), "{reversed}");
        assert_eq!(found(&[0.0, 1.0, 2.0, 0.0, 1.0, 2.0]), None, "the clock began again");
    }

    #[test]
    fn few_rows_in_a_random_order_are_not_called_reversed() {
        // Seven of eleven steps back, as three random orders of twelve rows in twenty have them or more.
        let shuffled = [9.0, 4.0, 11.0, 7.0, 2.0, 10.0, 8.0, 6.0, 1.0, 5.0, 3.0];
        let finding = found(&shuffled).expect("a finding");
        assert!(finding.contains("in no order of time: it runs back in 7 of 10 steps"), "{finding}");
        // One short of all.
        let nearly = found(&[5.0, 4.0, 3.0, 2.0, 0.0, 1.0]).expect("a finding");
        assert!(nearly.contains("in no order of time"), "{nearly}");
        let five = found(&[4.0, 3.0, 2.0, 1.0, 0.0]).expect("a finding");
        assert!(five.contains("in no order of time"), "one order of 120: {five}");
        // Enough steps for the count of a random order: all back, and half of them.
        let down: Vec<f64> = (0..12).rev().map(f64::from).collect();
        assert!(found(&down).expect("a finding").contains("backward from row to row (11 of 11 steps)"));
        let zigzag: Vec<f64> = (0..12).map(|k| f64::from(k % 2 * 20 + k)).collect();
        assert!(found(&zigzag).expect("a finding").contains("in no order of time"));
        // A clock that began again twice is an order.
        let twice: Vec<f64> = (0..12).map(|k| f64::from(k % 4)).collect();
        assert_eq!(found(&twice), None);
    }
}
