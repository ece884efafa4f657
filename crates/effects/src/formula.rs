//! Formula effects, `formula:NAME`: an expression over the state with named parameters, written in a model file
//! or found by a diagnosis (DESIGN §3.4).
//!
//! Symbols, inside units: `A B C` rad, `X Y Z` mm, `t` s since the first point, `vB` rad/s or mm/s, `dirB` −1, 0, 1,
//! `T_NAME` change of temperature channel NAME since its first value, K; `pi`. Every other name is a parameter.
//! A parameter that enters linearly by structure is fitted, in µm (`dx dy dz`) or µrad (`ea eb ec`) per unit of
//! its factor. The others are shape numbers: they need `shape` values or a `grid`.

mod expression;

pub use expression::{Expression, Function};

use crate::{Emit, ModelEffect, Parameter, Scene, Shapes, Unit};
use nalgebra::Vector3;
use trunnion_machine::{Machine, Site, State};
use trunnion_units::{AxisLetter, Twist};

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

/// Why a formula cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormulaError {
    /// A key of the entry is missing or wrong.
    #[error("{key} is {found}; allowed: {allowed}")]
    Key {
        /// Key of the model entry.
        key: &'static str,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// The expression breaks off or holds something unknown.
    #[error("expression, column {column}: found {found}; allowed: {allowed}")]
    Syntax {
        /// Column, from 1.
        column: usize,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// A term that no fitted parameter scales: zero parameters would not give zero.
    #[error(
        "expression has a term without a linear parameter; multiply every term by one, e.g. \"a*sin(B) + b*t\""
    )]
    NoParameter,
    /// Non-linear parameters without values.
    #[error(
        "parameter {name} enters non-linearly and has neither a value nor a grid; \
         give shape = [..] for ({all}) in this order, or grid = {{ {name} = [..] }}"
    )]
    NoGrid {
        /// The parameter.
        name: String,
        /// All non-linear parameters in order.
        all: String,
    },
}

impl Formula {
    /// Reads the formula of a model entry.
    ///
    /// # Errors
    /// What is wrong, with the column in the expression, and what is allowed.
    pub fn from_model_effect(entry: &ModelEffect, machine: &Machine) -> Result<Self, FormulaError> {
        let required = |key: &'static str, text: &Option<String>, allowed: &str| {
            text.clone().ok_or_else(|| wrong(key, "missing", allowed))
        };
        let name = entry.id.strip_prefix("formula:").unwrap_or_default().to_string();
        if name.is_empty() {
            return Err(wrong("id", &format!("\"{}\"", entry.id), "formula:NAME"));
        }
        let site_text = required("site", &entry.site, "axis:B, ball, spindle, reading")?;
        let component_text = required("component", &entry.component, "dx, dy, dz, ea, eb, ec")?;
        let text = required("expression", &entry.expression, "such as \"a*sin(2*B)\"")?;
        let site = site(&site_text, machine)?;
        let component = component(&component_text, site)?;
        let expression = Expression::parse(&text)?;
        let mut parameters = Vec::new();
        for name in expression.names() {
            match symbol(&name) {
                None => parameters.push(name),
                Some(Symbol::Of(_, letter)) if machine.axis(letter).is_none() => {
                    return Err(FormulaError::Syntax {
                        column: text.find(&name).map_or(1, |at| at + 1),
                        found: format!("\"{name}\", an axis machine {} does not have", machine.name),
                        allowed: machine.axes().map(|a| a.letter.as_str()).collect::<Vec<_>>().join(" "),
                    });
                }
                Some(_) => {}
            }
        }
        let (linear, nonlinear) = split(&expression, parameters);
        if linear.is_empty() || !expression.vanishes_without(&|name| linear.iter().any(|p| p == name)) {
            return Err(FormulaError::NoParameter);
        }
        let grid = grid(entry, &nonlinear)?;
        Ok(Self { name, site, component, text, expression, linear, nonlinear, grid })
    }

    /// Fitted parameters; empty when the scene lacks time or a temperature channel the expression uses.
    pub fn parameters(&self, scene: &Scene) -> Vec<Parameter> {
        let reachable = self.expression.names().iter().all(|name| match symbol(name) {
            Some(Symbol::Time) => scene.has_time(),
            Some(Symbol::Temperature(channel)) => scene.channels.iter().any(|c| c == channel),
            Some(Symbol::Of(..)) | None => true,
        });
        if !reachable {
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
        }
    }

    /// Twist per unit of each linear parameter.
    pub fn motions(&self, scene: &Scene, shape: &[f64], state: &State, emit: Emit<'_>) {
        for (i, parameter) in self.linear.iter().enumerate() {
            let coefficient = self.expression.value(&|name| {
                if let Some(symbol) = symbol(name) {
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
    let axis = text.strip_prefix("axis:").and_then(AxisLetter::parse).filter(|&l| machine.axis(l).is_some());
    match (text, axis) {
        (_, Some(letter)) => Ok(Site::Joint(letter)),
        ("ball", _) => Ok(Site::TableBall),
        ("spindle", _) => Ok(Site::SpindleBall),
        ("reading", _) => Ok(Site::Reading),
        _ => {
            let axes: Vec<_> = machine.axes().map(|a| format!("axis:{}", a.letter)).collect();
            Err(wrong(
                "site",
                &format!("\"{text}\""),
                &format!("{}, ball, spindle, reading", axes.join(", ")),
            ))
        }
    }
}

fn component(text: &str, site: Site) -> Result<Component, FormulaError> {
    let turns = matches!(site, Site::Joint(_));
    let allowed = &COMPONENTS[..if turns { 6 } else { 3 }];
    allowed.iter().find(|(name, _)| *name == text).map(|(_, c)| *c).ok_or_else(|| {
        let names: Vec<_> = allowed.iter().map(|(name, _)| *name).collect();
        wrong("component", &format!("\"{text}\""), &names.join(", "))
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

fn grid(entry: &ModelEffect, nonlinear: &[String]) -> Result<Vec<Vec<f64>>, FormulaError> {
    let all = nonlinear.join(", ");
    if let Some((name, _)) = entry.grid.iter().find(|(name, _)| !nonlinear.contains(name)) {
        return Err(wrong("grid", &format!("for \"{name}\""), &format!("the non-linear parameters ({all})")));
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
            return Err(FormulaError::NoGrid { name: name.clone(), all });
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

/// A symbol of the state.
#[derive(Clone, Copy)]
enum Symbol<'a> {
    Of(Quantity, AxisLetter),
    Time,
    Temperature(&'a str),
}

#[derive(Clone, Copy)]
enum Quantity {
    Position,
    Velocity,
    Direction,
}

fn symbol(name: &str) -> Option<Symbol<'_>> {
    let axis = |quantity, text: &str| {
        let letter = AxisLetter::ALL.into_iter().find(|letter| letter.as_str() == text)?;
        Some(Symbol::Of(quantity, letter))
    };
    if name == "t" {
        return Some(Symbol::Time);
    }
    if let Some(channel) = name.strip_prefix("T_") {
        return Some(Symbol::Temperature(channel));
    }
    axis(Quantity::Position, name)
        .or_else(|| axis(Quantity::Velocity, name.strip_prefix('v')?))
        .or_else(|| axis(Quantity::Direction, name.strip_prefix("dir")?))
}

impl Symbol<'_> {
    fn value(self, scene: &Scene, state: &State) -> f64 {
        match self {
            Self::Of(Quantity::Position, letter) => state.position[letter],
            Self::Of(Quantity::Velocity, letter) => state.velocity[letter],
            Self::Of(Quantity::Direction, letter) => state.direction[letter],
            Self::Time => scene.elapsed_s(state).unwrap_or_default(),
            Self::Temperature(channel) => scene
                .channels
                .iter()
                .position(|c| c == channel)
                .and_then(|i| Some(state.temperature_degc.get(i)? - scene.first_temperature_degc.get(i)?))
                .unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests;
