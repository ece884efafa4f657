//! Correct digits on NIST's linear reference sets (public domain, certified to 15 digits).

mod common;

use nalgebra::{DMatrix, DVector};
use serde_json::Value;
use trunnion_identify::linear::least_squares;

fn numbers(value: &Value) -> Vec<f64> {
    let one = |x: &Value| {
        x.as_f64().unwrap_or_else(|| {
            x.as_str()
                .expect("the form of the data file")
                .replace('D', "E")
                .parse()
                .expect("the form of the data file")
        })
    };
    value.as_array().expect("the form of the data file").iter().map(one).collect()
}

/// Fewest correct digits of any coefficient, and of any standard deviation that is not zero.
fn digits(set: &Value) -> (f64, f64) {
    let y = DVector::from_vec(numbers(&set["y"]));
    let a = if set["kind"] == "poly" {
        let x = numbers(&set["x"]);
        let degree = set["deg"].as_u64().expect("the form of the data file") as usize;
        DMatrix::from_fn(x.len(), degree + 1, |i, j| x[i].powf(j as f64))
    } else {
        let rows: Vec<Vec<f64>> = set["X"]
            .as_array()
            .expect("the form of the data file")
            .iter()
            .map(|row| {
                if row.is_array() {
                    numbers(row)
                } else {
                    vec![row.as_f64().expect("the form of the data file")]
                }
            })
            .collect();
        DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    };
    let fit = least_squares(&a, &y, 1e-14);
    let fewest = |found: &DVector<f64>, certified: &[f64]| {
        certified
            .iter()
            .zip(found.iter())
            .filter(|(c, _)| **c != 0.0)
            .map(|(c, f)| -((f - c).abs() / c.abs()).max(1e-16).log10())
            .fold(16.0, f64::min)
    };
    (fewest(&fit.x, &numbers(&set["b"])), fewest(&fit.u, &numbers(&set["se"])))
}

#[test]
fn certified_coefficients_are_met() {
    let sets: Value =
        serde_json::from_str(&common::outside("nist_strd_linear.json").expect("the form of the data file"))
            .expect("the form of the data file");
    for (name, least, least_u) in [
        ("Norris", 12.0, 12.0),
        ("Pontius", 11.0, 11.0),
        ("NoInt1", 13.0, 13.0),
        ("Longley", 10.0, 10.0),
        ("Filip", 7.5, 6.5),
        ("Wampler1", 9.0, 0.0),
        ("Wampler2", 12.0, 0.0),
        ("Wampler3", 8.5, 9.0),
        ("Wampler4", 7.5, 9.0),
        ("Wampler5", 6.5, 9.0),
    ] {
        let (x, u) = digits(&sets[name]);
        println!("{name}: {x:.1} digits, standard deviations {u:.1}");
        assert!(x >= least, "{name}: {x} digits");
        assert!(u >= least_u, "{name}: {u} digits of the standard deviations");
    }
}

#[test]
fn a_dependent_column_is_left_out_instead_of_blown_up() {
    let a = DMatrix::from_fn(20, 3, |i, j| {
        let t = i as f64;
        [1.0, t, 2.0 - 3.0 * t][j]
    });
    let b = DVector::from_fn(20, |i, _| 5.0 + 0.5 * i as f64);
    let fit = least_squares(&a, &b, 1e-10);
    assert_eq!(fit.rank, 2);
    assert!((fit.x - DVector::from_vec(vec![5.0, 0.5, 0.0])).amax() < 1e-12);
}
