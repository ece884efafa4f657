//! The rows from which noise is learned and which a scan looks at: readings as they are, or means of neighbours where there are many.
//!
//! Their matrices have a row for each reading, so their number is bounded. Points on the fly, and others that lie close together, are averaged with
//! their neighbours of the same pass; points far apart are thinned, and so are passes of a few points each. A mean hides what repeats within it:
//! the answer judges the size of the residual on all points.

use crate::Experiment;
use crate::problem::sequence::in_order_taken;
use crate::problem::taken::Taken;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use trunnion_core::statistics::upper_median;
use trunnion_cycles::RunKind;

/// Readings that are looked at: a covariance of that size takes some 30 ms to invert.
const MOST_ROWS: usize = 1200;
/// Neighbours closer than this in every rotary axis may be averaged, rad.
const CLOSE_RAD: f64 = 0.09;
/// Turns of the golden ratio spread evenly and never beat with a grid: the first pose of every pass would be the only one that is looked at.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Points that stand for all.
pub struct Rows<'a> {
    /// One point for each group: the middle one.
    pub points: Cow<'a, Experiment>,
    /// Points of the whole experiment that each stands for; `None` where each stands for itself.
    groups: Option<Vec<Group>>,
    /// Of the whole experiment.
    all: &'a Experiment,
}

/// Neighbours that one row stands for.
struct Group {
    averaged: Vec<usize>,
    /// Left out around it: they are far apart.
    thinned: Vec<usize>,
}

impl Group {
    fn of(point: usize) -> Self {
        Self { averaged: vec![point], thinned: Vec::new() }
    }

    /// The point that stands for it.
    fn middle(&self) -> usize {
        self.averaged[self.averaged.len() / 2]
    }
}

impl<'a> Rows<'a> {
    pub fn new(all: &'a Experiment) -> Self {
        let step = all.rows().div_ceil(MOST_ROWS);
        if step < 2 {
            return Self { points: Cow::Borrowed(all), groups: None, all };
        }
        let stretches = stretches(all, step).into_iter().enumerate();
        let mut groups = few(all, stretches.map(|(k, near)| one_of(near, k)).collect());
        groups.sort_by_key(Group::middle);
        let mut keep = vec![false; all.points.len()];
        groups.iter().for_each(|group| keep[group.middle()] = true);
        Self { points: Cow::Owned(all.kept(&keep)), groups: Some(groups), all }
    }

    /// All points.
    pub fn whole(&self) -> &'a Experiment {
        self.all
    }

    /// How many readings are averaged in a row, the median: of the samples of a block on the fly, and of neighbours. The readings of a point
    /// at rest are one: what moves it as a whole is not averaged by reading longer.
    pub fn readings_of_one(&self) -> f64 {
        let of_point = |point: usize| match self.all.kinds[self.all.run_of_point[point]] {
            RunKind::OnTheFly => f64::from(self.all.points[point].samples.max(1)),
            RunKind::Static => 1.0,
        };
        let of_node = |node: usize| self.points_of(node).into_iter().map(of_point).sum::<f64>();
        upper_median(&(0..self.points.points.len()).map(of_node).collect::<Vec<f64>>())
            .unwrap_or(0.0)
            .max(1.0)
    }

    /// The points of each row group.
    pub fn points_of(&self, node: usize) -> Vec<usize> {
        self.groups.as_ref().map_or_else(|| vec![node], |groups| groups[node].averaged.clone())
    }

    /// The row group that is nearest to each point in the order taken.
    pub fn node_of_points(&self) -> Vec<usize> {
        let mut node_of_point: Vec<usize> = (0..self.all.points.len()).collect();
        for (node, group) in self.groups.iter().flatten().enumerate() {
            group.averaged.iter().chain(&group.thinned).for_each(|&point| node_of_point[point] = node);
        }
        node_of_point
    }

    /// Columns (rows of all readings × columns) on these rows.
    pub fn of(&self, columns: DMatrix<f64>) -> DMatrix<f64> {
        let Some(groups) = &self.groups else { return columns };
        let mut reduced = DMatrix::zeros(self.points.rows(), columns.ncols());
        for (node, group) in groups.iter().enumerate() {
            let share = 1.0 / group.averaged.len() as f64;
            for &point in &group.averaged {
                for (to, from) in self.points.rows_of(node).zip(self.all.rows_of(point)) {
                    for j in 0..columns.ncols() {
                        reduced[(to, j)] += share * columns[(from, j)];
                    }
                }
            }
        }
        reduced
    }

    /// The same of one column.
    pub fn of_vector(&self, column: DVector<f64>) -> DVector<f64> {
        let rows = column.len();
        DVector::from_column_slice(self.of(DMatrix::from_column_slice(rows, 1, column.as_slice())).as_slice())
    }
}

/// Stretches of up to `step` neighbours of one pass, each with those of them that read alike together.
fn stretches(all: &Experiment, step: usize) -> Vec<Vec<Group>> {
    let taken = Taken::new(all);
    let sequence = in_order_taken(all);
    let close = |i: usize, j: usize| {
        let position = |i: usize| &all.points[i].state.position;
        let letters = all.machine().rotary();
        letters.iter().all(|axis| (position(i)[axis.letter] - position(j)[axis.letter]).abs() < CLOSE_RAD)
    };
    let mut stretches: Vec<Vec<Group>> = Vec::new();
    let mut since = 0;
    for (k, &i) in sequence.iter().enumerate() {
        let same = |j: usize| taken.pass[i] == taken.pass[j] && all.rows_of(i).len() == all.rows_of(j).len();
        let neighbour = k > 0 && same(sequence[k - 1]);
        since = if neighbour && since + 1 < step { since + 1 } else { 0 };
        match stretches.last_mut() {
            Some(stretch) if since > 0 => match stretch.last_mut() {
                Some(group) if close(i, sequence[k - 1]) => group.averaged.push(i),
                _ => stretch.push(Group::of(i)),
            },
            _ => stretches.push(vec![Group::of(i)]),
        }
    }
    stretches
}

/// One of neighbours, which stands for all of them; `k`: number of the stretch.
fn one_of(mut near: Vec<Group>, k: usize) -> Group {
    let turn = (k as f64 * GOLDEN).fract();
    let mut one = near.swap_remove((turn * near.len() as f64) as usize);
    for other in near {
        one.thinned.extend(other.averaged.into_iter().chain(other.thinned));
    }
    one
}

/// The same, thinned until they have no more than [`MOST_ROWS`] rows: where passes are shorter than a stretch, there is one for each pass.
fn few(all: &Experiment, groups: Vec<Group>) -> Vec<Group> {
    let rows: usize = groups.iter().map(|group| all.rows_of(group.middle()).len()).sum();
    if rows <= MOST_ROWS {
        return groups;
    }
    let (count, keep) = (groups.len(), groups.len() * MOST_ROWS / rows);
    let mut groups = groups.into_iter();
    let near = |k: usize| groups.by_ref().take((k + 1) * count / keep - k * count / keep).collect();
    (0..keep).map(near).enumerate().map(|(k, near)| one_of(near, k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use trunnion_core::{InstrumentKind, Joint, NestSide, Point, Quality, Setup, State};
    use trunnion_cycles::Run;
    use trunnion_machine::shipped;

    /// Three poses round after round, as when a long run becomes means of some of its rounds: every pass is three points long.
    #[test]
    fn passes_of_a_few_points_have_no_more_rows_than_long_ones() {
        let point = |k: u32| {
            let mut state = State { time_s: Some(f64::from(k)), ..State::default() };
            state.position[Joint::C] = f64::from(k % 3).to_radians() * 30.0;
            Point { state, reading_mm: [0.0; 3], spread_mm: [0.0; 3], samples: 0, quality: Quality::Good }
        };
        let ball = Point3::new(150.0, 0.0, 60.0);
        let run = Run {
            name: "rounds".into(),
            machine: shipped::machine("table-bc").unwrap(),
            kind: RunKind::Static,
            setups: vec![Setup::new("ball", InstrumentKind::RTest, NestSide::Table, ball)],
            channels: Vec::new(),
            points: (0..3000).map(point).collect(),
        };
        let experiment = Experiment::new(&[run]).unwrap();
        let rows = Rows::new(&experiment);
        let kept = &rows.points.points;
        assert!((MOST_ROWS / 2..=MOST_ROWS).contains(&rows.points.rows()), "{}", rows.points.rows());
        for c in 0..3 {
            let at = (f64::from(c) * 30.0).to_radians();
            let here = kept.iter().filter(|point| (point.state.position[Joint::C] - at).abs() < 1e-9).count();
            assert!(4 * here > kept.len(), "pose {c}: {here} of {}", kept.len());
        }
        let nodes = rows.node_of_points();
        assert!(nodes.len() == 3000 && nodes.iter().all(|node| *node < kept.len()));
    }
}
