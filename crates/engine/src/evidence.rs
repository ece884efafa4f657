//! Evidence of one group of columns against nothing, averaged over the noise bank.
//!
//! ln BF = ½(ν − k) ln(1 + g) − ½ ν ln(1 + g(1 − R²))                                            [docs/design/statistics.md §2]
//!
//! R²: share of the whitened, projected residual that the k surviving columns explain. Everything that is already in the
//! model is projected out first, so that what the model can imitate scores nothing. g: information of one unit in what survives,
//! readings × mean share of the columns' squares that survives; an effect of which a tenth survives is expected to explain a tenth
//! as much. Each member of the noise bank weighs in with its marginal likelihood −½ ln det − ½ ν ln rss.
//!
//! Besides the kernels of [`crate::noise::machine_noise`], a machine has small repeatable error motions of its axes that nobody
//! would call a missing effect. They enter as random columns U with variance ρ: Σ + ρ U Uᵀ, which is a soft projection onto the
//! eigenvectors f_j of Uᵀ Σ⁻¹ U with weight ρ d_j / (1 + ρ d_j).

mod algebra;
mod bank;
mod context;
mod library;
mod member;
mod part;

pub use algebra::{parallel, stacked};
pub use bank::{Bank, Score, Situation, WHITE};
pub use context::Blocks;
pub use library::{Entry, Group, Library, Natural};

/// Directions that keep less than this share of their norm are taken as imitated by the model.
pub const SURVIVAL: f64 = 0.03;
