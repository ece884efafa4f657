//! A value that stands for a missing reading, such as 9999.
//!
//! Loggers write one number where a probe gave none. It comes again in every digit, and lies far from all that was read.

use super::Channels;
use crate::plausibility::found::{Implausible, plain};
use crate::plausibility::shown::SAME_MM;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::signed;

/// One value so far out may be a single wrong reading, which every fit leaves out by itself.
const FEWEST: usize = 2;
/// Farther out than everything else by this factor: digits of the probe and one more. Readings of a machine that come back to a far value come
/// through those between.
const TIMES: f64 = 10.0;
/// Numbers that stand for nothing are 99 µm or more: smaller ones may be read.
const LEAST_MM: f64 = 0.099;

impl Channels<'_> {
    pub(super) fn marked(&self) -> Option<Implausible> {
        self.names().iter().enumerate().find_map(|(channel, name)| {
            let values: Vec<f64> = (0..self.points.len()).map(|at| self.value_mm(channel, at)).collect();
            let farthest = values.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
            let is_marker = |mm: &&f64| (**mm - farthest).abs() < SAME_MM;
            let count = values.iter().filter(is_marker).count();
            let others_mm = values.iter().filter(|mm| !is_marker(mm)).fold(0.0_f64, |most, mm| most.max(mm.abs()));
            let is_far = farthest.abs() >= LEAST_MM && farthest.abs() > TIMES * others_mm && others_mm > 0.0;
            let is_seldom = 2 * count < values.len();
            (count >= FEWEST && is_far && is_seldom).then(|| {
                plain(
                    format!(
                        "{}: {name} reads exactly {} µm in {count} of {} points of setup {}, and no more than {:.1} µm in the others.",
                        self.run.name,
                        signed(um_from_mm(farthest), 2),
                        values.len(),
                        self.run.setups[self.setup].name,
                        um_from_mm(others_mm)
                    ),
                    "The number stands for a missing reading. Leave these cells empty, or leave out the rows, and look why nothing was read.",
                )
            })
        })
    }
}
