//! Rows in which every channel reads exactly zero.
//!
//! An instrument that is zeroed once a pass shows one such row a pass. More of them are a zero that was set again and again, or readings
//! that were missing and were written as 0.

use super::Channels;
use crate::Experiment;
use crate::plausibility::found::{Implausible, plain};
use crate::plausibility::shown::SAME_MM;
use crate::problem::passes::passes;

/// Fewer such rows are chance, or no harm.
const FEWEST: usize = 3;

impl Channels<'_> {
    pub(super) fn zeros(&self) -> Option<Implausible> {
        let count = self.points.len();
        let channels: Vec<usize> = (0..self.names().len()).collect();
        let is_zero = |at: &usize| channels.iter().all(|&one| self.value_mm(one, *at).abs() < SAME_MM);
        let zeros: Vec<usize> = (0..count).filter(is_zero).collect();
        if zeros.len() < FEWEST || zeros.len() == count {
            return None;
        }
        let passes = passes(&Experiment::of_points(std::slice::from_ref(self.run)).ok()?).passes;
        if zeros.len() <= passes || !self.would_move(&channels, zeros.iter().copied()) {
            return None;
        }
        let rows: Vec<String> = zeros.iter().take(FEWEST).map(|&at| self.rows[at].to_string()).collect();
        Some(plain(
            format!(
                "{}: in {} of {count} points of setup {} every channel reads exactly 0 (rows {}, …), where the machine is not at rest.",
                self.run.name,
                zeros.len(),
                self.run.setups[self.setup].name,
                rows.join(", ")
            ),
            "Missing readings were written as 0, or the probes were zeroed again and again. Leave out rows without a reading, zero \
             once before the first pose, and measure again.",
        ))
    }
}
