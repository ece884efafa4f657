//! u of few degrees of freedom.

use super::significance::BY_CHANCE;
use crate::control_chart::t_beyond;
use trunnion_core::statistics::COVERAGE_95;

/// By what a u of so many degrees of freedom is multiplied, so that ± 1.96 u holds 95 % as with many [GUM G.3.2].
pub(crate) fn widening(freedom: usize) -> f64 {
    t_beyond(BY_CHANCE, freedom) / COVERAGE_95
}
