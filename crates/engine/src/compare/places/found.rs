//! A box of readings: one component, a range of one or two axes, directions of travel, a setup.

use trunnion_core::Joint;

/// Which directions of travel a box holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Every point.
    All,
    /// Points with the axis going forward.
    Forward(Joint),
    /// Points with the axis going back.
    Back(Joint),
    /// Points with the axis going either way, the sign turned over with it.
    Turns(Joint),
}

/// A box and what its mean explains.
#[derive(Clone, Debug)]
pub struct Found {
    pub component: usize,
    pub setup: Option<usize>,
    pub way: Way,
    /// Dimension, first and last bin; on a full turn the last may lie before the first.
    pub ranges: Vec<(usize, usize, usize)>,
    pub readings: usize,
    pub mean_um: f64,
    /// n m², µm².
    pub explains: f64,
    /// What it explains less the price of naming it, µm².
    pub worth: f64,
}

impl Found {
    /// True for a point with these bins in this setup.
    pub fn holds(&self, bins: &[usize], setup: usize) -> bool {
        let in_ranges = self.ranges.iter().all(|&(d, from, to)| within(bins[d], from, to));
        in_ranges && self.setup.is_none_or(|own| own == setup)
    }
}

fn within(bin: usize, from: usize, to: usize) -> bool {
    if from <= to { (from..=to).contains(&bin) } else { bin >= from || bin <= to }
}
