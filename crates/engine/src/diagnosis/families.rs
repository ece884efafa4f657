//! The factors of the open grammar: how a motion without a name may depend on angle, direction, place and time (docs/design/statistics.md §4.3).
//!
//! A family is one expression with shape numbers (where, how wide, how fast). Only a coarse grid of them is scanned for every carrier;
//! the shape numbers of what does well are then refined, and its relatives (the same idea in another form, such as the soft form of a step)
//! are tried as well.

mod angle;
mod clock;
mod travel;

use crate::Experiment;
use crate::noise::machine_noise::Order;
use crate::spectrum::Wave;
use trunnion_core::Joint;
use trunnion_effects::{Formula, Instance, ModelEffect};

/// One way to depend on the state.
#[derive(Clone, Debug)]
pub struct Family {
    /// With parameters p1, p2, … and the shape numbers by name.
    pub expression: String,
    /// The expression as a formula effect of one component.
    pub formula: Instance,
    columns: usize,
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

/// A family as written below.
struct Draft {
    idea: String,
    columns: Vec<String>,
    numbers: Vec<Number>,
    grid: Vec<Vec<f64>>,
    order: usize,
    words: String,
    carriers: Carriers,
    natural: bool,
    scanned: bool,
}

impl Draft {
    fn new(idea: impl Into<String>, order: usize, columns: Vec<String>, words: impl Into<String>) -> Self {
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
    fn with(mut self, name: &'static str, (low, high): (f64, f64), values: &[f64]) -> Self {
        self.numbers.push(Number { name, low, high });
        let grid = std::mem::take(&mut self.grid);
        let longer = |start: &Vec<f64>, value: &f64| start.iter().chain([value]).copied().collect();
        self.grid =
            grid.iter().flat_map(|start| values.iter().map(move |value| longer(start, value))).collect();
        self
    }

    fn ground(self) -> Self {
        Self { carriers: Carriers::Ground, ..self }
    }

    fn natural(self) -> Self {
        Self { natural: true, ..self }
    }

    fn only_refined(self) -> Self {
        Self { scanned: false, ..self }
    }
}

/// Every family that makes sense in an experiment.
pub fn families(experiment: &Experiment, order: &Order, waves: &[(Joint, Wave)]) -> Vec<Family> {
    let rotary: Vec<Joint> = [order.slow, order.fast].into_iter().flatten().collect();
    let scene = &experiment.scene;
    let mut drafts = Vec::new();
    angle::angles(&rotary, &mut drafts);
    for &letter in &rotary {
        angle::directions(letter, &rotary, scene, &mut drafts);
        angle::places(letter, scene, &mut drafts);
        angle::knees(letter, scene, &mut drafts);
    }
    drafts.extend(waves.iter().map(|(joint, wave)| travel::wave(*joint, wave)));
    travel::linear(experiment, &mut drafts);
    travel::moving(&rotary, scene, &mut drafts);
    if let Some(duration_s) = scene.duration_s().filter(|d| *d > 0.0) {
        clock::settling(duration_s, &rotary, &mut drafts);
        clock::switching(duration_s, scene, &mut drafts);
    }
    clock::temperatures(&rotary, scene, &mut drafts);
    drafts.into_iter().filter_map(|draft| family(draft, experiment)).collect()
}

fn family(draft: Draft, experiment: &Experiment) -> Option<Family> {
    let terms = draft.columns.iter().enumerate();
    let term = |(i, factor): (usize, &String)| match factor.strip_prefix("1/") {
        Some(below) => format!("p{}/{below}", i + 1),
        None => format!("p{}*{factor}", i + 1),
    };
    let expression = terms.map(term).collect::<Vec<_>>().join(" + ");
    let entry = ModelEffect {
        id: Formula::id_of("factor"),
        site: Some("spindle".into()),
        component: Some("dx".into()),
        expression: Some(expression.clone()),
        shape: draft.grid.first().cloned().unwrap_or_default(),
        ..ModelEffect::default()
    };
    let formula = Instance::from_model_effect(&entry, experiment.machine()).unwrap_or_else(|error| {
        panic!("the grammar writes formulas that can be read: {error:?}: {expression}")
    });
    if formula.parameters(&experiment.scene).is_empty() {
        return None;
    }
    Some(Family {
        expression,
        formula,
        columns: draft.columns.len(),
        numbers: draft.numbers,
        grid: draft.grid,
        price_ln: draft.order as f64,
        words: draft.words,
        idea: draft.idea,
        carriers: draft.carriers,
        natural: draft.natural,
        scanned: draft.scanned,
    })
}

/// `1`, or cos and sin of a harmonic.
fn waves(letter: Option<Joint>, harmonic: usize) -> Vec<String> {
    match (letter, harmonic) {
        (None, _) | (_, 0) => vec!["1".into()],
        (Some(l), 1) => vec![format!("cos({l})"), format!("sin({l})")],
        (Some(l), k) => vec![format!("cos({k}*{l})"), format!("sin({k}*{l})")],
    }
}

fn products(first: &[String], second: &[String]) -> Vec<String> {
    let product = |a: &String, b: &String| match (a.as_str(), b.as_str()) {
        ("1", _) => b.clone(),
        (_, "1") => a.clone(),
        _ => format!("{a}*{b}"),
    };
    first.iter().flat_map(|a| second.iter().map(move |b| product(a, b))).collect()
}

/// Simple companions of direction, speed and time: nothing, or the first harmonic of one axis.
fn companions(rotary: &[Joint]) -> Vec<(usize, Vec<String>, String)> {
    let mut companions = vec![(0, vec!["1".into()], String::new())];
    for &letter in rotary {
        companions.push((1, waves(Some(letter), 1), format!(", once per turn of {letter}")));
    }
    companions
}
