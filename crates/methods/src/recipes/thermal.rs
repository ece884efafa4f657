//! Location errors over time: one cycle again and again while the machine warms up or cools down [ISO 230-3].
//!
//! A round ends where a pose of it comes again. The base model is fitted to each round by itself: p_k ± u_k at the mean time t_k of its
//! points. Change p_k − p_0, u² = u_k² + u_0². Time constant τ: the least of
//!     χ²(τ) = min over c, a of Σ (p_k − c − a (1 − e^(−(t_k − t_0)/τ)))² / u_k²
//! and u(τ) half the width of χ² ≤ χ²_min + max(1, χ²_min/(n − 3)), where both ends are among the values tried and a > 3 u(a).
//! Limits: what changes within a round is averaged, so τ of a few rounds and more is seen; one τ for each curve; one run, because each run
//! has a clock of its own; what the base model cannot separate in one round it cannot in any.

mod curve;

use super::{Convention, Method, MethodError, MethodOptions, one_machine};
use crate::Findings;
use crate::findings::{AxisName, Cell, Chart, Column, Curve, FoundTable, FoundValue, Plot};
use curve::{Moment, settled};
use std::collections::BTreeSet;
use trunnion_core::Point;
use trunnion_cycles::Run;
use trunnion_effects::{Model, Unit};
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, Identification, identify};

pub(super) static METHOD: Method = Method {
    name: "thermal",
    title: "Location errors over time: what warming up does to the axis lines",
    source: "ISO 230-3 (thermal effects)",
    about: "The same poses again and again for hours: where each axis line is in every round, how far it went, and how fast it settles.",
    takes_axis: false,
    takes_convention: false,
    needs: "one run with times whose poses are visited three times or more ([rounds] of the cycle), any instrument that shows location errors",
    gives: "each location error over time with its uncertainty, its change over the run, its time constant where the curve shows one",
    run,
};

/// A change and its time constant need a beginning, a way and an end.
const FEWEST_ROUNDS: usize = 3;
/// Curves that one chart distinguishes.
const CURVES: usize = 4;

/// One round as fitted.
struct Round {
    time_s: f64,
    degc: Vec<f64>,
    fit: Identification,
}

fn run(runs: &[Run], _: &MethodOptions) -> Result<Findings, MethodError> {
    one_machine(runs)?;
    let [run] = runs else {
        let found = format!("there are {} runs, and each has a clock of its own", runs.len());
        return Err(METHOD.lacks(found, "Give one long run; `trunnion history` compares runs."));
    };
    if !run.has_time() {
        return Err(METHOD.lacks("the points have no time", "Import them with time_s."));
    }
    let rounds = rounds(run)?;
    if rounds.len() < FEWEST_ROUNDS {
        let found = format!("the poses are visited {} times", rounds.len());
        return Err(METHOD.lacks(found, "Repeat the cycle: count in [rounds] of the cycle file."));
    }
    let rounds: Vec<Round> = rounds.iter().map(|points| fitted(run, points)).collect::<Result<_, _>>()?;
    Ok(described(runs, run, &rounds))
}

/// Points of each whole round; the last one counts when it has at least half the points of the first.
fn rounds(run: &Run) -> Result<Vec<Vec<Point>>, MethodError> {
    if run.good_points().next().is_none() {
        return Ok(Vec::new());
    }
    let experiment = Experiment::new(std::slice::from_ref(run))?;
    let joints = run.machine.joints();
    let came_from = |point: &Point| -> Vec<i64> {
        joints.iter().map(|&joint| point.state.direction[joint].signum() as i64).collect()
    };
    let mut rounds: Vec<Vec<Point>> = vec![Vec::new()];
    let mut visited = BTreeSet::new();
    for (point, pose) in experiment.points.iter().zip(experiment.poses()) {
        if !visited.insert((pose, point.state.target, came_from(point))) {
            visited = BTreeSet::from([(pose, point.state.target, came_from(point))]);
            rounds.push(Vec::new());
        }
        rounds.last_mut().expect("there is one from the beginning").push(point.clone());
    }
    let whole = rounds[0].len();
    rounds.retain(|points| 2 * points.len() >= whole.max(1));
    Ok(rounds)
}

fn fitted(run: &Run, points: &[Point]) -> Result<Round, MethodError> {
    let count = points.len() as f64;
    let mean = |of: &dyn Fn(&Point) -> f64| points.iter().map(of).sum::<f64>() / count;
    let round = Run { points: points.to_vec(), ..run.clone() };
    let experiment = Experiment::new(&[round])?;
    // All rounds together may have a fit where one has too few poses for it.
    let fit = identify(&experiment, &Model::base(&run.machine.name), &Options::default()).map_err(|why| {
        METHOD.lacks(
            format!("one round of {count} points has no fit of its own ({why})"),
            "Measure more poses in each round.",
        )
    })?;
    Ok(Round {
        time_s: mean(&|point| point.state.time_s.unwrap_or_default()),
        degc: (0..run.channels.len())
            .map(|k| mean(&|point| point.state.temperature_degc.get(k).copied().unwrap_or(f64::NAN)))
            .collect(),
        fit,
    })
}

/// One location error over the rounds.
struct Followed {
    name: String,
    unit: Unit,
    moments: Vec<Moment>,
}

impl Followed {
    /// Last minus first.
    fn change(&self) -> (f64, f64) {
        let (first, last) = (&self.moments[0], &self.moments[self.moments.len() - 1]);
        (last.value - first.value, last.u.hypot(first.u))
    }

    fn curve(&self) -> Curve {
        let first = &self.moments[0];
        let from_first = |moment: &Moment| (moment.time_s - first.time_s, moment.value - first.value);
        Curve::new(&self.name, self.moments.iter().map(from_first).collect())
    }
}

/// Location errors that have a number in every round.
fn followed(rounds: &[Round]) -> Vec<Followed> {
    let of_machine =
        rounds[0].fit.parameters.iter().filter(|parameter| parameter.effect == "location-errors");
    let over_time = |name: &str| -> Option<Vec<Moment>> {
        let moment = |round: &Round| {
            let parameter = round.fit.parameters.iter().find(|parameter| parameter.name == name)?;
            Some(Moment { time_s: round.time_s, value: parameter.value?, u: parameter.u? })
        };
        rounds.iter().map(moment).collect()
    };
    of_machine
        .filter_map(|parameter| {
            let moments = over_time(&parameter.name)?;
            Some(Followed { name: parameter.name.clone(), unit: parameter.unit, moments })
        })
        .collect()
}

fn described(runs: &[Run], run: &Run, rounds: &[Round]) -> Findings {
    let mut findings = METHOD.findings(runs, Convention::RightHanded);
    let followed = followed(rounds);
    for one in &followed {
        let (change, u) = one.change();
        findings.values.push(FoundValue::new(format!("{} change", one.name), change, one.unit, Some(u)));
        if let Some((tau_s, u_s)) = settled(&one.moments) {
            let note = "time to 63 % of the way";
            let value = FoundValue::new(format!("{} time constant", one.name), tau_s, Unit::S, Some(u_s));
            findings.values.push(value.note(note));
        }
    }
    findings.tables.push(table(run, rounds, &followed));
    for (group, unit) in [("Place of the axis lines", Unit::UM), ("Lean of the axis lines", Unit::URAD)] {
        let of_unit: Vec<&Followed> = followed.iter().filter(|one| one.unit == unit).collect();
        findings.charts.extend(of_unit.chunks(CURVES).map(|some| Chart {
            group: group.into(),
            title: "Change since the first round".into(),
            plot: Plot::Xy {
                x: AxisName { name: "time since the first round".into(), unit: Unit::S },
                y: AxisName { name: "change".into(), unit },
                curves: some.iter().map(|one| one.curve()).collect(),
            },
        }));
    }
    findings.notes.push(format!(
        "Each of {} rounds is fitted by itself; a location error without a number in one of them is left out.",
        rounds.len()
    ));
    findings
}

fn table(run: &Run, rounds: &[Round], followed: &[Followed]) -> FoundTable {
    let mut columns = vec![Column::of("time", Unit::S)];
    columns.extend(run.channels.iter().map(|channel| Column::plain(format!("{channel} (°C)"))));
    for Followed { name, unit, .. } in followed {
        columns.extend([Column::of(name.clone(), *unit), Column::of(format!("u({name})"), *unit)]);
    }
    let row = |(k, round): (usize, &Round)| {
        let number = |value: f64| if value.is_finite() { Cell::Number(value) } else { Cell::Missing };
        let mut cells = vec![number(round.time_s)];
        cells.extend(round.degc.iter().map(|&degc| number(degc)));
        for Followed { moments, .. } in followed {
            cells.extend([number(moments[k].value), number(moments[k].u)]);
        }
        cells
    };
    FoundTable {
        caption: "Location errors in each round".into(),
        columns,
        rows: rounds.iter().enumerate().map(row).collect(),
    }
}
