//! What putting an effect into a model, or taking it out, can fail on.

use trunnion_engine::{DiagnoseError, IdentifyError};

/// What an analysis can fail on.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// The fit failed.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// The diagnosis failed.
    #[error("looking for missing effects failed")]
    Diagnose(#[from] DiagnoseError),
    /// A formula that nobody proposed.
    #[error(
        "there is no expression for {id}: the diagnosis proposes {proposed}; \
         give one with --site axis:B --component dz --expression \"k*sin(2*B)\", or write it into the model file"
    )]
    NoSuchFormula {
        /// What was asked for.
        id: String,
        /// What the diagnosis proposes now.
        proposed: String,
    },
    /// An expression for an effect that has its own.
    #[error("{id} has an equation of its own; site, component, expression and grid belong to formula:NAME")]
    NoFormula {
        /// What was asked for.
        id: String,
    },
    /// An effect that is not there.
    #[error("the model does not hold {id}; it holds {held}")]
    NotInModel {
        /// What was asked for.
        id: String,
        /// What can be removed.
        held: String,
    },
    /// An effect that every model has.
    #[error("{id} is in every model and cannot be removed; fix its parameters in the model file instead")]
    Base {
        /// What was asked for.
        id: String,
    },
}
