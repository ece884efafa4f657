//! The orders in which the poses of a table may have been measured, or sorted.

use crate::Experiment;
use crate::problem::passes::moving_axes;
use crate::problem::poses::{number, stood};
use std::cmp::Ordering;
use trunnion_core::{AxisValues, Joint};
use trunnion_cycles::RunKind;

/// For each reading in turn the pose that it is given to.
pub(super) struct Order {
    pub words: String,
    pub poses: Vec<usize>,
}

/// All but the order of the table, each once, the simpler ones first.
pub(super) fn orders(experiment: &Experiment) -> Vec<Order> {
    let points = &experiment.points;
    let count = points.len();
    let rows: Vec<usize> = (0..count).collect();
    let setup = |row: usize| points[row].state.setup;
    let mut by_setup = rows.clone();
    by_setup.sort_by_key(|&row| setup(row));
    let mut found: Vec<Order> = Vec::new();
    let mut add = |words: String, poses: Vec<usize>| {
        if poses != rows && !found.iter().any(|other| other.poses == poses) {
            found.push(Order { words, poses });
        }
    };
    let reversed = |rows: &[usize]| rows.iter().rev().copied().collect::<Vec<_>>();
    add(
        "the readings in reversed order (the readings or the positions were turned round)".into(),
        reversed(&rows),
    );
    let of_setups = rows.chunk_by(|&a, &b| setup(a) == setup(b)).flat_map(reversed).collect();
    add(
        "the readings of each setup in reversed order (the readings or the positions were turned round)"
            .into(),
        of_setups,
    );
    // On the fly no two rows stand at the same place, and all are one pass.
    if experiment.kinds != [RunKind::Static] {
        return found;
    }
    let poses = Poses::of(experiment);
    for keys in poses.keys() {
        let sorted = |rows: &[usize]| {
            let mut sorted = rows.to_vec();
            sorted.sort_by(|&a, &b| poses.compare(&keys, a, b));
            sorted
        };
        let words = format!("the readings given to the poses in the order {} {SORTED}", words(&keys));
        add(words.clone(), by_setup.chunk_by(|&a, &b| setup(a) == setup(b)).flat_map(sorted).collect());
        add(words, sorted(&rows));
        for (back, how) in [(1.0, ""), (-1.0, ", every second pass backwards")] {
            for serpentine in [false, true] {
                let pass = |row: usize| (setup(row), poses.visit[row]);
                let mut planned = rows.clone();
                planned.sort_by(|&a, &b| {
                    let way = if poses.visit[a] % 2 == 1 { back } else { 1.0 };
                    let within = || match way < 0.0 {
                        true => poses.in_turn(&keys, serpentine, b, a),
                        false => poses.in_turn(&keys, serpentine, a, b),
                    };
                    pass(a).cmp(&pass(b)).then_with(within)
                });
                let turns = if serpentine { ", there and back" } else { "" };
                add(
                    format!(
                        "the readings given to the poses in passes {}{turns}{how} {SORTED}",
                        self::words(&keys)
                    ),
                    planned,
                );
            }
        }
    }
    found
}

const SORTED: &str = "(positions sorted without their readings, or readings without their positions)";

/// An axis by which poses are sorted, rising (+1) or falling (−1); the outer one first.
type Key = (Joint, f64);

fn words(keys: &[Key]) -> String {
    let one = |(joint, sign): &Key| format!("{joint} {}", if *sign < 0.0 { "falling" } else { "rising" });
    let words: Vec<String> = keys.iter().map(one).collect();
    words.join(", within it ")
}

/// Where each row stands.
struct Poses {
    /// Axes that make the poses.
    axes: Vec<Joint>,
    /// Axes that follow.
    others: Vec<Joint>,
    /// The stand of each axis by row, counted from the lowest.
    level: AxisValues<Vec<usize>>,
    /// How often the pose was there before, in the rows of its setup.
    visit: Vec<usize>,
}

impl Poses {
    fn of(experiment: &Experiment) -> Self {
        let points = &experiment.points;
        let positions: Vec<&AxisValues<f64>> = points.iter().map(|point| &point.state.position).collect();
        let axes = moving_axes(experiment);
        let joints = experiment.machine().joints();
        let others =
            joints.into_iter().filter(|joint| !axes.contains(joint) && experiment.scene.moves(*joint));
        let others: Vec<Joint> = others.collect();
        let mut level = AxisValues::from_fn(|_| Vec::new());
        for &joint in axes.iter().chain(&others) {
            level[joint] = levels(&stood(&positions, joint));
        }
        let pose = number((0..points.len()).map(|row| {
            let stands: Vec<usize> = axes.iter().map(|&joint| level[joint][row]).collect();
            (points[row].state.setup, stands)
        }));
        let mut times = vec![0; points.len()];
        let visit = pose.into_iter().map(|pose| {
            times[pose] += 1;
            times[pose] - 1
        });
        Self { axes, others, level, visit: visit.collect() }
    }

    /// Every axis alone, and every two that make the poses, rising and falling.
    fn keys(&self) -> Vec<Vec<Key>> {
        let mut all: Vec<Vec<Key>> = Vec::new();
        for &joint in self.axes.iter().chain(&self.others) {
            all.extend([1.0, -1.0].map(|sign| vec![(joint, sign)]));
        }
        for &outer in &self.axes {
            let inner = self.axes.iter().filter(|&&inner| inner != outer);
            let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
            all.extend(inner.flat_map(|&inner| signs.map(|(o, i)| vec![(outer, o), (inner, i)])));
        }
        all
    }

    fn compare(&self, keys: &[Key], a: usize, b: usize) -> Ordering {
        let of_key = |&(joint, sign): &Key| {
            let order = self.level[joint][a].cmp(&self.level[joint][b]);
            if sign < 0.0 { order.reverse() } else { order }
        };
        keys.iter().map(of_key).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
    }

    /// The same; `serpentine`: the inner axis goes the other way at every second stand of the outer one.
    fn in_turn(&self, keys: &[Key], serpentine: bool, a: usize, b: usize) -> Ordering {
        let [outer, (inner, sign)] = keys else { return self.compare(keys, a, b) };
        let turned = serpentine && self.level[outer.0][a] % 2 == 1;
        let sign = if turned { -sign } else { *sign };
        self.compare(&[*outer, (*inner, sign)], a, b)
    }
}

/// Each value as how many different ones are smaller.
fn levels(values: &[f64]) -> Vec<usize> {
    let mut different = values.to_vec();
    different.sort_by(f64::total_cmp);
    different.dedup();
    values.iter().map(|value| different.partition_point(|other| other < value)).collect()
}
