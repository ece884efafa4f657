//! What else reads as an error of the list: causes of the catalogue whose columns the list takes up, wholly or in part.
//!
//! c the column of one unit of a cause at the readings of a trace, A the columns of the list with its centring, l what the list leaves:
//!     m = A⁺ c  is how far one unit moves each error of the list;  r = c − A m  is what shows that the cause is there.
//!     Amount next to the list: a = rᵀ l / rᵀ r; with the cause, an error of the list is x − a m.
//! Wholly confounded: r = 0. Two causes with parallel r are not separated from each other, so both together may move an error and leave nothing.
//! Significant: exp(−t²/2) < 5 %/N for t = |a|/u(a) and N causes (the two tails of a normal distribution are below exp(−t²/2); Bonferroni).
//! An error of the list then is uncertain by a m, since the readings do not say which of both it is.
//! A straightness belongs to a range, and so does the squareness next to it: over the circle for u, over the travel of the machine file for
//! how far the squareness of the whole machine may be from that of the circle, if the guide goes on as it does there.
//! Limits: causes of the two axes that move, one by one; causes with shape numbers (periods, time constants) and descriptions are not tried.

use super::list::ListedKind;
use super::solved::{CENTRING, TOLERANCE, widened};
use super::trace::Trace;
use crate::common::rounding::without;
use crate::common::significance::is_significant;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use trunnion_core::Joint;
use trunnion_core::statistics::COVERAGE_95;
use trunnion_effects::{Instance, Role, Subject, Unit};
use trunnion_engine::Experiment;
use trunnion_engine::solve::linear::least_squares;

/// Share of a column that is rounding: below the tolerance of the fit of the list.
const ROUNDING: f64 = 1e-6;
/// Share of a column that the list must leave for its amount to be determined. What the list and a cause share is the same to this: positions with
/// three decimals, speeds from neighbouring rows and a centre off by a millimetre leave up to 0.002 of causes that the list takes up, and 0.07 or more
/// is left of those that it does not (circles of 150 mm, a row every 0.3°). Less would make an amount of a hundred times what the list's own errors are
/// uncertain by, out of noise.
const SHOWN: f64 = 1e-2;

/// A cause that is not on the list.
pub(super) struct Other {
    /// Its parameter, e.g. `EYX.P3`.
    pub name: String,
    /// The cause, e.g. `straightness:X`.
    pub id: String,
    pub unit: Unit,
    /// m: of each column of the fit, for one unit.
    pub moves: DVector<f64>,
    /// What shows it; `None` when it is wholly confounded.
    pub seen: Option<Seen>,
}

/// A cause that the residual shows in part.
pub(super) struct Seen {
    /// a and u(a), inside units.
    pub amount: f64,
    pub u: f64,
    pub significant: bool,
    /// How far it moves each column of the fit at most (95 %), where the same shape goes on over the whole travel.
    pub most_over_travel: DVector<f64>,
    /// r over its length.
    along: DVector<f64>,
    /// Its length for one unit.
    length: f64,
}

/// Causes that together move an error and leave nothing that shows them.
pub(super) struct Together {
    pub names: Vec<String>,
    /// Which columns of the fit they move.
    pub moved: Vec<bool>,
}

impl Other {
    /// By how far it moves a part of the fit; zero when it is not significant.
    pub fn moved(&self, columns: &Range<usize>) -> f64 {
        (self.amount() * part(&self.moves, columns)).abs()
    }

    /// What an error of the list is with the cause, x − a m, where x is its part of the fit; x itself when the cause is not significant.
    pub fn value_with(&self, x: &DVector<f64>, columns: &Range<usize>) -> f64 {
        one_number(&(x - self.moves.rows_range(columns.clone()) * self.amount()))
    }

    /// a; zero when it is not significant.
    fn amount(&self) -> f64 {
        self.seen.as_ref().filter(|seen| seen.significant).map_or(0.0, |seen| seen.amount)
    }

    /// By how far it may move a part of the fit (95 %), within the circle and over the whole travel; `None` when nothing bounds it.
    pub fn at_most(&self, columns: &Range<usize>) -> Option<[f64; 2]> {
        let seen = self.seen.as_ref()?;
        let within = part(&self.moves, columns).abs() * (seen.amount.abs() + COVERAGE_95 * seen.u);
        Some([within, part(&seen.most_over_travel, columns).abs()])
    }

    /// True when both leave the same, so that the readings do not separate them.
    pub fn leaves_the_same_as(&self, other: &Self) -> bool {
        self.seen.as_ref().zip(other.seen.as_ref()).is_some_and(|(one, two)| one.leaves_the_same_as(two))
    }

    /// `EYX.P3 (straightness:X)`.
    pub fn words(&self) -> String {
        format!("{} ({})", self.name, self.id)
    }
}

impl Seen {
    fn leaves_the_same_as(&self, other: &Self) -> bool {
        1.0 - self.along.dot(&other.along).abs() < ROUNDING
    }
}

/// Some columns of the fit as one number.
fn part(of: &DVector<f64>, columns: &Range<usize>) -> f64 {
    one_number(&of.rows_range(columns.clone()).into_owned())
}

/// The number itself, or the length of several.
pub(super) fn one_number(of: &DVector<f64>) -> f64 {
    if of.len() == 1 { of[0] } else { of.norm() }
}

/// Every cause of the two axes in the catalogue that moves an error of the list `kinds`, whose columns with the centring are `design`.
/// `within`: the readings of the trace.
pub(super) fn others(
    within: &Experiment,
    trace: &Trace,
    kinds: &[ListedKind],
    design: &DMatrix<f64>,
    left: &DVector<f64>,
) -> Vec<Other> {
    let mut over_travel = within.clone();
    for joint in Joint::LINEAR {
        if let Some(axis) = trace.run.machine.axis(joint) {
            over_travel.scene.position_range[joint] = axis.travel;
        }
    }
    let machine = &trace.run.machine;
    let is_tried = |cause: &Instance| {
        let Subject::Axis(joint) = cause.subject() else { return false };
        let id = cause.id();
        let phenomenon = id.split(':').next().unwrap_or_default();
        let is_listed = |kind: &ListedKind| kind.is_wholly(phenomenon, joint, trace.plane);
        matches!(cause.role(), Role::Cause { .. })
            && trace.plane.contains(&joint)
            && !kinds.iter().any(is_listed)
            && cause.out_of_reach(&within.scene).is_none()
            && cause.shapes(&within.scene).names.is_empty()
    };
    let mut found = Vec::new();
    for cause in Instance::all(machine).into_iter().filter(is_tried) {
        let parameters = cause.parameters(&within.scene);
        let [columns, far] = [within, &over_travel].map(|of| of.columns(&cause, &[]));
        let id = cause.id();
        let is_own = kinds.iter().any(|kind| kind.phenomenon() == id.split(':').next());
        for (k, parameter) in parameters.into_iter().enumerate() {
            let column = columns.column(k).into_owned();
            let Some((moves, shown)) = split(design, &column) else { continue };
            let seen = shown.map(|shown| {
                let (amount, u) = amount(&shown, left);
                let most_over_travel = match split(design, &far.column(k).into_owned()) {
                    Some((moves, Some(shown))) => {
                        let (amount, u) = self::amount(&shown, left);
                        moves * (amount.abs() + COVERAGE_95 * u)
                    }
                    _ => &moves * (amount.abs() + COVERAGE_95 * u),
                };
                let length = shown.norm();
                Seen { amount, u, significant: false, most_over_travel, along: shown / length, length }
            });
            if seen.is_some() || !is_own {
                found.push(Other { name: parameter.name, id: id.clone(), unit: parameter.unit, moves, seen });
            }
        }
    }
    let count = found.iter().filter(|other| other.seen.is_some()).count();
    for seen in found.iter_mut().filter_map(|other| other.seen.as_mut()) {
        seen.significant = is_significant(seen.amount, seen.u, count);
    }
    found
}

/// m and r of a column; r is `None` where it is rounding. `None` for one that the centring takes up, or that is nothing.
fn split(design: &DMatrix<f64>, column: &DVector<f64>) -> Option<(DVector<f64>, Option<DVector<f64>>)> {
    let centring = design.columns(0, CENTRING).into_owned();
    let beyond = column - &centring * least_squares(&centring, column, TOLERANCE).x;
    if beyond.norm() <= ROUNDING * column.norm() {
        return None;
    }
    let mut moves = least_squares(design, column, TOLERANCE).x;
    // What the column shares with an error of the list to rounding is nothing: even and odd shapes, for example.
    for (moved, of_list) in moves.iter_mut().zip(design.column_iter()) {
        *moved = without(*moved, ROUNDING * column.amax() / of_list.amax());
    }
    let shown = column - design * &moves;
    let is_shown = shown.norm() > SHOWN * beyond.norm();
    Some((moves, is_shown.then_some(shown)))
}

/// a and u(a) of a column next to the list; `None` where the list takes it up.
pub(super) fn amount_next_to(
    design: &DMatrix<f64>,
    column: &DVector<f64>,
    left: &DVector<f64>,
) -> Option<(f64, f64)> {
    let (_, shown) = split(design, column)?;
    Some(amount(&shown?, left))
}

/// a and u(a): u by what is left with the cause, widened by its correlation.
fn amount(shown: &DVector<f64>, left: &DVector<f64>) -> (f64, f64) {
    let square = shown.norm_squared();
    let amount = shown.dot(left) / square;
    let after = left - shown * amount;
    let sigma = after.norm() / (after.len() as f64).sqrt();
    (amount, widened(&after) * sigma / square.sqrt())
}

/// Causes with parallel r that together move an error of the list: by more than rounding of the part that shows each.
pub(super) fn confounded_together(others: &[Other], design: &DMatrix<f64>) -> Vec<Together> {
    let mut groups: Vec<Vec<(&Other, &Seen)>> = Vec::new();
    for (other, seen) in others.iter().filter_map(|other| Some((other, other.seen.as_ref()?))) {
        let parallel = |group: &&mut Vec<(&Other, &Seen)>| group[0].1.leaves_the_same_as(seen);
        match groups.iter_mut().find(parallel) {
            Some(group) => group.push((other, seen)),
            None => groups.push(vec![(other, seen)]),
        }
    }
    let of_group = |group: Vec<(&Other, &Seen)>| {
        let (first, first_seen) = *group.first()?;
        // What a unit of r needs of each cause, and by how far that moves the list: alike for all, or both together move it.
        let per_length = |other: &Other, seen: &Seen| {
            &other.moves * (first_seen.along.dot(&seen.along).signum() / seen.length)
        };
        let of_first = per_length(first, first_seen);
        let apart: Vec<_> = group.iter().map(|(other, seen)| per_length(other, seen) - &of_first).collect();
        let moved = design
            .column_iter()
            .enumerate()
            .map(|(k, column)| apart.iter().any(|apart| apart[k].abs() * column.norm() > ROUNDING.sqrt()));
        let moved: Vec<bool> = moved.collect();
        let names = group.iter().map(|(other, _)| other.words()).collect();
        (group.len() > 1 && moved.contains(&true)).then_some(Together { names, moved })
    };
    groups.into_iter().filter_map(of_group).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_two_columns_is_a_length_after_the_cause_is_taken_off() {
        let along = DVector::from_element(4, 0.5);
        let seen = Seen {
            amount: 3.0,
            u: 0.1,
            significant: true,
            most_over_travel: DVector::zeros(4),
            along,
            length: 1.0,
        };
        let moves = DVector::from_vec(vec![0.0, -2.0, 1.0, 0.0]);
        let cause =
            Other { name: "EXX.P1".into(), id: "some:X".into(), unit: Unit::UM, moves, seen: Some(seen) };
        // A wave of (3, 4) less 3 times (1, 0) is one of (0, 4).
        assert_eq!(cause.value_with(&DVector::from_vec(vec![3.0, 4.0]), &(2..4)), 4.0);
        // One number keeps its sign.
        assert_eq!(cause.value_with(&DVector::from_vec(vec![-7.0]), &(1..2)), -1.0);
        assert_eq!(cause.moved(&(1..2)), 6.0);
    }
}
