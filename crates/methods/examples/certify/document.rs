//! The certification document, from its parts.

use super::{guides, monte_carlo, pairs, shapes, strd};
use std::fmt::Write;
use std::path::PathBuf;

/// Heading of the part that depends on the number of trials.
pub const MONTE_CARLO: &str = "## Uncertainty by Monte Carlo";

/// A file of tests/data.
pub fn data(name: &str) -> serde_json::Value {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(name);
    let text = std::fs::read_to_string(&file).unwrap_or_else(|why| panic!("{}: {why}", file.display()));
    serde_json::from_str(&text).unwrap_or_else(|why| panic!("{}: {why}", file.display()))
}

/// Numbers of a JSON array; strings (with D or E) are numbers too.
pub fn numbers(value: &serde_json::Value) -> Vec<f64> {
    let one = |x: &serde_json::Value| match x.as_str() {
        Some(text) => text.replace('D', "E").parse().expect("a number"),
        None => x.as_f64().expect("a number"),
    };
    value.as_array().expect("an array").iter().map(one).collect()
}

/// Correct digits of `found`: −log₁₀ of its relative error (of the error itself where the certified value is zero), at most 16.
pub fn digits(found: f64, certified: f64) -> f64 {
    let scale = if certified == 0.0 { 1.0 } else { certified.abs() };
    -((found - certified).abs() / scale).max(1e-16).log10()
}

/// Fewest correct digits of a list.
pub fn fewest(found: &[f64], certified: &[f64]) -> f64 {
    assert_eq!(found.len(), certified.len());
    found.iter().zip(certified).map(|(f, c)| digits(*f, *c)).fold(16.0, f64::min)
}

/// docs/measured/certification.md.
pub fn document(trials: usize) -> String {
    let mut text = String::from(
        "# Certification of the arithmetic\n\n\
         Written by `cargo run --release -p trunnion-methods --example certify`; a test compares it. Correct digits are\n\
         −log₁₀ of the relative error, at most 16; processors differ in the last of them.\n\n\
         ## NIST StRD, linear regression\n\n\
         Ten reference sets certified to 15 digits; `linear::least_squares` (QR of columns scaled by powers of two, refined with\n\
         residuals in doubled precision). Columns of powers are formed in double precision, which alone limits Filip to 7.6.\n\n\
         | set | coefficients, fewest digits | standard deviations | asserted at least |\n|---|---|---|---|\n",
    );
    let mut line = |row: String| writeln!(text, "{row}").expect("strings take all");
    for row in strd::rows() {
        line(format!("| {} | {:.1} | {:.1} | {:.1} |", row.set, row.digits, row.u_digits, row.least));
    }
    line("\n## Guides and standards\n\n| figure | printed | found |\n|---|---|---|".into());
    for row in guides::rows() {
        line(format!("| {} | {} | {} |", row.figure, row.printed, row.found));
    }
    line(
        "\n## Null-space pairs of the program's own model\n\n\
         A solution b₀ is chosen, a residual made orthogonal to the columns in doubled precision, and the fit must give b₀ back\n\
         (Cook, Cox, Dainton, Harris, NPL 1999). Relative to the largest parameter.\n\n\
         | pair | rows × columns | rms of the residual | digits |\n|---|---|---|---|"
            .into(),
    );
    for row in pairs::rows() {
        line(format!("| {} | {} × {} | {} | {:.1} |", row.pair, row.rows, row.columns, row.rms, row.digits));
    }
    line(
        "\n## Geometric elements\n\n\
         References in 60-digit arithmetic; the first circle and the first line are published problems \
         (tests/data/PROVENANCE.md).\n\n\
         | element | position, digits | direction or radius, digits |\n|---|---|---|"
            .into(),
    );
    for row in shapes::rows() {
        line(format!("| {} | {:.1} | {:.1} |", row.element, row.position, row.form));
    }
    text + "\n" + &monte_carlo::run(trials).to_markdown()
}
