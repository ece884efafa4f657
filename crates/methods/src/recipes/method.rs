//! What a method is.

use super::convention::Convention;
use crate::Findings;
use trunnion_core::Joint;
use trunnion_cycles::Run;
use trunnion_engine::{ExperimentError, IdentifyError};

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
    /// Whether a user may choose the axis to judge ([`MethodOptions::axis`]).
    pub takes_axis: bool,
    /// Whether its source has signs of its own ([`MethodOptions::convention`]).
    pub takes_convention: bool,
    /// What the runs must hold.
    pub needs: &'static str,
    /// What it finds.
    pub gives: &'static str,
    /// The recipe.
    pub(super) run: fn(&[Run], &MethodOptions) -> Result<Findings, MethodError>,
}

/// What a user may ask of a method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MethodOptions {
    /// The axis to judge; by default the one that turns alone.
    pub axis: Option<Joint>,
    /// Signs of the values.
    pub convention: Convention,
    /// How much larger maps of places draw deviations than they are; by default what suits their size.
    pub magnification: Option<f64>,
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
    /// An axis was asked for, and the method judges none by itself.
    #[error("method {method} judges all axes of the runs together: leave out the axis {axis}")]
    NoAxis {
        /// Name of the method.
        method: &'static str,
        /// The axis.
        axis: Joint,
    },
    /// The signs of the source were asked for, and it has none of its own.
    #[error(
        "method {method} has one convention of signs, which is right-handed: leave out the convention of the source"
    )]
    NoConvention {
        /// Name of the method.
        method: &'static str,
    },
    /// The runs do not belong together.
    #[error("the runs cannot be used together")]
    Runs(#[from] ExperimentError),
    /// A joint fit that the method compares with or builds on failed.
    #[error("fitting the runs")]
    Fit(#[from] IdentifyError),
}

impl MethodError {
    /// True where the runs are why, and not what was asked of them.
    pub fn is_of_runs(&self) -> bool {
        match self {
            Self::Lacks { .. } | Self::Runs(_) | Self::Fit(_) => true,
            Self::Unknown { .. } | Self::NoAxis { .. } | Self::NoConvention { .. } => false,
        }
    }
}

impl Method {
    /// Applies it to runs.
    ///
    /// # Errors
    /// When it takes no axis, or its source has no signs of its own, and they are asked for; when the runs lack what it needs.
    pub fn apply(&self, runs: &[Run], options: &MethodOptions) -> Result<Findings, MethodError> {
        match options.axis {
            Some(axis) if !self.takes_axis => Err(MethodError::NoAxis { method: self.name, axis }),
            _ if !self.takes_convention && options.convention == Convention::Source => {
                Err(MethodError::NoConvention { method: self.name })
            }
            _ => (self.run)(runs, options),
        }
    }

    /// Findings of these runs of one machine, without anything found yet.
    pub fn findings(&self, runs: &[Run], convention: Convention) -> Findings {
        let machine = runs.first().map_or_else(String::new, |run| run.machine.name.clone());
        let names = runs.iter().map(|run| run.name.clone()).collect();
        Findings::nothing_yet([self.name, self.source], convention, machine, names)
    }

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
