//! Rows in which every channel reads exactly zero.
//!
//! An instrument that is zeroed once a pass shows one such row a pass. More of them are a zero that was set again and again, or readings
//! that were missing and were written as 0.

use super::Channels;
use crate::Experiment;
use crate::plausibility::chance::Displayed;
use crate::plausibility::found::{Implausible, plain};
use crate::plausibility::shown::SAME_MM;
use crate::problem::passes::passes;

/// Fewer such rows are chance, or no harm.
const FEWEST: usize = 3;
/// Readings that cross zero are so many steps of the display away from it about as often as at it.
const NEAR_STEPS: f64 = 2.0;
/// Zeros are no crossings where they come so many times as often as each combination of values next to zero: as an end of a range does.
const TIMES: usize = super::CLIPPED_TIMES;

impl Channels<'_> {
    pub(super) fn zeros(&self) -> Option<Implausible> {
        let count = self.points.len();
        let channels: Vec<usize> = (0..self.names().len()).collect();
        let is_zero = |at: &usize| channels.iter().all(|&one| self.value_mm(one, *at).abs() < SAME_MM);
        let zeros: Vec<usize> = (0..count).filter(is_zero).collect();
        if zeros.len() < FEWEST || zeros.len() == count {
            return None;
        }
        let near_mm = (NEAR_STEPS + 0.5) * self.shown().step_mm;
        let is_near = |at: &usize| channels.iter().all(|&one| self.value_mm(one, *at).abs() < near_mm);
        let next_to_zero = (0..count).filter(is_near).count().saturating_sub(zeros.len());
        let combinations = (2 * NEAR_STEPS as usize + 1).pow(channels.len() as u32) - 1;
        if zeros.len() * combinations <= TIMES * next_to_zero {
            return None;
        }
        let passes = passes(&Experiment::of_points(std::slice::from_ref(self.run)).ok()?).passes;
        if zeros.len() <= passes || !self.would_move(&channels, zeros.iter().copied()) {
            return None;
        }
        if Displayed::of(self.run, self.setup).is_some_and(|displayed| !displayed.zeros().is_no_chance()) {
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
