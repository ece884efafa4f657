//! The certification table: its floors, and that docs/measured/certification.md is what the program writes.

#[path = "../../examples/certify/document.rs"]
mod document;
#[path = "../../examples/certify/experiment.rs"]
mod experiment;
#[path = "../../examples/certify/guides.rs"]
mod guides;
#[path = "../../examples/certify/monte_carlo.rs"]
mod monte_carlo;
#[path = "../../examples/certify/pairs.rs"]
mod pairs;
#[path = "../../examples/certify/shapes.rs"]
mod shapes;
#[path = "../../examples/certify/strd.rs"]
mod strd;

use nalgebra::{DMatrix, DVector};
use trunnion_engine::solve::linear::least_squares;

const TRIALS: usize = 2_000;

#[test]
fn certified_coefficients_are_met() {
    for row in strd::rows() {
        assert!(row.digits >= row.least, "{}: {} digits", row.set, row.digits);
        let least_u = if row.set == "Filip" { 6.5 } else { 11.0 };
        assert!(row.u_digits >= least_u, "{}: {} digits of the standard deviations", row.set, row.u_digits);
    }
}

#[test]
fn the_guides_examples_are_met_to_their_last_printed_digit() {
    for row in guides::rows() {
        let (printed, found): (f64, f64) = (row.printed.parse().unwrap(), row.found.parse().unwrap());
        let last = 10f64.powi(-(row.printed.split('.').nth(1).map_or(0, str::len) as i32));
        assert!(
            (printed - found).abs() < 0.51 * last,
            "{}: {} against {}",
            row.figure,
            row.found,
            row.printed
        );
    }
}

#[test]
fn chosen_solutions_come_back() {
    for row in pairs::rows() {
        let least = if row.pair.contains("identify") { 10.0 } else { 13.0 };
        assert!(row.digits >= least, "{}: {} digits", row.pair, row.digits);
    }
}

#[test]
fn geometric_elements_meet_their_references() {
    for row in shapes::rows() {
        let least = if row.element.contains("arc") { 8.5 } else { 12.0 };
        assert!(row.position >= least && row.form >= least, "{}: {} {}", row.element, row.position, row.form);
    }
}

/// The standard deviation over 2000 trials has a relative standard uncertainty of 1/√(2·2000) = 0.016, the share held one
/// of √(0.95·0.05/2000) = 0.0049; the largest of some thirty of them is allowed four.
#[test]
fn monte_carlo_agrees_with_linear_propagation() {
    let outcome = monte_carlo::run(TRIALS);
    println!("{}", outcome.to_markdown());
    assert!(outcome.rows.len() >= 25, "{} parameters", outcome.rows.len());
    assert!(outcome.worst_ratio() < 4.0 * 0.016, "{}", outcome.worst_ratio());
    for row in &outcome.rows {
        assert!((row.held_known - 0.95).abs() < 4.0 * 0.0049, "{}: {}", row.parameter, row.held_known);
        assert!(row.held_clusters > 0.95 - 4.0 * 0.0049, "{}: {}", row.parameter, row.held_clusters);
        assert!(row.bias.abs() < 4.0 / (TRIALS as f64).sqrt(), "{}: {}", row.parameter, row.bias);
    }
    assert!((outcome.mean(|row| row.held_known) - 0.95).abs() < 0.005);
}

/// Text equal word by word, numbers to 0.6 of a digit or 2 %: processors differ in the last digits.
fn same(document: &str, fresh: &str) -> Result<(), String> {
    if document.lines().count() != fresh.lines().count() {
        return Err("another number of lines".into());
    }
    for (a, b) in document.lines().zip(fresh.lines()) {
        let same = a.split_whitespace().count() == b.split_whitespace().count()
            && a.split_whitespace().zip(b.split_whitespace()).all(|(a, b)| {
                match (a.parse::<f64>(), b.parse::<f64>()) {
                    (Ok(a), Ok(b)) => (a - b).abs() <= 0.6f64.max(0.02 * a.abs()),
                    _ => a == b,
                }
            });
        if !same {
            return Err(format!("documented: {a}\nfound:      {b}"));
        }
    }
    Ok(())
}

#[test]
fn the_certification_document_is_current() {
    const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/measured/certification.md");
    let document = std::fs::read_to_string(FILE).unwrap_or_default();
    let fresh = document::document(20);
    let before = |text: &str| text.split(document::MONTE_CARLO).next().unwrap_or_default().to_string();
    if let Err(why) = same(&before(&document), &before(&fresh)) {
        panic!(
            "docs/measured/certification.md is not current: cargo run --release -p trunnion-methods --example certify\n{why}"
        );
    }
    let parameters = |text: &str| -> Vec<String> {
        let rows = text.split(document::MONTE_CARLO).nth(1).unwrap_or_default();
        rows.lines()
            .filter(|line| line.contains(" · "))
            .map(|line| line.split('|').nth(1).unwrap().to_string())
            .collect()
    };
    assert_eq!(parameters(&document), parameters(&fresh), "the Monte Carlo table is of another model");
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
    assert_eq!(fit.cofactor.row(2).amax(), 0.0);
}
