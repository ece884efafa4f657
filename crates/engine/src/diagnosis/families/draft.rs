//! How a family is written: factors, where they may act, and what their shape numbers are.

use super::family::{Carriers, Number};
use trunnion_core::Joint;

/// A family before its expression is read.
pub(super) struct Draft {
    pub idea: String,
    pub columns: Vec<String>,
    pub numbers: Vec<Number>,
    pub grid: Vec<Vec<f64>>,
    pub order: usize,
    pub words: String,
    pub carriers: Carriers,
    pub natural: bool,
    pub scanned: bool,
}

impl Draft {
    pub fn new(
        idea: impl Into<String>,
        order: usize,
        columns: Vec<String>,
        words: impl Into<String>,
    ) -> Self {
        Self {
            idea: idea.into(),
            columns,
            numbers: Vec::new(),
            grid: vec![Vec::new()],
            order,
            words: words.into(),
            carriers: Carriers::All,
            natural: false,
            scanned: true,
        }
    }

    /// With one more shape number; the grid becomes the product.
    pub fn with(mut self, name: &'static str, (low, high): (f64, f64), values: &[f64]) -> Self {
        self.numbers.push(Number { name, low, high });
        let grid = std::mem::take(&mut self.grid);
        let longer = |start: &Vec<f64>, value: &f64| start.iter().chain([value]).copied().collect();
        self.grid =
            grid.iter().flat_map(|start| values.iter().map(move |value| longer(start, value))).collect();
        self
    }

    pub fn ground(self) -> Self {
        Self { carriers: Carriers::Ground, ..self }
    }

    pub fn natural(self) -> Self {
        Self { natural: true, ..self }
    }

    pub fn only_refined(self) -> Self {
        Self { scanned: false, ..self }
    }
}

/// `1`, or cos and sin of a harmonic.
pub(super) fn waves(letter: Option<Joint>, harmonic: usize) -> Vec<String> {
    match (letter, harmonic) {
        (None, _) | (_, 0) => vec!["1".into()],
        (Some(l), 1) => vec![format!("cos({l})"), format!("sin({l})")],
        (Some(l), k) => vec![format!("cos({k}*{l})"), format!("sin({k}*{l})")],
    }
}

/// Every factor of one list times every one of the other.
pub(super) fn products(first: &[String], second: &[String]) -> Vec<String> {
    let product = |a: &String, b: &String| match (a.as_str(), b.as_str()) {
        ("1", _) => b.clone(),
        (_, "1") => a.clone(),
        _ => format!("{a}*{b}"),
    };
    first.iter().flat_map(|a| second.iter().map(move |b| product(a, b))).collect()
}

/// Simple companions of direction, speed and time: nothing, or the first harmonic of one axis.
pub(super) fn companions(rotary: &[Joint]) -> Vec<(usize, Vec<String>, String)> {
    let mut companions = vec![(0, vec!["1".into()], String::new())];
    for &letter in rotary {
        companions.push((1, waves(Some(letter), 1), format!(", once per turn of {letter}")));
    }
    companions
}
