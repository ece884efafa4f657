//! Names of the state in a formula, inside units.

use crate::Scene;
use trunnion_core::{Joint, State};
use trunnion_machine::Machine;

/// A symbol of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Symbol<'a> {
    Of(Quantity, Joint),
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

/// The symbol of this name on a machine; any other name is a parameter. X Y Z A B C are never parameters.
pub(super) fn symbol<'a>(name: &'a str, machine: &Machine) -> Option<Symbol<'a>> {
    if name == "t" {
        return Some(Symbol::Time);
    }
    if let Some(channel) = name.strip_prefix("T_") {
        return Some(Symbol::Temperature(channel));
    }
    let joints = Joint::ALL.into_iter().chain(machine.axes().map(|axis| axis.letter));
    for letter in joints {
        let Some(prefix) = name.strip_suffix(letter.as_str()) else { continue };
        if let Some((_, quantity)) = PREFIXES.into_iter().find(|(known, _)| *known == prefix) {
            return Some(Symbol::Of(quantity, letter));
        }
    }
    None
}

/// Every name about the axes in `letters`, and `t`.
pub(super) fn names(letters: &[Joint]) -> Vec<String> {
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
    pub fn of(self, state: &State, letter: Joint) -> f64 {
        match self {
            Self::Position => state.position[letter],
            Self::Velocity => state.velocity[letter],
            Self::Acceleration => state.acceleration[letter],
            Self::Direction => state.direction[letter],
            Self::SinceReversal => state.since_reversal[letter],
        }
    }
}
