//! Combinations of machine errors that the data determine although none of them alone gets a number, e.g. the sum of the
//! three scales along a body diagonal (S2 §3.2).
//!
//! c·x is determined when c is square to every null direction. Of the errors without numbers S, all such c are the null space
//! of N_S, the null directions restricted to S; brought to echelon form they name few errors each.
//! Limits: at most [`MOST`] errors without numbers; settings of instruments do not take part.

use crate::solve::direction::Named;
use crate::solve::echelon::{Preferred, Row, echelon};
use crate::solve::null_space::Direction;
use crate::solve::words::in_words;
use nalgebra::{DMatrix, DVector, RowDVector};
use serde::{Deserialize, Serialize};
use trunnion_effects::{FixedText, fixed_text};

/// Beyond this many the combinations would be of no use to a person.
const MOST: usize = 24;
const TAKES_PART: f64 = 1e-6;
/// Relative singular value of N_S that counts as zero.
const ZERO: f64 = 1e-8;

/// A combination of parameters that the data determine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Combination {
    /// Which parameters take part.
    pub parameters: Vec<usize>,
    /// In words, e.g. `linear-scale:X.scale + linear-scale:Y.scale`.
    pub text: String,
    /// Value on the screen.
    pub value: f64,
    /// Its standard uncertainty on the screen.
    pub u: f64,
    /// Unit on the screen: that of the first parameter.
    #[serde(deserialize_with = "fixed_text")]
    pub unit: FixedText,
}

/// The combinations of the parameters `without_number`.
pub(crate) fn seen_together(
    directions: &[Direction],
    without_number: &[usize],
    names: &[Named],
    solution: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Vec<Combination> {
    if without_number.len() < 2 || without_number.len() > MOST {
        return Vec::new();
    }
    // In screen units, so that angles and lengths weigh alike.
    let rows: Vec<Vec<f64>> = directions
        .iter()
        .map(|direction| {
            let at = |j: usize| direction.terms.iter().find(|(k, _)| *k == j).map_or(0.0, |(_, c)| *c);
            without_number.iter().map(|&j| at(j) * names[j].per_inside).collect::<Vec<f64>>()
        })
        .filter(|row| row.iter().any(|c| *c != 0.0))
        .map(|row| {
            let size = row.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
            row.into_iter().map(|c| c / size).collect()
        })
        .collect();
    let null = DMatrix::from_fn(rows.len().max(without_number.len()), without_number.len(), |i, j| {
        rows.get(i).map_or(0.0, |row| row[j])
    });
    let svd = null.svd(false, true);
    let Some(v_t) = svd.v_t else { return Vec::new() };
    let largest = svd.singular_values.amax();
    let kernel: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&i| svd.singular_values[i] <= ZERO * largest).collect();
    let combination = |Row { pivot, part: row, .. }: Row| {
        let mut terms: Vec<(usize, f64)> = vec![(without_number[pivot], 1.0)];
        let others = (0..row.len()).filter(|&k| k != pivot && row[k].abs() > TAKES_PART);
        terms.extend(others.map(|k| (without_number[k], row[k])));
        let screen = |&(j, c): &(usize, f64)| c * solution[j] * names[j].per_inside;
        let weight = |&(j, c): &(usize, f64)| (j, c * names[j].per_inside);
        let weights: Vec<(usize, f64)> = terms.iter().map(weight).collect();
        let variance: f64 = weights
            .iter()
            .flat_map(|(i, a)| weights.iter().map(move |(j, b)| a * b * covariance[(*i, *j)]))
            .sum();
        let spelt: Vec<(String, f64)> = terms.iter().map(|(j, c)| (names[*j].name.clone(), *c)).collect();
        Combination {
            parameters: terms.iter().map(|(j, _)| *j).collect(),
            text: in_words(&spelt),
            value: terms.iter().map(screen).sum(),
            u: variance.max(0.0).sqrt(),
            unit: names[terms[0].0].unit,
        }
    };
    let equal = vec![1.0; without_number.len()];
    let least = |_: &RowDVector<f64>| vec![TAKES_PART; without_number.len()];
    echelon(v_t.select_rows(&kernel), &Preferred::NONE, &[], &equal, &least)
        .into_iter()
        .map(combination)
        .collect()
}
