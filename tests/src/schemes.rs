//! Every measurement scheme over many seeds: how far its numbers are from the injected values, in standard uncertainties.

#[expect(clippy::unwrap_used, reason = "helpers of tests may panic")]
pub mod judged;
#[expect(clippy::unwrap_used, reason = "helpers of tests may panic")]
pub mod named;
pub mod rows;
mod table;
mod trial;
#[expect(clippy::unwrap_used, reason = "helpers of tests may panic")]
pub mod volumetric;

use crate::carried;
pub use table::{NOISES, SECTION, Tried, line};
pub use trial::{NoiseKind, trial};
