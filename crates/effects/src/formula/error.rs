//! Why a formula cannot be read: what was found and where, what is allowed, what to do next.

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
    #[error("expression, column {column}: found {found}; allowed: {allowed}{}", sentence(advice))]
    Syntax {
        /// Column, from 1.
        column: usize,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
        /// What to do next; may be empty.
        advice: String,
    },
    /// A name that is no parameter by intent.
    #[error("expression, column {column}: \"{name}\" is no name of the state{}", sentence(advice))]
    Name {
        /// Column, from 1.
        column: usize,
        /// The name.
        name: String,
        /// What was probably meant.
        advice: String,
    },
    /// A term that no fitted parameter scales: zero parameters would not give zero.
    #[error(
        "expression, column {column}: this term has no parameter to fit in front, so that it would be there even with all parameters \
         zero; multiply every term by one, e.g. \"a*sin(B) + b*t\""
    )]
    NoParameter {
        /// Column of the term, from 1.
        column: usize,
    },
    /// Non-linear parameters without values.
    #[error(
        "expression, column {column}: parameter {name} enters non-linearly (inside a function, a power, a divisor, or times another \
         parameter) and has neither a value nor a grid; give shape = [..] for ({all}) in this order, or grid = {{ {name} = [..] }}{}",
        sentence(advice)
    )]
    NoGrid {
        /// Column, from 1.
        column: usize,
        /// The parameter.
        name: String,
        /// All non-linear parameters in order.
        all: String,
        /// A way to write it linearly; may be empty.
        advice: String,
    },
    /// An angle that looks like degrees.
    #[error(
        "expression, column {column}: {axis} is in rad and stays within {low:.2} to {high:.2}, but is set against {value}; \
         for degrees write {value}*pi/180"
    )]
    Degrees {
        /// Column, from 1.
        column: usize,
        /// Letter of the axis.
        axis: String,
        /// Smallest angle, rad, as text of 2 digits.
        low: Hundredths,
        /// Largest angle, rad.
        high: Hundredths,
        /// The number.
        value: Hundredths,
    },
    /// No finite value somewhere within the travel.
    #[error(
        "expression, column {column}: {what} at {place}; an effect must have a value over the whole travel of the axes and from \
         t = 0 on{}",
        sentence(advice)
    )]
    Domain {
        /// Column of the operator or function, from 1.
        column: usize,
        /// What happens.
        what: &'static str,
        /// State at which it happens.
        place: String,
        /// How to write it.
        advice: String,
    },
}

/// A number shown with at most two decimals, comparable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hundredths(i64);

impl From<f64> for Hundredths {
    fn from(value: f64) -> Self {
        Self((value * 100.0).round() as i64)
    }
}

impl std::fmt::Display for Hundredths {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0 as f64 / 100.0)
    }
}

fn sentence(advice: &str) -> String {
    if advice.is_empty() { String::new() } else { format!(". {advice}") }
}
