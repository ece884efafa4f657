//! NIST StRD linear regression.

use super::document::{data, fewest, numbers};
use nalgebra::{DMatrix, DVector};
use serde_json::Value;
use trunnion_engine::solve::linear::least_squares;

/// Digits on one set.
pub struct Row {
    pub set: &'static str,
    pub digits: f64,
    pub u_digits: f64,
    /// What the test asserts of the coefficients.
    pub least: f64,
}

/// Sets and the digits asserted of their coefficients.
const SETS: [(&str, f64); 10] = [
    ("Norris", 12.0),
    ("Pontius", 12.0),
    ("NoInt1", 13.0),
    ("Longley", 10.0),
    ("Filip", 7.5),
    ("Wampler1", 10.0),
    ("Wampler2", 10.0),
    ("Wampler3", 10.0),
    ("Wampler4", 10.0),
    ("Wampler5", 10.0),
];

pub fn rows() -> Vec<Row> {
    let sets = data("nist_strd_linear.json");
    SETS.into_iter().map(|(set, least)| row(set, &sets[set], least)).collect()
}

fn row(set: &'static str, data: &Value, least: f64) -> Row {
    let y = DVector::from_vec(numbers(&data["y"]));
    let fit = least_squares(&design(data), &y, 1e-14);
    Row {
        set,
        digits: fewest(fit.x.as_slice(), &numbers(&data["b"])),
        u_digits: fewest(fit.u.as_slice(), &numbers(&data["se"])),
        least,
    }
}

fn design(data: &Value) -> DMatrix<f64> {
    if data["kind"] == "poly" {
        let x = numbers(&data["x"]);
        let degree = data["deg"].as_u64().expect("a degree") as usize;
        return DMatrix::from_fn(x.len(), degree + 1, |i, j| x[i].powf(j as f64));
    }
    let row = |row: &Value| if row.is_array() { numbers(row) } else { vec![row.as_f64().expect("a number")] };
    let rows: Vec<Vec<f64>> = data["X"].as_array().expect("rows").iter().map(row).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}
