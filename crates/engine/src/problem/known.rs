//! Fits of the points of a problem that somebody made before.

use crate::fit::identification::Identification;
use std::fmt::Debug;
use trunnion_effects::Model;

/// Who keeps fits of one experiment, made with the default options. A fit that is given is the one that would be made, to the bit.
pub trait KnownFits: Debug + Sync {
    /// The fit of a model, where it is known.
    fn fit(&self, model: &Model) -> Option<Identification>;
    /// A fit that was made.
    fn made(&self, model: &Model, fit: &Identification);
}
