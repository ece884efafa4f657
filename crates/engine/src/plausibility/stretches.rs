//! Stretches of one value, and what stands out of its kind.
//!
//! Lengths of stretches have an exponential tail of some scale τ. Then the longest of them exceeds the second longest by an exponential of
//! the same τ, whatever their number [Rényi 1953]: P(L₁ − L₂ > x) = e^(−x/τ). L₂ is no smaller than τ and stands for it. So it is of
//! other sizes with such a tail; those with a shorter one (Gaussian) stand out by themselves more seldom still.

use std::ops::RangeInclusive;

/// Chance of a size that large where nothing is wrong.
const CHANCE: f64 = 1e-4;

/// Whether the largest is too large next to the second largest.
pub(super) fn stands_out(largest: f64, second: f64) -> bool {
    largest - second > second * CHANCE.recip().ln()
}

/// Neighbours of one value: from the first to the last of them, and how many of them count.
#[derive(Clone, Copy)]
pub(super) struct Stretch {
    pub first: usize,
    pub last: usize,
    pub length: usize,
}

/// Stretches in their order; `counts`: whether one that is the same as the one before it counts.
pub(super) fn stretches(
    of: RangeInclusive<usize>,
    is_same: impl Fn(usize, usize) -> bool,
    counts: impl Fn(usize) -> bool,
) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for at in of {
        match found.last_mut() {
            Some(last) if is_same(at, last.first) => {
                last.last = at;
                last.length += usize::from(counts(at));
            }
            _ => found.push(Stretch { first: at, last: at, length: 1 }),
        }
    }
    found
}
