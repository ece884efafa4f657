//! What an effect file provides.

use crate::{Emit, Golden, Need, Parameter, Scene, Shapes, Subject};
use trunnion_core::State;
use trunnion_machine::Machine;

/// One physical effect: plain data and functions, one constant per catalogue file.
pub struct Effect {
    /// First part of the id and name of the file (with `-` for `_`), e.g. `gravity-sag`.
    pub phenomenon: &'static str,
    /// What kind of thing it is.
    pub role: Role,
    /// What a person should know.
    pub about: About,
    /// On what this machine could show it: one instance each.
    pub subjects: fn(&Machine) -> Vec<Subject>,
    /// Linear parameters of one instance in this scene. Empty when the scene cannot have it
    /// (no time stamps, nothing moving, …): the instance is then out of reach.
    pub parameters: fn(&Scene, Subject) -> Vec<Parameter>,
    /// Grid of the shape numbers.
    pub shapes: fn(&Scene, Subject) -> Shapes,
    /// The equation: motions per unit parameter at a state, for one shape of the grid or near it.
    pub motions: fn(&Scene, Subject, &[f64], &State, Emit<'_>),
    /// A typical case, drawn in the catalogue.
    pub example: Example,
    /// A case whose readings come from outside this program.
    pub golden: Golden,
}

impl Effect {
    /// Whether it depends on time and on nothing else.
    pub fn is_of_time_alone(&self) -> bool {
        self.about.needs == [Need::TimeStamps]
    }
}

/// What kind of thing an effect is: who proposes it, and at which price.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Place and direction of the axis average lines, squareness included: constants that ISO 230-1 names.
    Location,
    /// What mounting and artefact leave unknown; without a number it is no loss.
    Setting,
    /// What every rotary axis has a little of: alone it names no fault.
    Natural,
    /// Describes an axis by many numbers and names no cause: for a person to choose, never a candidate.
    Description,
    /// A cause of error.
    Cause {
        /// What its prior costs beyond that of an everyday cause, ln of odds; 0 for an everyday cause.
        price_ln: f64,
    },
}

impl Role {
    /// A cause that needs no special circumstance.
    pub const CAUSE: Self = Self::Cause { price_ln: 0.0 };

    /// What the prior costs, ln of odds.
    pub fn price_ln(self) -> f64 {
        match self {
            Self::Cause { price_ln } => price_ln,
            Self::Location | Self::Setting | Self::Natural | Self::Description => 0.0,
        }
    }

    /// In words, for the catalogue.
    pub fn text(self) -> &'static str {
        match self {
            Self::Location => "location error",
            Self::Setting => "mounting or artefact",
            Self::Natural => "error motion that every axis has a little of",
            Self::Description => "description, no cause",
            Self::Cause { price_ln } if price_ln > 0.0 => "cause, in special circumstances",
            Self::Cause { .. } => "cause",
        }
    }
}

/// Documentation of an effect, used by reports and the generated catalogue.
pub struct About {
    /// Short title, e.g. "Sag of the tilting frame or head under its own weight".
    pub title: &'static str,
    /// Where it comes from, e.g. "S1 §5.3".
    pub source: &'static str,
    /// The equation in text.
    pub equation: &'static str,
    /// What the letters of the equation mean, with units.
    pub symbols: &'static str,
    /// When it holds, and when no more.
    pub validity: &'static str,
    /// Typical size on a good machine.
    pub typical: &'static str,
    /// One plain sentence for a technician: what it is.
    pub explanation: &'static str,
    /// Likely mechanical cause (S4 table 2 where it has one).
    pub cause: &'static str,
    /// Which measurement shows or separates it, e.g. "both directions of C".
    pub seen_by: &'static str,
    /// What the data must have; without any one of these the effect is out of reach.
    pub needs: &'static [Need],
    /// What separates it from similar effects.
    pub helps: &'static [Need],
}

/// A typical case of an effect and the view that shows it best.
pub struct Example {
    /// Id on machine table-bc.
    pub id: &'static str,
    /// Shape numbers, inside units.
    pub shape: &'static [f64],
    /// Parameters that are not zero: name and value on the screen.
    pub values: &'static [(&'static str, f64)],
    /// How it is drawn.
    pub view: View,
}

/// What a picture of an effect shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// Readings of an R-test at rest over B and C.
    Poses,
    /// Readings of an R-test while C turns both ways, B tilted, linear axes following.
    Turn,
    /// Radius of a circle in X and Y, both ways, drawn enlarged around it; for each feed in mm/min.
    Circle(&'static [f64]),
    /// Displacement of the tool against the table over this many seconds.
    Time(f64),
    /// The same while the axis of the effect turns a little, stands, and turns on.
    StopAndGo,
    /// Error of the reading over the deflection along the nest's X.
    Deflection,
}
