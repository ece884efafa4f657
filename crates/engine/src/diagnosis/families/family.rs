//! A family of the open grammar: one expression with shape numbers.

use trunnion_effects::Instance;

/// One way to depend on the state.
#[derive(Clone, Debug)]
pub struct Family {
    /// With parameters p1, p2, … and the shape numbers by name.
    pub expression: String,
    /// The expression as a formula effect of one component.
    pub formula: Instance,
    pub(super) columns: usize,
    /// Shape numbers.
    pub numbers: Vec<Number>,
    /// Shapes that are scanned: one value for each number.
    pub grid: Vec<Vec<f64>>,
    /// Price of its complexity, ln.
    pub price_ln: f64,
    /// In words.
    pub words: String,
    /// Families of the same idea.
    pub idea: String,
    /// Where it may act.
    pub carriers: Carriers,
    /// Whether it is a repeatable motion of a rotary axis, of which every bearing has some.
    pub natural: bool,
    /// False: tried only where its relatives do well.
    pub scanned: bool,
}

impl Family {
    /// Number of its factors, each with a parameter.
    pub fn factors(&self) -> usize {
        self.columns
    }

    /// Its grid where numbers of the same name are known already.
    pub fn grid_at(&self, known: &[(&str, f64)]) -> Vec<Vec<f64>> {
        let placed = |shape: &Vec<f64>| {
            let of = |(number, value): (&Number, &f64)| {
                known.iter().find(|(name, _)| *name == number.name).map_or(*value, |(_, known)| *known)
            };
            self.numbers.iter().zip(shape).map(of).collect::<Vec<f64>>()
        };
        let mut grid: Vec<Vec<f64>> = self.grid.iter().map(placed).collect();
        grid.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        grid.dedup();
        grid
    }
}

/// A shape number and where it may lie.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    pub name: &'static str,
    pub low: f64,
    pub high: f64,
}

impl Number {
    /// Unit of its value.
    pub fn unit(&self) -> &'static str {
        match self.name {
            "tau" | "when" => "s",
            "rate" => "rad/s",
            "per_mm" => "rad/mm",
            "cycles" | "duty" | "power" => "1",
            _ => "rad",
        }
    }
}

/// Where a family may act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carriers {
    /// Every component at every rotary axis, the ball, and between tool and table.
    All,
    /// Displacements between tool and table in machine axes.
    Ground,
}
