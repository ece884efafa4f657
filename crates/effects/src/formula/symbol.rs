//! Names of the state in a formula, inside units.

use crate::Scene;
use trunnion_core::{AxisLetter, State};

/// A symbol of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Symbol<'a> {
    Of(Quantity, AxisLetter),
    Time,
    /// Channel name.
    Temperature(&'a str),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Position,
    Velocity,
    Acceleration,
    Direction,
    SinceReversal,
}

/// Prefixes of the letter of the axis.
const PREFIXES: [(&str, Quantity); 5] = [
    ("", Quantity::Position),
    ("v", Quantity::Velocity),
    ("a", Quantity::Acceleration),
    ("dir", Quantity::Direction),
    ("since", Quantity::SinceReversal),
];

/// The symbol of this name; any other name is a parameter.
pub(super) fn symbol(name: &str) -> Option<Symbol<'_>> {
    if name == "t" {
        return Some(Symbol::Time);
    }
    if let Some(channel) = name.strip_prefix("T_") {
        return Some(Symbol::Temperature(channel));
    }
    // Read for every point of a fit: one look at the last letter, one at what is before it.
    let (prefix, last) = name.split_at_checked(name.len().checked_sub(1)?)?;
    let letter = AxisLetter::ALL.into_iter().find(|letter| letter.as_str() == last)?;
    let (_, quantity) = PREFIXES.into_iter().find(|(known, _)| *known == prefix)?;
    Some(Symbol::Of(quantity, letter))
}

/// Every name about the axes in `letters`, and `t`.
pub(super) fn names(letters: &[AxisLetter]) -> Vec<String> {
    let of_axes =
        PREFIXES.into_iter().flat_map(|(prefix, _)| letters.iter().map(move |l| format!("{prefix}{l}")));
    of_axes.chain(["t".into()]).collect()
}

impl Symbol<'_> {
    pub fn value(self, scene: &Scene, state: &State) -> f64 {
        match self {
            Self::Of(quantity, letter) => quantity.of(state, letter),
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

impl Quantity {
    pub fn of(self, state: &State, letter: AxisLetter) -> f64 {
        match self {
            Self::Position => state.position[letter],
            Self::Velocity => state.velocity[letter],
            Self::Acceleration => state.acceleration[letter],
            Self::Direction => state.direction[letter],
            Self::SinceReversal => state.since_reversal[letter],
        }
    }
}
