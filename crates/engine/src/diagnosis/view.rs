//! What was added to the model, and what the catalogue scores next to it.

use crate::diagnosis::scan::Scan;
use crate::diagnosis::scan_fit::Fit;
use crate::diagnosis::vocabulary::Term;
use crate::evidence::{Score, Situation, stacked};
use nalgebra::DMatrix;

/// What was added to the model.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// Index of a named effect.
    Named(usize),
    /// Something without a name.
    Open(Term),
}

/// One addition with its columns.
#[derive(Clone, Debug)]
pub struct Item {
    pub what: What,
    /// Shape numbers.
    pub shape: Vec<f64>,
    /// Column × row.
    pub columns: DMatrix<f64>,
    /// ln odds when it was last scored, the others in the model.
    pub ln_odds: f64,
}

impl Item {
    pub fn is_open(&self) -> bool {
        matches!(self.what, What::Open(_))
    }
}

/// The readings with some columns in the model, and what the catalogue scores next to them.
pub struct View {
    /// Column × row.
    pub chosen: DMatrix<f64>,
    pub fit: Fit,
    pub situation: Situation,
    /// One score per named effect.
    pub named: Vec<Score>,
}

impl View {
    /// With `chosen` (column × row) in the model.
    pub fn of(scan: &Scan<'_>, chosen: DMatrix<f64>) -> Self {
        let fit = scan.fit(&chosen);
        let situation = scan.bank.situation(&fit.readings, &chosen);
        let all = scan.bank.all();
        let named = scan.bank.scan(&scan.named, &all, &scan.named_blocks(), &situation);
        Self { chosen, fit, situation, named }
    }
}

/// Columns of several items together.
pub fn columns_of<'a>(items: impl Iterator<Item = &'a Item>, rows: usize) -> DMatrix<f64> {
    items.fold(DMatrix::zeros(0, rows), |all, item| stacked(&all, &item.columns))
}
