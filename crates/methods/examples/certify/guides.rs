//! Worked examples of metrology's guides: GUM H.3 and ISO/TS 28037.

use nalgebra::{DMatrix, DVector};
use trunnion_engine::solve::linear::least_squares;

/// One printed figure.
pub struct Row {
    pub figure: &'static str,
    pub printed: &'static str,
    pub found: String,
}

/// GUM (JCGM 100:2008) table H.6: thermometer reading °C and observed correction °C.
const THERMOMETER: [(f64, f64); 11] = [
    (21.521, -0.171),
    (22.012, -0.169),
    (22.512, -0.166),
    (23.003, -0.159),
    (23.507, -0.164),
    (23.999, -0.165),
    (24.513, -0.156),
    (25.002, -0.157),
    (25.503, -0.159),
    (26.010, -0.161),
    (26.511, -0.160),
];

/// ISO/TS 28037:2010 clause 6: y at x = 1 … 6, each with u(y) = 0.5.
const LINE: [f64; 6] = [3.3, 5.6, 7.1, 9.3, 10.7, 12.1];
const U_Y: f64 = 0.5;

pub fn rows() -> Vec<Row> {
    let mut rows = thermometer();
    rows.extend(weighted_line());
    rows
}

fn thermometer() -> Vec<Row> {
    let t_0 = 20.0;
    let design =
        DMatrix::from_fn(THERMOMETER.len(), 2, |i, j| if j == 0 { 1.0 } else { THERMOMETER[i].0 - t_0 });
    let fit = least_squares(&design, &DVector::from_fn(THERMOMETER.len(), |i, _| THERMOMETER[i].1), 1e-12);
    let r = fit.cofactor[(0, 1)] / (fit.cofactor[(0, 0)] * fit.cofactor[(1, 1)]).sqrt();
    let row = |figure, printed, found: String| Row { figure, printed, found };
    vec![
        row("GUM H.3: y₁, °C", "-0.171204", format!("{:.6}", fit.x[0])),
        row("GUM H.3: y₂", "0.0021827", format!("{:.7}", fit.x[1])),
        row("GUM H.3: s(y₁), °C", "0.0028776", format!("{:.7}", fit.u[0])),
        row("GUM H.3: s(y₂)", "0.00066794", format!("{:.8}", fit.u[1])),
        row("GUM H.3: r(y₁, y₂)", "-0.93043", format!("{r:.5}")),
    ]
}

fn weighted_line() -> Vec<Row> {
    let design = DMatrix::from_fn(6, 2, |i, j| if j == 0 { 1.0 } else { (i + 1) as f64 } / U_Y);
    let y = DVector::from_fn(6, |i, _| LINE[i] / U_Y);
    let fit = least_squares(&design, &y, 1e-12);
    let chi_squared = (&design * &fit.x - &y).norm_squared();
    let row = |figure, printed, found: String| Row { figure, printed, found };
    vec![
        row("ISO/TS 28037 clause 6: a", "1.8667", format!("{:.4}", fit.x[0])),
        row("ISO/TS 28037 clause 6: b", "1.7571", format!("{:.4}", fit.x[1])),
        row("ISO/TS 28037 clause 6: u(a)", "0.4655", format!("{:.4}", fit.cofactor[(0, 0)].sqrt())),
        row("ISO/TS 28037 clause 6: u(b)", "0.1195", format!("{:.4}", fit.cofactor[(1, 1)].sqrt())),
        row("ISO/TS 28037 clause 6: cov(a, b)", "-0.050", format!("{:.3}", fit.cofactor[(0, 1)])),
        row("ISO/TS 28037 clause 6: χ²", "1.665", format!("{chi_squared:.3}")),
    ]
}
