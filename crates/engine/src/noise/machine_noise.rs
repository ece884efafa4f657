//! Noise as real machines make it, and how to whiten it in one pass over time.
//!
//! For the plan of a next cycle, whose readings nobody has yet; fits and diagnoses learn their noise (`noise::learned`).
//!
//! Σ = σ² (I + a·K_pass + c·K_axis + w·K_drift)                                    [docs/design/statistics.md §1.1, §1.2]
//! - K_pass: the slow rotary axis is positioned again with an angle of its own, constant until it moves again;
//! - K_axis: the fast rotary axis scatters at every point;
//! - K_drift: tool against table drifts in machine axes, Ornstein–Uhlenbeck with correlation time τ.
//!
//! Each kernel has mean variance 1 per reading, so a, c, w are variances in units of the white noise. A Kalman filter with
//! the state (drift x y z, angle of the slow axis) turns readings into independent innovations; its gains do not depend on the
//! data, so whitening is a linear operator W with W Σ Wᵀ = σ² I, applied to any number of columns in O(rows).

mod motions;
mod order;
mod whitener;

pub use motions::{modulated, unit_columns};
pub use order::{Noise, Order, ground_joint};
pub use whitener::Whitener;
