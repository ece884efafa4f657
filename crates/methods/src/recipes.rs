//! Named methods: closed recipes of the literature, one file each, one line in [`REGISTRY`].
//!
//! A method takes runs and returns [`Findings`]; it does what its source does, with the source's slips mended (docs/design/physics.md §8),
//! so that its figures can be compared with the source and with the joint fit. A test walks the directory and the list.

mod ball_bar;
mod circular;
mod error_map;
mod rotary_values;
mod two_height;

use crate::Findings;
use trunnion_core::{AxisLetter, names};
use trunnion_cycles::Run;
use trunnion_engine::{ExperimentError, IdentifyError};

/// Every named method.
pub static REGISTRY: [&Method; 5] =
    [&two_height::METHOD, &error_map::METHOD, &rotary_values::METHOD, &ball_bar::METHOD, &circular::METHOD];

/// A closed recipe of the literature.
#[derive(Debug)]
pub struct Method {
    /// Name of the file with `-` for `_`, e.g. `two-height`.
    pub name: &'static str,
    /// Short title.
    pub title: &'static str,
    /// Where the recipe comes from, e.g. "S0 (Kenno 2020), eq. 1–3".
    pub source: &'static str,
    /// What it does, in a sentence or two for a technician.
    pub about: &'static str,
    /// What the runs must hold.
    pub needs: &'static str,
    /// What it finds.
    pub gives: &'static str,
    /// The recipe.
    pub run: fn(&[Run], &MethodOptions) -> Result<Findings, MethodError>,
}

/// What a user may ask of a method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MethodOptions {
    /// The axis to judge; by default the one that turns alone.
    pub axis: Option<AxisLetter>,
    /// Signs of the values.
    pub convention: Convention,
}

/// Signs of the values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convention {
    /// Actual minus nominal, rotations right-handed (docs/design/physics.md §1).
    #[default]
    RightHanded,
    /// As the source of the method prints them.
    Source,
}

impl Convention {
    /// Every convention with its name on the command line.
    pub const NAMES: [(&'static str, Self); 2] =
        [("right-handed", Self::RightHanded), ("source", Self::Source)];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, convention)| *convention == self).expect("every convention is listed").0
    }
}

/// Why a method cannot be applied.
#[derive(Clone, Debug, thiserror::Error)]
pub enum MethodError {
    /// No method has this name.
    #[error("there is no method \"{name}\"; allowed: {allowed}")]
    Unknown {
        /// As asked.
        name: String,
        /// Every name.
        allowed: String,
    },
    /// The runs lack what the method needs.
    #[error("method {method} cannot use these runs: {found}. It needs {needs}. {next}")]
    Lacks {
        /// Name of the method.
        method: &'static str,
        /// What is wrong with the runs, without a full stop.
        found: String,
        /// [`Method::needs`].
        needs: &'static str,
        /// What to do.
        next: String,
    },
    /// The runs do not belong together.
    #[error("the runs cannot be used together")]
    Runs(#[from] ExperimentError),
    /// A joint fit that the method compares with or builds on failed.
    #[error("fitting the runs")]
    Fit(#[from] IdentifyError),
}

/// The method of this name.
///
/// # Errors
/// With every allowed name.
pub fn find(name: &str) -> Result<&'static Method, MethodError> {
    REGISTRY.into_iter().find(|method| method.name == name).ok_or_else(|| MethodError::Unknown {
        name: name.into(),
        allowed: names::allowed(name, REGISTRY.map(|method| method.name)),
    })
}

impl Method {
    /// The error of runs that lack something. `found`: what is wrong, without a full stop; `next`: what to do, a sentence.
    pub fn lacks(&self, found: impl Into<String>, next: impl Into<String>) -> MethodError {
        MethodError::Lacks { method: self.name, found: found.into(), needs: self.needs, next: next.into() }
    }
}

/// Runs of one machine, one at least: what every method checks first.
pub(crate) fn one_machine(runs: &[Run]) -> Result<&trunnion_machine::Machine, MethodError> {
    let first = runs.first().ok_or(ExperimentError::NoRun)?;
    match runs.iter().find(|run| run.machine != first.machine) {
        None => Ok(&first.machine),
        Some(other) => Err(MethodError::Runs(ExperimentError::DifferentMachines {
            run: other.name.clone(),
            found: other.machine.name.clone(),
            first: first.name.clone(),
            expected: first.machine.name.clone(),
        })),
    }
}
