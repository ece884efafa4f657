//! Noise learned from the run itself (docs/design/statistics.md §1).
//!
//! y = X b + e,   e ~ N(0, Σ),   Σ = s² (W + Σ_k ρ_k² K_k),   ln ρ_k ~ N(ln m_k, σ_k²),   b and ln s flat
//!
//! Every kernel K_k is one thing that machines do in addition to what they are asked: offsets of passes, re-positioning, drift, a smooth
//! pattern that repeats. It has mean variance 1 per reading, so that ρ_k is its size in units of the white noise s. The sizes are
//! learned by restricted maximum likelihood with the prior above, for each run and again with every effect that is weighed.

mod choice;
mod compressed;
mod dense;
pub(crate) mod display;
mod field;
mod frame;
pub(crate) mod kernel;
pub(crate) mod kernels;
mod lattice;
pub(crate) mod mode;
pub(crate) mod posterior;
mod proposal;
pub(crate) mod remainder;
pub(crate) mod sigma;
mod size;
pub(crate) mod tails;

/// Precision of the large matrices.
pub(crate) type Real = f32;
