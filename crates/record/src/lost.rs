//! What the recorder lost, as one gap.

use trunnion_core::Gap;

/// Source of the gaps of the recorder itself.
const SOURCE: &str = "recorder";

/// Adds lost samples to a gap, which is begun with this reason where there is none.
pub fn add(gap: &mut Option<Gap>, (from_s, to_s): (f64, f64), samples: u64, reason: &str) {
    let gap = gap.get_or_insert_with(|| Gap {
        source: SOURCE.into(),
        from_s,
        to_s,
        lost_samples: Some(0),
        reason: reason.into(),
    });
    gap.from_s = gap.from_s.min(from_s);
    gap.to_s = gap.to_s.max(to_s);
    gap.lost_samples = gap.lost_samples.map(|lost| lost + samples);
}
