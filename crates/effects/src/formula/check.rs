//! What a person meant but did not write: names close to those of the state, degrees, places without a value.

use super::error::{FormulaError, Hundredths};
use super::expression::{Expression, Function, Node, Operator};
use super::symbol::{Quantity, Symbol, names, symbol};
use std::f64::consts::TAU;
use trunnion_core::Joint;
use trunnion_core::names::{distance, nearest};
use trunnion_machine::Machine;

/// Names shorter than this are anybody's parameters unless they differ from a symbol by an underscore.
const LONG: usize = 4;

/// The names of the expression that are parameters, in order of appearance.
pub(super) fn parameters(expression: &Expression, machine: &Machine) -> Result<Vec<String>, FormulaError> {
    let letters: Vec<Joint> = machine.axes().map(|axis| axis.letter).collect();
    let mut parameters = Vec::new();
    for (name, column) in expression.names() {
        match symbol(name, machine) {
            Some(Symbol::Of(_, letter)) if machine.axis(letter).is_none() => {
                return Err(FormulaError::Syntax {
                    column,
                    found: format!("\"{name}\", an axis machine {} does not have", machine.name),
                    allowed: letters.iter().map(|l| l.as_str()).collect::<Vec<_>>().join(" "),
                    advice: String::new(),
                });
            }
            Some(_) => {}
            None => match slip(name, &letters) {
                Some(advice) => return Err(FormulaError::Name { column, name: name.into(), advice }),
                None => parameters.push(name.to_string()),
            },
        }
    }
    Ok(parameters)
}

/// What a name that is no symbol was probably meant to be; `None` for a parameter.
fn slip(name: &str, letters: &[Joint]) -> Option<String> {
    let rename = "Give the parameter another name if it is one.";
    let unit = |suffix: &str| {
        name.strip_suffix(suffix)
            .and_then(|name| letters.iter().find(|l| l.lower().eq_ignore_ascii_case(name)))
    };
    if let Some(letter) = unit("_deg") {
        return Some(format!("{letter} is in rad; in degrees it is {letter}*180/pi. {rename}"));
    }
    if let Some(letter) = unit("_rad").or_else(|| unit("_mm")) {
        return Some(format!("Did you mean {letter}? {rename}"));
    }
    if matches!(name.to_lowercase().as_str(), "time" | "t_s" | "time_s") {
        return Some(format!("The time since the first point is t, in s. {rename}"));
    }
    if name.eq_ignore_ascii_case("pi") {
        return Some("Did you mean pi?".into());
    }
    let known = names(letters);
    let known = || known.iter().map(String::as_str).filter(|k| k.len() > 1);
    let plain = |text: &str| text.replace('_', "");
    if let Some(meant) = known().find(|k| name.len() > k.len() && plain(name).eq_ignore_ascii_case(k)) {
        return Some(format!("Did you mean {meant}? {rename}"));
    }
    let long = || known().filter(|k| k.len() >= LONG);
    let near = |k: &&str| distance(&name.to_lowercase(), &k.to_lowercase()) <= 1;
    if name.len() + 1 >= LONG && long().any(|k| near(&k)) {
        let meant = nearest(name, long().filter(near)).unwrap_or_default();
        return Some(format!("Did you mean {meant}? {rename}"));
    }
    None
}

/// Refuses an angle set against a number that only makes sense in degrees; `values_of` gives the values of the shape numbers.
pub(super) fn degrees(
    expression: &Expression,
    machine: &Machine,
    values_of: &impl Fn(&str) -> Vec<f64>,
) -> Result<(), FormulaError> {
    let mut found = Ok(());
    expression.walk(&mut |part| {
        let Node::Pair(operator, a, b) = &part.node else { return };
        if !matches!(operator, Operator::Sum | Operator::Difference | Operator::Min | Operator::Max) {
            return;
        }
        for (angle, other) in [(a, b), (b, a)] {
            let Some(letter) = angle_of(angle, machine) else { continue };
            let Some((low, high)) = machine.axis(letter).map(|axis| axis.travel) else { continue };
            let largest = low.abs().max(high.abs()).max(TAU);
            let beyond = constants(other, values_of).into_iter().find(|value| value.abs() > largest);
            if let (Some(value), Ok(())) = (beyond, &found) {
                found = Err(FormulaError::Degrees {
                    column: other.column,
                    axis: letter.to_string(),
                    low: low.into(),
                    high: high.into(),
                    value: value.into(),
                });
            }
        }
    });
    found
}

/// The rotary axis whose angle this is, or the size of its angle.
fn angle_of(expression: &Expression, machine: &Machine) -> Option<Joint> {
    match &expression.node {
        Node::Call(Function::Abs, inside) => angle_of(inside, machine),
        Node::Name(name) => match symbol(name, machine) {
            Some(Symbol::Of(Quantity::Position, letter)) if letter.is_rotary() => Some(letter),
            _ => None,
        },
        Node::Number(_) | Node::Pair(..) | Node::Call(..) => None,
    }
}

/// Values of a number or of a shape number.
fn constants(expression: &Expression, values_of: &impl Fn(&str) -> Vec<f64>) -> Vec<f64> {
    match &expression.node {
        Node::Number(x) => vec![*x],
        Node::Name(name) => values_of(name),
        Node::Pair(..) | Node::Call(..) => Vec::new(),
    }
}

/// Refuses roots and logarithms of what they do not have and divisions by zero, anywhere on a sample of the travel.
/// Overflow is not looked for: a fit says where it meets one.
pub(super) fn domain(
    expression: &Expression,
    machine: &Machine,
    shape_value: &impl Fn(&str) -> Option<f64>,
) -> Result<(), FormulaError> {
    for sample in 0..SAMPLES {
        let value_of = |name: &str| match (symbol(name, machine), shape_value(name)) {
            (Some(symbol), _) => sampled(symbol, machine, sample),
            (None, Some(value)) => value,
            (None, None) => 1.0,
        };
        let mut found = None;
        expression.walk(&mut |part| found = found.take().or_else(|| violation(part, &value_of)));
        if let Some(Violation { column, of, what, advice }) = found {
            let at = |(name, _): (&str, usize)| format!("{name} = {}", Hundredths::from(value_of(name)));
            let place: Vec<String> = of.names().into_iter().map(at).collect();
            let place = if place.is_empty() { "every state".into() } else { place.join(", ") };
            return Err(FormulaError::Domain { column, what, place, advice: advice.into() });
        }
    }
    Ok(())
}

const SAMPLES: usize = 48;

/// A value that the symbol can have: sample 0 is the zero state, then ends of the travel, then places in between.
fn sampled(symbol: Symbol<'_>, machine: &Machine, sample: usize) -> f64 {
    // Low-discrepancy numbers in 0…1, another sequence for each axis.
    let share = |k: usize| match sample {
        1 => 0.0,
        2 => 1.0,
        _ => (sample as f64 * 0.618_033_988_75 * (k + 1) as f64).fract(),
    };
    if sample == 0 {
        return 0.0;
    }
    match symbol {
        Symbol::Of(Quantity::Position, letter) => {
            let (low, high) = machine.axis(letter).map_or((-1.0, 1.0), |axis| axis.travel);
            low + (high - low) * share(letter.index())
        }
        Symbol::Of(Quantity::Direction, letter) => [-1.0, 0.0, 1.0][(sample + letter.index()) % 3],
        Symbol::Of(Quantity::SinceReversal, letter) => share(letter.index()),
        Symbol::Of(Quantity::Velocity | Quantity::Acceleration, letter) => 2.0 * share(letter.index()) - 1.0,
        Symbol::Time => 3600.0 * share(6),
        Symbol::Temperature(_) => 4.0 * share(7) - 2.0,
    }
}

/// A place without a value.
struct Violation<'a> {
    /// Column of the operator or function.
    column: usize,
    /// What it cannot be done to.
    of: &'a Expression,
    what: &'static str,
    advice: &'static str,
}

fn violation<'a>(part: &'a Expression, value_of: &impl Fn(&str) -> f64) -> Option<Violation<'a>> {
    let (of, what, advice) = match &part.node {
        Node::Call(Function::Sqrt, x) if x.value(value_of) < 0.0 => {
            (x, "the square root of a negative number", "Write sqrt(abs(x)) or sqrt(max(0, x)).")
        }
        Node::Call(Function::Log, x) if x.value(value_of) <= 0.0 => {
            (x, "the logarithm of zero or less", "Write log(1 + abs(x)) or log(max(0.001, x)).")
        }
        Node::Pair(Operator::Quotient, _, x) if x.value(value_of) == 0.0 => {
            (x, "a division by zero", "Keep the divisor away from zero, e.g. 1/(0.1 + abs(x)).")
        }
        Node::Pair(Operator::Power, x, n) => {
            let (base, exponent) = (x.value(value_of), n.value(value_of));
            if base < 0.0 && exponent.fract() != 0.0 {
                (x, "a broken power of a negative number", "Write abs(x)^n or max(0, x)^n.")
            } else if base == 0.0 && exponent < 0.0 {
                (x, "a negative power of zero", "Keep the base away from zero, e.g. (0.1 + abs(x))^n.")
            } else {
                return None;
            }
        }
        Node::Number(_) | Node::Name(_) | Node::Pair(..) | Node::Call(..) => return None,
    };
    Some(Violation { column: part.column, of, what, advice })
}
