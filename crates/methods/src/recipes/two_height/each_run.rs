//! Runs that hold both heights each, evaluated one by one [S0 table 1, fig. 18–21]: what differs between them is no error of one machine.
//!
//! Location errors of a run by its own heights. An error differs where its largest and its smallest value are apart by more than their u, among all
//! pairs of runs and all errors (`common::significance`). A run has few passes, so u is the root mean square over the runs.
//! Limits: a run with one height counts in the heights of all runs alone.

use super::fit::Heights;
use crate::common::significance::is_significant;
use crate::common::turning::{Turning, TurningSet};
use crate::findings::{Cell, Chart, Column, Curve, FoundTable, FoundValue, Plot};
use crate::recipes::Method;
use std::f64::consts::SQRT_2;
use trunnion_core::number::signed;
use trunnion_core::statistics;
use trunnion_cycles::Run;
use trunnion_effects::Unit;

/// One run by itself.
pub(super) struct OfRun {
    /// Number and name of the run.
    pub name: String,
    pub heights: Heights,
}

/// Every run that holds two heights; nothing unless there are several of them.
pub(super) fn evaluated(method: &Method, turning: &Turning, runs: &[Run]) -> Vec<OfRun> {
    let of = |(at, run): (usize, &Run)| {
        let sets: Vec<TurningSet> = turning.sets.iter().filter(|set| set.run == at).cloned().collect();
        if sets.len() < 2 {
            return None;
        }
        let alone = Turning { sets, ..turning.clone() };
        // With one height it has no line of its own.
        let heights = Heights::of(method, &alone).ok()?;
        Some(OfRun { name: format!("{} {}", at + 1, run.name), heights })
    };
    let each: Vec<OfRun> = runs.iter().enumerate().filter_map(of).collect();
    if each.len() > 1 { each } else { Vec::new() }
}

/// One location error of every run.
pub(super) struct OverRuns<'a> {
    of_runs: Vec<&'a FoundValue>,
    /// Of how many errors it is one.
    errors: usize,
}

impl<'a> OverRuns<'a> {
    /// Of each location error of runs whose values are `located`, in their order.
    pub fn all(located: &'a [Vec<FoundValue>]) -> Vec<Self> {
        let errors = located.first().map_or(0, Vec::len);
        let of = |k: usize| Self { of_runs: located.iter().map(|of_run| &of_run[k]).collect(), errors };
        (0..errors).map(of).collect()
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.of_runs.iter().map(|found| found.value)
    }

    fn extent(&self) -> [f64; 2] {
        self.values().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    }

    /// Standard uncertainty of a difference between two runs.
    fn u_apart(&self) -> f64 {
        SQRT_2 * statistics::rms(self.of_runs.iter().filter_map(|found| found.u)).unwrap_or(0.0)
    }

    /// Whether the runs disagree by more than their uncertainties.
    pub fn differs(&self) -> bool {
        let ([low, high], runs) = (self.extent(), self.of_runs.len());
        is_significant(high - low, self.u_apart(), self.errors * runs * (runs - 1) / 2)
    }

    /// `EB0C from −554.1 to −30.0 µrad`.
    fn words(&self) -> String {
        let unit = self.of_runs[0].unit;
        let [low, high] = self.extent().map(|value| signed(value * unit.per_inside, 1));
        format!("{} from {low} to {high} {}", self.of_runs[0].name, unit.text())
    }

    /// The value of all heights together where the runs differ: uncertain by how much the mean of other runs would be another.
    pub fn widened(&self, common: FoundValue) -> FoundValue {
        let count = self.of_runs.len() as f64;
        let mean = self.values().sum::<f64>() / count;
        let scatter = (self.values().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
        let u = common.u.map(|u| u.hypot(scatter / count.sqrt()));
        let note = format!("mean of runs that disagree, {}; {}", self.words(), common.note);
        FoundValue { u, ..common }.note(note.trim_end_matches("; "))
    }
}

/// Values of each run, and their differences to the first.
pub(super) fn tables(each: &[OfRun], located: &[Vec<FoundValue>]) -> Vec<FoundTable> {
    let Some(first) = located.first() else { return Vec::new() };
    let of_errors = |found: &FoundValue| {
        [Column::of(found.name.clone(), found.unit), Column::of(format!("u of {}", found.name), found.unit)]
    };
    let columns: Vec<Column> =
        std::iter::once(Column::plain("run")).chain(first.iter().flat_map(of_errors)).collect();
    let u_apart: Vec<f64> = OverRuns::all(located).iter().map(OverRuns::u_apart).collect();
    let own = |found: &FoundValue, _: usize| {
        [Cell::Number(found.value), found.u.map_or(Cell::Missing, Cell::Number)]
    };
    let to_first =
        |found: &FoundValue, k: usize| [Cell::Number(found.value - first[k].value), Cell::Number(u_apart[k])];
    let table = |caption: &str, from: usize, cells: &dyn Fn(&FoundValue, usize) -> [Cell; 2]| {
        let row = |(run, found): (&OfRun, &Vec<FoundValue>)| {
            let numbers = found.iter().enumerate().flat_map(|(k, found)| cells(found, k));
            std::iter::once(Cell::Text(run.name.clone())).chain(numbers).collect()
        };
        let rows = each.iter().zip(located).skip(from).map(row).collect();
        FoundTable { caption: caption.into(), columns: columns.clone(), rows }
    };
    vec![
        table("Location errors of each run by its own heights (S0 table 1)", 0, &own),
        table(&format!("Differences of each run to run {}", each[0].name), 1, &to_first),
    ]
}

/// Whether the values of all heights together are those of one machine, in words; nothing where the runs agree.
pub(super) fn doubt(located: &[Vec<FoundValue>]) -> Option<String> {
    let over_runs = OverRuns::all(located);
    let differ: Vec<String> = over_runs.iter().filter(|of| of.differs()).map(OverRuns::words).collect();
    (!differ.is_empty()).then(|| {
        format!(
            "The runs disagree by more than their uncertainties: {}. The values of all runs together are a mean of different states of the machine: use the table of \
             each run. To get one value, give the runs of one state alone.",
            differ.join(", ")
        )
    })
}

/// Trajectories of all runs at each height over each other, setting and place of the line taken off.
pub(super) fn overlay(turning: &Turning, each: &[OfRun]) -> Vec<Chart> {
    let heights = each.iter().map(|run| run.heights.sets.len()).min().unwrap_or(0);
    let [u, v, _] = turning.frame;
    let of_height = |k: usize| {
        let path = |run: &OfRun| {
            let mut points: Vec<_> =
                run.heights.sets[k].motion_mm.iter().flatten().map(|m| (m.x, m.y)).collect();
            if turning.whole_turn() {
                points.extend(points.first().copied());
            }
            Curve::new(run.name.clone(), points)
        };
        Chart {
            group: "Trajectories of each run without setting and place of the line (S0 Fig. 18–21)".into(),
            title: format!("Trajectory in {u} and {v}, {}", each[0].heights.sets[k].name),
            plot: Plot::Path {
                unit: Unit::UM,
                names: [u, v].map(|letter| letter.as_str().into()),
                curves: each.iter().map(path).collect(),
            },
        }
    };
    (0..heights).map(of_height).collect()
}
