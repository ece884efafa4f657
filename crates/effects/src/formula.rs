//! Formula effects, `formula:NAME`: an expression over the state with named parameters, written in a model file
//! or found by a diagnosis (docs/design/contracts.md §4).
//!
//! Symbols, inside units: `A B C` rad, `X Y Z` mm, other joints of the machine by name (`j1`, `vj1`), `vB` and `aB` velocity and acceleration (per s, per s²), `dirB` −1, 0, 1,
//! `sinceB` travel since B last turned round, `t` s since the first point, `T_NAME` change of temperature channel NAME since
//! its first value, K; `pi`. Every other name is a parameter.
//! A parameter that enters linearly by structure is fitted, in µm (`dx dy dz`) or µrad (`ea eb ec`) per unit of
//! its factor. The others are shape numbers: they need `shape` values or a `grid`.

mod check;
mod error;
mod expression;
mod parser;
mod symbol;

pub use error::{FormulaError, Hundredths};
pub use expression::{Expression, Function, Node, Operator};

use crate::{Emit, ModelEffect, Parameter, Scene, Shapes, Unit};
use nalgebra::Vector3;
use symbol::{Symbol, symbol};
use trunnion_core::{Joint, State, Twist, names};
use trunnion_machine::{Machine, Site};

/// A formula effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Name, the part of the id after `formula:`.
    pub name: String,
    /// Where it acts.
    pub site: Site,
    /// Which component of the twist.
    pub component: Component,
    /// The expression as written.
    pub text: String,
    /// The expression.
    pub expression: Expression,
    /// Parameters that enter linearly.
    pub linear: Vec<String>,
    /// The other parameters: shape numbers.
    pub nonlinear: Vec<String>,
    /// Grid of the shape numbers; one point when the entry gives values.
    pub grid: Vec<Vec<f64>>,
}

/// A component of a twist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are those of the model file")]
pub enum Component {
    Dx,
    Dy,
    Dz,
    Ea,
    Eb,
    Ec,
}

const COMPONENTS: [(&str, Component); 6] = [
    ("dx", Component::Dx),
    ("dy", Component::Dy),
    ("dz", Component::Dz),
    ("ea", Component::Ea),
    ("eb", Component::Eb),
    ("ec", Component::Ec),
];
/// Most points of the product grid of all shape numbers.
const MOST_GRID_POINTS: usize = 10_000;

/// First part of the id of a formula.
const OWN: &str = "formula:";

impl Formula {
    /// The id of a formula, `formula:NAME`.
    pub fn id_of(name: &str) -> String {
        format!("{OWN}{name}")
    }

    /// The name in the id of a formula; `None` for the id of a catalogue effect.
    pub fn name_of(id: &str) -> Option<&str> {
        id.strip_prefix(OWN)
    }

    /// Reads the formula of a model entry.
    ///
    /// # Errors
    /// What is wrong, with the column in the expression, and what is allowed.
    pub fn from_model_effect(entry: &ModelEffect, machine: &Machine) -> Result<Self, FormulaError> {
        let required = |key: &'static str, text: &Option<String>, allowed: &str| {
            text.clone().ok_or_else(|| wrong(key, "missing", allowed))
        };
        let name = Self::name_of(&entry.id).unwrap_or_default().to_string();
        if name.is_empty() {
            return Err(wrong("id", &format!("\"{}\"", entry.id), "formula:NAME"));
        }
        let site_text = required("site", &entry.site, "axis:B, ball, spindle, reading")?;
        let component_text = required("component", &entry.component, "dx, dy, dz, ea, eb, ec")?;
        let text = required("expression", &entry.expression, "such as \"a*sin(2*B)\"")?;
        let site = site(&site_text, machine)?;
        let component = component(&component_text, site)?;
        let expression = Expression::parse(&text)?;
        let parameters = check::parameters(&expression, machine)?;
        let (linear, nonlinear) = split(&expression, parameters);
        if let Some(term) = expression.term_without(&|name| linear.iter().any(|p| p == name)) {
            return Err(FormulaError::NoParameter { column: term.column });
        }
        let grid = grid(entry, &expression, &nonlinear)?;
        let place = |name: &str| nonlinear.iter().position(|p| p == name);
        let values_of = |name: &str| place(name).map_or(Vec::new(), |k| grid.iter().map(|g| g[k]).collect());
        check::degrees(&expression, machine, &values_of)?;
        for point in grid.iter().take(1).chain(grid.last()) {
            check::domain(&expression, machine, &|name| place(name).map(|k| point[k]))?;
        }
        Ok(Self { name, site, component, text, expression, linear, nonlinear, grid })
    }

    /// Why the formula is out of reach in this scene: it uses the time or a temperature channel that is not there.
    pub fn out_of_reach(&self, scene: &Scene) -> Option<String> {
        self.expression.names().into_iter().find_map(|(name, _)| match symbol(name, &scene.machine)? {
            Symbol::Time if !scene.has_time() => Some("needs time stamps, for t".into()),
            Symbol::Temperature(channel) if !scene.channels.iter().any(|c| c == channel) => {
                let known = scene.channels.iter().map(String::as_str);
                let meant = names::nearest(channel, known)
                    .map_or(String::new(), |near| format!("; did you mean T_{near}?"));
                let names: Vec<String> = scene.channels.iter().map(|c| format!("T_{c}")).collect();
                let known = if names.is_empty() { "none".into() } else { names.join(" ") };
                Some(format!(
                    "needs temperature channel \"{channel}\" for {name}; the runs have {known}{meant}"
                ))
            }
            Symbol::Time | Symbol::Temperature(_) | Symbol::Of(..) => None,
        })
    }

    /// Fitted parameters; empty when out of reach.
    pub fn parameters(&self, scene: &Scene) -> Vec<Parameter> {
        if self.out_of_reach(scene).is_some() {
            return Vec::new();
        }
        let unit = if self.component.turns() { Unit::URAD } else { Unit::UM };
        self.linear.iter().map(|name| Parameter::new(name, unit)).collect()
    }

    /// Grid of the non-linear parameters.
    pub fn shapes(&self) -> Shapes {
        Shapes {
            names: self.nonlinear.clone(),
            grid: self.grid.clone(),
            continuous: !self.nonlinear.is_empty() && self.grid.len() > 1,
            ..Shapes::default()
        }
    }

    /// Twist per unit of each linear parameter.
    pub fn motions(&self, scene: &Scene, shape: &[f64], state: &State, emit: Emit<'_>) {
        for (i, parameter) in self.linear.iter().enumerate() {
            let coefficient = self.expression.value(&|name| {
                if let Some(symbol) = symbol(name, &scene.machine) {
                    return symbol.value(scene, state);
                }
                if let Some(k) = self.nonlinear.iter().position(|p| p == name) {
                    return shape.get(k).copied().unwrap_or(f64::NAN);
                }
                f64::from(u8::from(name == parameter))
            });
            emit(i, self.site, self.component.unit_twist() * coefficient);
        }
    }
}

impl Component {
    fn turns(self) -> bool {
        self as usize >= 3
    }

    fn unit_twist(self) -> Twist {
        let unit = Vector3::ith(self as usize % 3, 1.0);
        if self.turns() { Twist::rotation(unit) } else { Twist::translation(unit) }
    }
}

fn wrong(key: &'static str, found: &str, allowed: &str) -> FormulaError {
    FormulaError::Key { key, found: found.into(), allowed: allowed.into() }
}

fn site(text: &str, machine: &Machine) -> Result<Site, FormulaError> {
    let axis = text.strip_prefix("axis:").and_then(|name| machine.joint(name));
    match (text, axis) {
        (_, Some(letter)) => Ok(Site::Joint(letter)),
        ("ball", _) => Ok(Site::TableBall),
        ("spindle", _) => Ok(Site::SpindleBall),
        ("reading", _) => Ok(Site::Reading),
        _ => {
            let axes = machine.axes().map(|a| format!("axis:{}", a.letter));
            let others = ["ball", "spindle", "reading"].map(String::from);
            Err(wrong("site", &format!("\"{text}\""), &names::allowed(text, axes.chain(others))))
        }
    }
}

fn component(text: &str, site: Site) -> Result<Component, FormulaError> {
    let turns = matches!(site, Site::Joint(_));
    let allowed = &COMPONENTS[..if turns { 6 } else { 3 }];
    allowed.iter().find(|(name, _)| *name == text).map(|(_, c)| *c).ok_or_else(|| {
        let names = allowed.iter().map(|(name, _)| *name);
        wrong("component", &format!("\"{text}\""), &names::allowed(text, names))
    })
}

/// Linear parameters as many as enter linearly together, in order of appearance; the rest.
fn split(expression: &Expression, parameters: Vec<String>) -> (Vec<String>, Vec<String>) {
    let (mut linear, mut nonlinear): (Vec<String>, Vec<String>) = Default::default();
    for parameter in parameters {
        let joined = |name: &str| name == parameter || linear.iter().any(|p| p == name);
        if matches!(expression.degree(&joined), Some(0 | 1)) {
            linear.push(parameter);
        } else {
            nonlinear.push(parameter);
        }
    }
    (linear, nonlinear)
}

/// How to write the commonest non-linear parameters so that they can be fitted.
fn linear_way(expression: &Expression, name: &str) -> String {
    if let Some(letter) = Joint::parse(name) {
        return format!("{name} is a parameter; the position of axis {letter} is written {letter}.");
    }
    let holds = |e: &Expression| e.names().iter().any(|(known, _)| *known == name);
    let lone = |e: &Expression| matches!(&e.node, Node::Name(known) if known == name);
    let (mut in_function, mut is_phase, mut is_divisor) = (false, false, false);
    expression.walk(&mut |part| match &part.node {
        Node::Call(function, inside) if holds(inside) => {
            in_function = true;
            is_phase |= matches!(function, Function::Sin | Function::Cos)
                && matches!(&inside.node, Node::Pair(Operator::Sum | Operator::Difference, a, b) if lone(a) || lone(b));
        }
        Node::Pair(Operator::Quotient, _, divisor) => is_divisor |= lone(divisor),
        Node::Number(_) | Node::Name(_) | Node::Pair(..) | Node::Call(..) => {}
    });
    match (is_phase, is_divisor && !in_function) {
        (true, _) => "A phase is fitted when written as two terms: a*sin(x + phase) is p*sin(x) + q*cos(x).",
        (false, true) => "A divisor is fitted when written as a factor: x/k is k*x with another k.",
        (false, false) => "",
    }
    .into()
}

fn grid(
    entry: &ModelEffect,
    expression: &Expression,
    nonlinear: &[String],
) -> Result<Vec<Vec<f64>>, FormulaError> {
    let all = nonlinear.join(", ");
    if let Some((name, _)) = entry.grid.iter().find(|(name, _)| !nonlinear.contains(name)) {
        let allowed = if all.is_empty() {
            "no grid, every parameter is fitted".into()
        } else {
            let meant = names::nearest(name, nonlinear.iter().map(String::as_str));
            let meant = meant.map_or(String::new(), |near| format!("; did you mean {near}?"));
            format!("the non-linear parameters ({all}){meant}")
        };
        return Err(wrong("grid", &format!("for \"{name}\""), &allowed));
    }
    if !entry.shape.is_empty() && entry.shape.len() != nonlinear.len() {
        let found = format!("{} numbers", entry.shape.len());
        return Err(wrong("shape", &found, &format!("{} for ({all})", nonlinear.len())));
    }
    let mut points = vec![Vec::new()];
    for (k, name) in nonlinear.iter().enumerate() {
        let values = entry.grid.iter().find(|(known, _)| known == name).map(|(_, values)| values.clone());
        let values = values.or_else(|| entry.shape.get(k).map(|&value| vec![value]));
        let Some(values) = values else {
            let names = expression.names();
            let column = names.iter().find(|(known, _)| known == name).map_or(1, |(_, column)| *column);
            let advice = linear_way(expression, name);
            return Err(FormulaError::NoGrid { column, name: name.clone(), all, advice });
        };
        points = points
            .iter()
            .flat_map(|point: &Vec<f64>| {
                values.iter().map(move |&value| point.iter().copied().chain([value]).collect())
            })
            .collect();
        if points.len() > MOST_GRID_POINTS {
            let allowed = format!("at most {MOST_GRID_POINTS} points");
            return Err(wrong("grid", "too fine", &allowed));
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests;
