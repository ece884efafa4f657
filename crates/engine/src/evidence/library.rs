//! Columns that compete, stacked for one scan.

use nalgebra::DMatrix;
use std::ops::Range;

/// Root mean square below which a column is round-off of nothing.
const NOTHING: f64 = 1e-9;

/// Columns that compete: groups of alternatives (one per shape), each a few columns; groups may share columns.
#[derive(Clone, Debug)]
pub struct Library {
    /// Column × row, each of norm 1.
    pub columns: DMatrix<f64>,
    /// Groups.
    pub groups: Vec<Group>,
}

/// Small repeatable motions that every rotary axis has are nothing that is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Natural {
    /// Nothing of the kind.
    No,
    /// Looks like them in this cycle: next to a larger effect it must exceed them.
    Alike,
    /// Is one of them, and must exceed what is natural.
    Yes,
}

/// One competitor.
#[derive(Clone, Debug)]
pub struct Group {
    /// Its columns for each shape.
    pub parts: Vec<Range<usize>>,
    /// ln of its prior odds, not positive.
    pub prior_ln: f64,
    /// Whether it must exceed what is natural.
    pub natural: Natural,
}

/// A group before its columns are stacked.
pub struct Entry {
    /// Columns of each shape, rows × columns.
    pub parts: Vec<DMatrix<f64>>,
    /// See [`Group::prior_ln`].
    pub prior_ln: f64,
    /// See [`Group::natural`].
    pub natural: Natural,
}

impl Library {
    /// Stacks groups; scales each column to norm 1.
    pub fn new(rows: usize, groups: Vec<Entry>) -> Self {
        let width = groups.iter().flat_map(|entry| &entry.parts).map(DMatrix::ncols).sum();
        let mut library =
            Self { columns: DMatrix::zeros(width, rows), groups: Vec::with_capacity(groups.len()) };
        let mut next = 0;
        for Entry { parts, prior_ln, natural } in groups {
            let mut ranges = Vec::with_capacity(parts.len());
            for part in parts {
                for j in 0..part.ncols() {
                    library.put(next + j, part.column(j).iter());
                }
                ranges.push(next..next + part.ncols());
                next += part.ncols();
            }
            library.groups.push(Group { parts: ranges, prior_ln, natural });
        }
        library
    }

    /// Puts one column in its place, scaled to norm 1; one that is not finite or round-off stays zero.
    pub fn put<'a>(&mut self, place: usize, column: impl Iterator<Item = &'a f64> + Clone) {
        let norm = column.clone().map(|x| x * x).sum::<f64>().sqrt();
        let least = NOTHING * (self.columns.ncols() as f64).sqrt();
        let scale = if norm > least && norm.is_finite() { 1.0 / norm } else { 0.0 };
        for (target, value) in self.columns.row_mut(place).iter_mut().zip(column) {
            *target = if scale > 0.0 { value * scale } else { 0.0 };
        }
    }

    /// A library of some of the groups.
    pub fn subset(&self, chosen: &[usize]) -> Self {
        let part = |range: &Range<usize>| self.columns.rows(range.start, range.len()).transpose();
        let groups = chosen.iter().map(|&g| {
            let group = &self.groups[g];
            let parts = group.parts.iter().map(part).collect();
            Entry { parts, prior_ln: group.prior_ln, natural: group.natural }
        });
        Self::new(self.columns.ncols(), groups.collect())
    }

    /// Columns of every part, in the order of the groups.
    pub fn parts(&self) -> impl Iterator<Item = &Range<usize>> {
        self.groups.iter().flat_map(|group| &group.parts)
    }

    /// Columns of one part, rows × columns.
    pub fn part(&self, group: usize, part: usize) -> DMatrix<f64> {
        let range = &self.groups[group].parts[part];
        self.columns.rows(range.start, range.len()).transpose()
    }
}
